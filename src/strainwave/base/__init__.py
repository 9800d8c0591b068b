"""What models and results are made of: units and quantities, contracts of laws, results and their files."""
