"""Tests of many maps."""
