"""Solvers by other people: packages that solve the same contact problem with their own methods."""
