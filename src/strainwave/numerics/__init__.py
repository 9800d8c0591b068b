"""Computing with any system that has `rhs(phase, y)` and `omega`; no model is imported here."""

from ..base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
