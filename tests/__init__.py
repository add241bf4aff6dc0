"""Tests, beside the names of what they test; `reference` holds slow, plain versions of it."""
