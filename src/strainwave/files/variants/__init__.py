"""Projects with other numbers in their files: one of them, a grid, a sample."""
