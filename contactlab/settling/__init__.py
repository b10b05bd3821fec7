"""Whether and to what a motor has settled, from the recorded numbers of its periods."""
