"""Studies of laws and measurements: fit, validate, synthetic and bench."""
