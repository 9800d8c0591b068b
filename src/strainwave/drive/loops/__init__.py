"""The loop of a motor as its controller samples it, and how far the loop of a drive is from instability."""
