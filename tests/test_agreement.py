"""Seven drives by every road: no two faces disagree on a number or a verdict (more: `benchmarks/agreement.py`)."""

import numpy as np
import pytest
from agreement import disagreements
from random_projects import project_text

PARTS = {  # with the seed of its numbers
    "torque and gravity": [
        (4, "three slopes", "none", "held", "plain", "mean"),
        (1, "hardening", "none", "position", "gravity", "none"),
    ],
    "gap and softening": [
        (0, "linear", "gap", "position", "plain", "mean"),
        (1, "softening", "none", "held", "coupling", "range"),
        (1, "linear", "gap", "held", "plain", "none"),  # floats in its gap: no motion is stable
    ],
    "hysteresis": [
        (0, "three slopes", "hysteresis", "speed", "coupling", "none"),
        (1, "hardening", "hysteresis", "held", "plain", "range"),
    ],
}


@pytest.mark.slow
@pytest.mark.parametrize("drives", PARTS)
def test_all_faces_say_the_same(drives, tmp_path):
    texts = [project_text(np.random.default_rng(seed), *parts) for seed, *parts in PARTS[drives]]
    assert disagreements(texts, tmp_path) == [[]] * len(texts)
