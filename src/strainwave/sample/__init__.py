"""Many drives once: how they vary, one store, and what is made of the results."""

from ..base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
