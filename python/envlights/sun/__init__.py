"""The sun of a map: found in the picture, or computed from time and place."""
