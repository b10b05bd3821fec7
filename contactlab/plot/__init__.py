"""Pictures of a run: the overview, and the animation of tip and rotor."""
