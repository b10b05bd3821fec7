"""Many runs, or another study many times, over the values of any key."""
