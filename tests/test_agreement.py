"""Six drives by every road: no two faces disagree on a number or a verdict (more: `benchmarks/agreement.py`)."""

import numpy as np
import pytest
from agreement import disagreements
from random_projects import project_text

PARTS = {
    "three slopes, held, under a torque": ("three slopes", "none", "held", "plain", "mean"),
    "hardening, position loop, gravity": ("hardening", "none", "position", "gravity", "none"),
    "hysteresis, speed loop with friction, coupling": ("three slopes", "hysteresis", "speed", "coupling", "none"),
    "hysteresis, held, a range of loads": ("hardening", "hysteresis", "held", "plain", "range"),
    "gap, position loop, under a torque": ("linear", "gap", "position", "plain", "mean"),
    "softening, held, gravity": ("softening", "none", "held", "gravity", "none"),
}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    texts = [project_text(np.random.default_rng(i), *parts) for i, parts in enumerate(PARTS.values())]
    return dict(zip(PARTS, disagreements(texts, tmp_path_factory.mktemp("drives")), strict=True))


@pytest.mark.compiled
@pytest.mark.parametrize("drive", PARTS)
def test_all_faces_say_the_same(found, drive):
    assert found[drive] == []
