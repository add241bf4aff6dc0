"""Tests of `envlights.fitting`."""
