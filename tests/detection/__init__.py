"""Tests of `envlights.detection`."""
