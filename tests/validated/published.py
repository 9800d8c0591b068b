"""Numbers that others printed: the article, catalogues, other programs' documentation and tests."""

import math
from functools import cache

import numpy as np

import strainwave as sw
from strainwave.files.variants.ranking import ranking
from strainwave.theory.article import reproduce

from .row import Row

ARTICLE = "source article ([theory](theory.md)), "
HD = "Harmonic Drive LLC, CSF/CSG catalogue, p. 50"


@cache
def article_cells():
    return {(c.table, c.parameters, c.case, c.quantity): c.value for c in reproduce().cells}


def article(quantity, *cases, parameters="derived"):
    """Values of Table 4 with what follows from the article's own Table 3."""
    return lambda: [article_cells()["Table 4", parameters, case, quantity] for case in cases]


def derived():
    drive = sw.HDC_40_050
    return drive.mu, drive.omega_0


REGIMES = ("non-resonant", "primary", "superharmonic", "subharmonic")


def tutorial_branches():
    """Motions at omega = 1.1 between the folds, and those of them that are stable."""
    duffing = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 1.0), sw.Harmonic(0.01), 1.1)
    curve = sw.frequency_response(duffing, (0.9, 1.2), harmonics=1)
    there = np.flatnonzero(np.diff(np.sign(curve.omega - 1.1)) != 0)
    return len(there), np.count_nonzero(curve.stable[there])


def basin_fractions():
    wells = sw.Oscillator(1.0, 0.15, sw.Cubic(-1.0, -1.0), sw.Harmonic(0.2), 1.0)
    found = sw.basins(wells, (-2.2, 2.2), (-2.2, 2.2), samples=20_000, seed=4)
    pairs = sorted((a.points[0, 0], f) for a, f in zip(found.attractors, found.fractions, strict=True))
    return [fraction for _, fraction in pairs]


def twists(ratio, sizes, at):
    def found():
        gears = [
            sw.catalogue.gear(f"{'HFUS' if (ratio, size) == (50, 11) else 'CSF'}-{size}-{ratio}") for size in sizes
        ]
        return [1e4 * gear.twist(getattr(gear, at)) for gear in gears]

    return found


def mount_periods():
    passing = sw.gears.order_map(100).order("wave generator 2")
    return [1.0 / passing.frequency_hz(100 * 2.0 * math.pi / day) for day in (86400.0, 86164.0905)]


def resonance_rule():
    return [sw.gears.order_map(50).order("wave generator 2").frequency_hz(450.0 * math.pi / 30.0)]


def back_driving():
    gears = [sw.catalogue.gear(f"RT1-H-CS-{size}-100") for size in (14, 17, 20, 25)]
    return [100.0 * gear.starting_torque / (1.0 - gear.friction.mu) for gear in gears]


def ishigami():
    rng = np.random.default_rng(0)
    x = rng.uniform(-np.pi, np.pi, (3, 8000))
    y = np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])
    rows = {row.path: row.index for row in ranking(dict(zip("abc", x, strict=True)), y).rows}
    return [rows[path] for path in "abc"]


