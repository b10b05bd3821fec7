"""Studies: questions put to motors, each declared once, with one runner, one page and one table path."""
