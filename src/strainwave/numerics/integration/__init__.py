"""Integration of one trajectory."""
