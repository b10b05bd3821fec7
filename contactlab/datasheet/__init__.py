"""The data sheet of a motor: what it does on belts and under loads once it has settled."""
