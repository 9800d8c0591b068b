"""Classes of what the functions return; each says what it has and draws itself."""

from .base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
