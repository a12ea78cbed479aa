"""Pages of a run for a browser, one file each: a report, and the body to turn about. They load nothing else."""
