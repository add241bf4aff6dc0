"""Formats of programs: one file for each, with the cards of a target in a file of its own."""
