"""Tests of `envlights.layouts`."""
