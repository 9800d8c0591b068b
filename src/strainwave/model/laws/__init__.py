"""Torsion laws: springs, backlash, hysteresis and friction, tables of measured values."""

from ...base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
