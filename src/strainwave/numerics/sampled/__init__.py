"""Sampled loops in time: a system between samples, a controller at them, one loop or thousands."""
