"""Tests of `envlights.comparison`."""
