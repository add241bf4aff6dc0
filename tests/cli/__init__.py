"""Tests of `envlights.cli`."""
