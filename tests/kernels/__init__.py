"""Tests of `envlights.kernels`."""
