"""Rest, hunting and stick-slip of a drive with dry friction on its shafts."""
