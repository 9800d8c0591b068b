"""A measured response curve: computed points with sensitivities, and the fit."""
