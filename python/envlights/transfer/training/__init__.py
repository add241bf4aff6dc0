"""Training of a transfer model: from pairs to a basis, and from a basis to its matrix."""
