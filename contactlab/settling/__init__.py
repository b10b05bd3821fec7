"""Whether a motor has settled, to what, and what kind of motion it shows: from numbers of its periods."""
