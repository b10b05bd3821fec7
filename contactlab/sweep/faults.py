"""What keeps runs from being collected."""


class CollectingError(ValueError):
    """Runs that cannot be collected; the message is a sentence."""
