"""Sampled controllers of the motor, what they measure, and the loop that they close around a drive train."""

from ...base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
