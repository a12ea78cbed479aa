"""A body that keeps its shape, or changes it as prescribed: its motion, its ledger and its record."""
