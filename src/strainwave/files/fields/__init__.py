"""The fields of a project file: their table, and what reads, describes and writes them."""
