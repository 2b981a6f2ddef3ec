"""Scores of arrays: similarity of images, and edges and picks of trackers."""
