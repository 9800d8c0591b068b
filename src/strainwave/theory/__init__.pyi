"""Closed forms and proofs: what can be said about the error equation without integrating it."""

from .derivation.error_equation import derive as derive

__all__: list[str]
