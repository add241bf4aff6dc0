"""Tests of `envlights.io`."""
