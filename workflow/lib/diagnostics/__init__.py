"""What measures, stresses and compares the stages."""
