"""What a steady state is worth: the harmonic balance of the full equation, and the certificate that it gives."""
