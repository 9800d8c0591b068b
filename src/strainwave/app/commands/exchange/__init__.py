"""Commands that exchange files and lists: project files, gears, order tables, exports, scripts of shells."""
