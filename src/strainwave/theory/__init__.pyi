"""Closed forms and proofs: what can be said about the error equation without integrating it."""

from .derivation.error_equation import derive as derive
from .derivation.error_equation import derive_arrangement as derive_arrangement

__all__: list[str]
