"""The drive: its project, its response, its linear motions and runs."""
