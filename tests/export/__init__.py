"""Tests of `envlights.export`."""
