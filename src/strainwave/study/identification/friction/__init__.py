"""Friction from constant-speed runs, break-away and presliding."""
