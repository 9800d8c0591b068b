"""Speed map: which speeds a drive may run at, over its loads, from its nonlinear response."""
