"""Slow, plain versions written from the papers, and other people's solvers."""
