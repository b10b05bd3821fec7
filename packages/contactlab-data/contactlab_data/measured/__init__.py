"""Measured impacts and series: files, consistency checks, noise, and lower bounds of errors."""
