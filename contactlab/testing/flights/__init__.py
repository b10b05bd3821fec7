"""Free flights whose touch-downs are known, drawn at random and shaped on purpose."""
