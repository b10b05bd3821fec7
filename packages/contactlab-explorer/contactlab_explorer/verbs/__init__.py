"""Verbs that this package adds to the command, a module each."""
