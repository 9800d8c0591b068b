"""The report of an analysis: data, sentences, pages."""
