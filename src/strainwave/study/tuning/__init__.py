"""Which gains of the motor's loop are best: what they are judged by, the search, its result."""
