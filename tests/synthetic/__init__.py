"""Tests of `envlights.synthetic`."""
