"""The command: a verb, or without one a run or a sweep composed by Hydra."""
