"""Training of a transfer model: a basis from pairs, then a matrix from direct light to it."""
