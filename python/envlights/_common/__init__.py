"""Shared helpers: checks, result classes, text and files, without any method of the package."""
