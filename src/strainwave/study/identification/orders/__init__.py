"""Lines of a measured quantity over an angle: orders from runs over any part of a turn, and from whole turns."""
