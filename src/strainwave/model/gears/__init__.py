"""Gears: the catalogue with its sources, fits of laws, limits, spectra of the kinematic error."""

from ...base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
