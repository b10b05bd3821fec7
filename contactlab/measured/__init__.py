"""What was measured: impacts and series of others, read from their files and checked."""
