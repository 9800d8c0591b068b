"""A joint from its log: a load behind a gear whose motor is held on its measured angle."""
