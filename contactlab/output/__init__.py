"""What a run leaves: the dataset, the picture, the summary."""
