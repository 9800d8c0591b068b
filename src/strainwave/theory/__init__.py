"""Closed forms and proofs: what can be said about the error equation without integrating it."""
