"""Tests of `envlights.transfer`."""
