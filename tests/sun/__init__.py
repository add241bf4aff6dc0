"""Tests of `envlights.sun`."""
