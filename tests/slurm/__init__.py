"""A SLURM of the tests' own."""
