"""What measures, charts and compares the stages."""
