"""Arrays in, numbers out: similarity of images, edge scores and picks of trackers."""
