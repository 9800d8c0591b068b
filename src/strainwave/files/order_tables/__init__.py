"""Order tables: what cancels an error order by order, and the files in which drives and controls read it."""
