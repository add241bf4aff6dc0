"""Tests of rigs over a sequence."""
