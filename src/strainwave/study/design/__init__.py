"""From what an axis must do to the gears and motors that do it: the search through the catalogue."""
