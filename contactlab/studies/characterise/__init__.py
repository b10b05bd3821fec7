"""The data sheet of a motor: its numbers at prescribed speeds and under loads once it has settled."""
