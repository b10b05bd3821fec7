"""The data sheet of a motor: what it does at prescribed velocities and under loads once it has settled."""
