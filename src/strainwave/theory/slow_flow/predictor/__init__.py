"""The slow flow sample by sample, for a controller: scalar code, compiled, run as Python or written out as C."""
