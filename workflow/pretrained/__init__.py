"""What only makes, and judges, the tracker that comes with the package."""
