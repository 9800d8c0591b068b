"""The response through a speed range: curve, jumps, closed branches."""
