"""Measured records, and records made by other integrators from published equations."""

from pathlib import Path

import strainwave as sw

from .row import Row

KINOVA = Path(__file__).resolve().parents[1] / "measured" / "kinova_gen3"
SILVERBOX = "Wigren & Schoukens 2013, ECC, 2933-2938; [nonlinearbenchmark.org](https://www.nonlinearbenchmark.org)"
BOUC_WEN = "equations of Noël & Schoukens ([doi](https://doi.org/10.4121/12967592)); records made by SciPy"
GEN3 = "Kinova Gen3, [dynamic-identification](https://github.com/wissem01chiha/dynamic-identification), commit 44f47d5"


def orders():
    """Orders of the measured torque of joint 7 nearest to 2, 4 and 7 in a turn of the wave generator."""
    log = sw.read_log(KINOVA / "joint_7.csv")
    moving = next(part for part in log.segments() if part.kind == "constant speed")
    found = [line.order for line in sw.order_scan([log.run("torque_from_current", part=moving)]).lines]
    return [min(found, key=lambda order, k=k: abs(order - k)) for k in (200.0, 400.0, 700.0)]


ROWS = (
    Row(
        "Silverbox (an electronic Duffing oscillator)",
        SILVERBOX,
        "error of a free run of 7 identified numbers [mV]: multisine, arrow, its first 32 000",
        (),
        None,
        "python benchmarks/silverbox.py SNLS80mV.csv",
        told=("0.239", "0.312", "0.239"),
        note="0.42 % of the motion in training",
    ),
    Row(
        "Joint 7, ratio 100",
        GEN3,
        "orders of the measured torque; 2, 4, 7 in a turn of the wave generator",
        ("200.0", "400.0", "700.0"),
        orders,
        "study/identification/test_order_scan.py::test_measured_joints_have_the_orders_of_their_wave_generator",
        note="each 95 % interval holds the order",
    ),
    Row(
        "Bouc-Wen benchmark, 6 numbers from the output",
        BOUC_WEN,
        "J, B, K, α, g, d of the law",
        ("2.0", "10.0", "50000", "50000", "800", "-1100"),
        None,
        "python benchmarks/bouc_wen_identified.py",
        told=("1.99997", "9.949", "50033", "49957", "801.4", "-1101.6"),
        note="0.5 % at most; g and d are just outside their 95 % intervals; the fit says it has not converged",
    ),
    Row(
        "The same, tests without noise",
        BOUC_WEN,
        "error of a free run [dB of a metre]: multisine, sweep; the motion is −63.5 and −63.1",
        (),
        None,
        "python benchmarks/bouc_wen_identified.py",
        told=("−137.0", "−142.1"),
        note="73 and 79 dB below the motion",
    ),
    Row(
        "95 % intervals of `order_scan`, 400 made sets for each of four kinds of noise",
        "the lines from which the sets were made",
        "share of the intervals that hold the true value [%]",
        ("95",),
        None,
        "python benchmarks/coverage_orders.py",
        told=("93.25 to 96.75",),
        note="one standard error of a share is 1.1",
    ),
)
