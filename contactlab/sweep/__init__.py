"""Many runs: what became of each, and their metrics in one dataset over the parameters."""
