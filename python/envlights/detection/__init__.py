"""Bright places of a map, as lights."""
