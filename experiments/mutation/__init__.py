"""Errors that somebody could make: the physics broken on purpose, one line at a time."""
