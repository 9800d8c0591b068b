"""Output of commands: progress and results on the terminal, files, and words for people without Python."""

from ...base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
