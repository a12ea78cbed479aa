"""The ledger of 3x3 matrices: which effect did what to a body's moments."""
