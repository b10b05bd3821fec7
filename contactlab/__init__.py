"""contactlab: contact laws of standing-wave piezoelectric motors, compared on one resonator model."""
