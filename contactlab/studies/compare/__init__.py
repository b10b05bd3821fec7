"""The study `compare`: laws on one motor, over what is uncertain of it, and against measurements."""
