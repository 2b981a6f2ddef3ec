"""What the scripts of the main path share: no part of the package."""
