"""What the ledger asks: a function for each verb, a file for each room."""
