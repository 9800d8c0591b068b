"""Six drives by every road: no two faces disagree on a number or a verdict (more: `benchmarks/agreement.py`)."""

import numpy as np
import pytest
from agreement import disagreements
from random_projects import project_text

PARTS = {
    "torque and gravity": [
        ("three slopes", "none", "held", "plain", "mean"),
        ("hardening", "none", "position", "gravity", "none"),
    ],
    "gap and softening": [
        ("linear", "gap", "position", "plain", "mean"),
        ("softening", "none", "held", "coupling", "range"),
    ],
    "hysteresis": [
        ("three slopes", "hysteresis", "speed", "coupling", "none"),
        ("hardening", "hysteresis", "held", "plain", "range"),
    ],
}


@pytest.mark.compiled
@pytest.mark.parametrize("drives", PARTS)
def test_all_faces_say_the_same(drives, tmp_path):
    texts = [project_text(np.random.default_rng(i), *parts) for i, parts in enumerate(PARTS[drives])]
    assert disagreements(texts, tmp_path) == [[], []]
