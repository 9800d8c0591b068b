"""Make docs/_static/amplification.svg, the figure of the README, from its example."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot as plt

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "docs/_static/amplification.svg"


def main() -> None:
    """Run the example and save its figure, the same bytes each time."""
    sys.path.insert(0, str(ROOT / "examples/speeds"))
    import amplification

    plt.rcParams["svg.hashsalt"] = "s"
    amplification.main()
    plt.savefig(TARGET, metadata={"Date": None})


if __name__ == "__main__":
    main()
