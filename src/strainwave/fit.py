"""Numbers of a law, a drive or an error from measurements: fits, scans of orders, intervals, what a model lacks."""

from .base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
