"""Questions of an engineer, answered by theory and numerics side by side."""
