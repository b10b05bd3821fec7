"""What keeps many runs from being collected or mapped."""


class CollectingError(ValueError):
    """Runs that cannot be collected; the message is a sentence."""


class MapError(ValueError):
    """A folder that cannot hold a map, or holds a damaged one; the message is a sentence."""


class ChunkGoneError(Exception):
    """A chunk that was there is there no more: another process has merged it, or somebody removed it."""
