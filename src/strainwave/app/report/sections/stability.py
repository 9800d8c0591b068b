"""Lyapunov's certificate of the drive without excitation."""

from typing import Any

from ...view import View


class Stability:
    """The proof that the error decays, or the reason without one."""

    heading = "Stability without excitation"
    appendix = True

    def data(self, view: View) -> dict[str, Any]:
        """Scope, claim and region of the proof."""
        proof = view.analysis.stability
        said = {name: getattr(proof, name) for name in ("holds", "scope", "claim", "reason", "obstacle")}
        return {"stability": said | {"region": str(proof.region or "none")}}

    def lines(self, view: View, data: dict[str, Any]) -> list[str]:
        """The proof in a line: its claim, or the reason without one."""
        proof, of = data["stability"], "" if view.analysis.train_curve is None else " of the error equation"
        claim = f"no proof: {proof['obstacle']}" if proof["scope"] == "none" else f"{proof['scope']}; {proof['claim']}"
        return [f"stability{of}: {claim}"]
