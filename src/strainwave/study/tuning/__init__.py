"""Best gains of the motor's loop: goals and limits, the search, its result."""
