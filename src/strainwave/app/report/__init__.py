"""The report of a drive: `write` and its `SECTIONS`, each of them one object, to which your own can be added."""

from ...base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
