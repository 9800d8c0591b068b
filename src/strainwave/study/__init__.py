"""Questions of an engineer, answered by theory and numerics side by side."""

from ..base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
