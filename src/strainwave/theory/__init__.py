"""Closed forms and proofs: what can be said about the error equation without integrating it."""

from ..base.above import contents

__all__, __getattr__, __dir__ = contents(__name__, __file__)
