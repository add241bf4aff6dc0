"""Tests of `envlights.environment.layouts`."""
