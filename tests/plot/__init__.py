"""Tests of `envlights.plot`."""
