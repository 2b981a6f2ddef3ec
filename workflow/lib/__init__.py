"""What checks and shows: Python for scripts and tests alone, no part of the package."""
