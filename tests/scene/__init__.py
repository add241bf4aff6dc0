"""Tests of `envlights.scene`."""
