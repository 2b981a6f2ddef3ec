"""Arrays in, numbers out: similarity and texture of images, edge scores and picks of trackers."""
