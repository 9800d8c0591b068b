"""Parts of models and results: units and quantities, contracts of laws, results and their files."""
