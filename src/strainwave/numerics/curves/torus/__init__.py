"""Motions of two turns, the motor's and the output's, which repeat together rarely or never: balance on a torus."""
