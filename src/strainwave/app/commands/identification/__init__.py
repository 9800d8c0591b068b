"""Commands that read measurements: loops of torque over torsion."""
