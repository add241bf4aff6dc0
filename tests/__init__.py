"""Tests, in the folders of the package; `reference` has slow, plain versions of its methods."""
