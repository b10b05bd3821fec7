"""Inference from measurements: least squares, posteriors by nested sampling, cross-validation of laws."""
