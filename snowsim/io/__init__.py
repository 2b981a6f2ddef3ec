"""Files to datasets and back; the only package that opens files."""
