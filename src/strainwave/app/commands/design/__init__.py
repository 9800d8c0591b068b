"""Commands that decide: the gear for a specification, and drives side by side."""
