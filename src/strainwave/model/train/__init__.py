"""The drive train: motor with its control, shafts and couplings, load, motions and torques."""

from ...base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
