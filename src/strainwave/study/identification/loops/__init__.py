"""A torsion law from a measured loop of torque over torsion."""
