"""The symbols of the derivation, and its equations as text, LaTeX and MathML."""

from collections import namedtuple
from typing import Any

from . import sp

Row = tuple[str, Any, str, Any]  # title, left side, sign, right side


class Symbols(
    namedtuple(
        "Symbols",
        "J_m J_l N B K alpha J T_m T_l theta_m theta_l theta_m_rate theta_l_rate "
        "theta_m_acceleration theta_l_acceleration x v a mu omega_0 F omega f e "
        "t T_0 T_1 epsilon sigma A C soft amplitude phase beta a_0 beta_0 amplitude_rate phase_rate beta_rate",
    )
):
    """Every symbol of the derivation; `f` and `e` are undefined functions of one argument.

    `a` is x'', `amplitude` the article's a, `phase` its phi, `soft` the forcing f with A = epsilon f.
    """


# Symbols that LaTeX and MathML would not typeset from their names.
_NAMES = {
    "theta_m_rate": (r"\dot{\theta}_m", "θ̇_m"), "theta_m_acceleration": (r"\ddot{\theta}_m", "θ̈_m"),
    "theta_l_rate": (r"\dot{\theta}_l", "θ̇_l"), "theta_l_acceleration": (r"\ddot{\theta}_l", "θ̈_l"),
    "v": (r"\dot{x}", "ẋ"), "a": (r"\ddot{x}", "ẍ"), "amplitude_rate": (r"\dot{a}", "ȧ"),
    "phase_rate": (r"\dot{\phi}", "φ̇"), "beta_rate": (r"\dot{\beta}", "β̇"),
}  # fmt: skip


def symbols() -> Symbols:
    """Make the symbols.

    Raises
    ------
    ModuleNotFoundError
        If SymPy is not installed.
    """
    if sp is None:
        raise ModuleNotFoundError("the derivation needs SymPy, which is not installed; pip install 'strainwave[sym]'")
    positive: tuple[Any, ...] = sp.symbols("J_m J_l N B K", positive=True)
    alpha, torque_m, torque_l = sp.symbols("alpha T_m T_l", real=True)
    motion: tuple[Any, ...] = sp.symbols("theta_m theta_l theta_m' theta_l' theta_m'' theta_l'' x x' x''", real=True)
    mu, omega_0, inertia = sp.symbols("mu omega_0 J", positive=True)
    forcing, omega = sp.symbols("F omega", real=True)
    functions = sp.Function("f"), sp.Function("e")
    loads = alpha, inertia, torque_m, torque_l
    before = (*positive, *loads, *motion, mu, omega_0, forcing, omega, *functions)
    slow: tuple[Any, ...] = sp.symbols("t T_0 T_1 epsilon sigma A C f a phi beta a_0 beta_0 a' phi' beta'", real=True)
    return Symbols._make((*before, *slow))._replace(amplitude=sp.Symbol("a", positive=True))


class Steps:
    """Equations that follow from each other, each with a title."""

    symbols: Symbols

    @property
    def title(self) -> str:
        """Title of the equations, without symbols."""
        raise NotImplementedError

    @property
    def parts(self) -> tuple["Steps", ...]:
        """The derivation in parts, each with equations of its own."""
        return (self,)

    def rows(self) -> list[Row]:
        """Title, left side, sign and right side of each equation of this part."""
        raise NotImplementedError

    def latex(self) -> str:
        """Every step: a LaTeX `aligned` environment for each part, to be put in a display formula."""
        return "\n\n".join(part.aligned() for part in self.parts)

    def __str__(self) -> str:
        return "\n\n".join(part._lines() for part in self.parts)

    def mathml(self) -> list[tuple[str, str]]:
        """Title and presentation MathML of each equation of this part."""
        s, rows = self.symbols, self.rows()
        names = {getattr(s, field): sp.Symbol(name) for field, (_, name) in _NAMES.items()}

        def side(expression: Any) -> str:
            shown = _short(expression, s).xreplace(names | {_mark(s): sp.Symbol("e′")})
            return str(sp.mathml(shown, printer="presentation")).replace("<mo>-</mo>", "<mo>−</mo>")

        signs = {"=": "=", "<": "&lt;", ">": "&gt;"}
        return [(title, f"{side(left)}<mo>{signs[sign]}</mo>{side(right)}") for title, left, sign, right in rows]

    def aligned(self) -> str:
        """LaTeX `aligned` environment of this part."""
        s = self.symbols
        names = {getattr(s, field): tex for field, (tex, _) in _NAMES.items()}
        names |= {_mark(s): r"e'(\theta_m)", sp.Symbol("F_printed"): r"F_\mathrm{printed}"}
        lines = [rf"&\textbf{{{self.title}}}"]
        for title, left, sign, right in self.rows():
            sides = [sp.latex(_short(side, s), symbol_names=names) for side in (left, right)]
            lines.append(rf"&\text{{{title}:}} && {f' {sign} '.join(sides)}")
        return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"

    def _lines(self) -> str:
        rows, s = self.rows(), self.symbols
        width = max(len(title) for title, *_ in rows)
        lines = [self.title]
        for title, left, sign, right in rows:
            sides = [" ".join(sp.sstr(_short(side, s)).split()) for side in (left, right)]  # a matrix on one line
            lines.append(f"{title:<{width}}  {f' {sign} '.join(sides)}")
        return "\n".join(lines)


def _mark(s: Symbols) -> Any:
    return sp.Symbol(f"e'({s.theta_m})")


def _short(expression: Any, s: Symbols) -> Any:
    """Write de/dtheta_m as one mark, for print."""
    return sp.sympify(expression).subs(sp.diff(s.e(s.theta_m), s.theta_m), _mark(s))
