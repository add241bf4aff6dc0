"""Scenes that Mitsuba renders, if it is installed."""
