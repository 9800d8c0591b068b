"""The article's tables and their check."""
