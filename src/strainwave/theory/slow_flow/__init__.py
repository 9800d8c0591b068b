"""Multiple scales: slow flow, steady states, certificate."""
