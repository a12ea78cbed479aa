"""What concerns the process that a run lives in: signals, its children, threads, versions, compiled programs."""
