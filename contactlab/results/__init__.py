"""What a run leaves: the dataset, where it came from, the summary."""
