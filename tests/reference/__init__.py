"""Slow, plain versions written from the papers."""