ROWS = (
    Row(
        "HDC-40-050, derived quantities",
        ARTICLE + "Table 3 and its text",
        "damping μ [1/s] and ω₀ [rad/s]",
        ("0.129", "37.2"),
        derived,
        "published/test_article.py::test_parameters_that_follow_from_the_articles_table_3",
        note="they do not follow from its own parameters (errata N1, N2)",
    ),
    Row(
        "HDC-40-050 without resonance",
        ARTICLE + "Table 4",
        "largest error from rest [rad]",
        ("4.8e-3",),
        article("largest |x|, integration", "non-resonant"),
        "strainwave reproduce",
    ),
    Row(
        "HDC-40-050 in primary resonance, α = 1",
        ARTICLE + "Table 4",
        "largest error, steady [rad]",
        ("0.15",),
        article("steady peak", "primary", parameters="alpha 1"),
        "published/test_errata.py::test_n5_the_printed_0_15_rad_is_primary_resonance_with_alpha_1",
        note="α = 1 is what the printed formula means (erratum N5); 0.324 with the α = 0.1 of Table 3",
    ),
    Row(
        "HDC-40-050 in two resonances",
        ARTICLE + "Table 4",
        "largest error from rest [rad]: ω₀/3, 3 ω₀",
        ("0.08", "0.06"),
        article("largest |x|, integration", *REGIMES[2:]),
        "strainwave reproduce",
        note="not reproducible (errata N5b to N7)",
    ),
    Row(
        "HDC-40-050, multiple scales",
        ARTICLE + "Table 4",
        "RMS difference from integration [%], four regimes",
        ("2.1", "4.8", "3.5", "4.2"),
        article("normalised RMS difference", *REGIMES),
        "strainwave reproduce",
        note="not reproducible; ours are smaller",
    ),
    Row(
        "Duffing tutorial of HarmonicBalance.jl",
        "[steady_states.md](https://github.com/NonlinearOscillations/HarmonicBalance.jl/blob/master/docs/src/tutorials/steady_states.md)",
        "motions between the folds, and stable ones",
        ("3", "2"),
        tutorial_branches,
        "published/test_response_curves.py::test_harmonicbalance_jl_tutorial",
    ),
    Row(
        "Two wells (Duffing), basins",
        "Attractors.jl, [attractor_mapping.jl](https://github.com/JuliaDynamics/Attractors.jl/blob/main/test/mapping/attractor_mapping.jl)",
        "shares of the two attractors; known from 1000 states, standard error 0.016",
        ("0.489", "0.511"),
        basin_fractions,
        "numerics/attractors/test_basins.py::test_two_wells_have_the_published_fractions",
        note="within two standard errors",
    ),
    Row(
        "Torsion at T1, ratio 30",
        HD,
        "sizes 8, 11, 14, 17, 20, 25, 32 [1e-4 rad]",
        ("8.5", "9.5", "10.5", "11.5", "12.3", "14.0", "12.1"),
        twists(30, (8, 11, 14, 17, 20, 25, 32), "T1"),
        "model/gears/test_catalogue.py::test_ratio_30_twists_as_the_maker_prints",
    ),
    Row(
        "Torsion at T2, ratio 30",
        HD,
        "the same sizes [1e-4 rad]",
        ("19", "19", "31", "30", "38", "40", "38"),
        twists(30, (8, 11, 14, 17, 20, 25, 32), "T2"),
        "model/gears/test_catalogue.py::test_ratio_30_twists_as_the_maker_prints",
    ),
    Row(
        "Torsion at T1, ratio 50",
        HD,
        "sizes 11, 14, 17, 20, 25, 32, 40 [1e-4 rad]",
        ("3.6", "5.8", "4.9", "5.2", "5.5", "5.5", "5.2"),
        twists(50, (11, 14, 17, 20, 25, 32, 40), "T1"),
        "model/gears/test_catalogue.py::test_ratio_50_twists_within_5_percent_of_what_the_maker_prints",
    ),
    Row(
        "Back-driving torque",
        "Schaeffler TPI 275, RT1-H-CS, ratio 100",
        "sizes 14, 17, 20, 25 [N m]; not fitted",
        ("2.21", "3.06", "3.89", "7.26"),
        back_driving,
        "study/gear/test_efficiency.py::test_the_back_driving_torque_that_follows_is_near_the_catalogues",
    ),
    Row(
        "Period of two telescope mounts, ratio 100",
        "[DHEM](https://github.com/polvinc/DHEM); Rainbow RST-135 in the wiki of PHD2",
        "seconds",
        ("432", "430.82"),
        mount_periods,
        "model/test_orders.py::test_period_of_a_telescope_mount_is_the_published_one",
    ),
    Row(
        "Vendor's resonance rule",
        "Harmonic Drive, CSF-3 manual, ch. 8",
        "resonance met at 450 rpm [Hz]",
        ("15",),
        resonance_rule,
        "model/test_orders.py::test_vendors_resonance_rule_is_order_two",
    ),
    Row(
        "Ishigami function",
        "Saltelli et al. 2008, *Global Sensitivity Analysis*",
        "first-order indices S1, S2, S3",
        ("0.3139", "0.4424", "0.0000"),
        ishigami,
        "files/variants/test_ranking.py::test_first_order_indices_of_the_ishigami_function",
        note="from 8000 points: within three standard errors",
    ),
)
