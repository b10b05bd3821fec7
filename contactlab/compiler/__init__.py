"""Numeric kernels: how they are compiled, where their code is kept, and what is said while one waits."""
