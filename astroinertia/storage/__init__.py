"""Run folders and other files: whole or absent, known by their hash, and read within bounds."""
