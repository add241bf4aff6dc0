"""Tests; `twins` holds slow, plain versions of what they check."""
