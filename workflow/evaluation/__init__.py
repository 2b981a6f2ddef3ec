"""What judges and shows a run: nothing on the way from flight to Table III depends on it."""
