"""What a run ends with when the code of a law fails."""


class LawError(RuntimeError):
    """A law contradicts itself, or its own code raised an exception, which is the cause of this one."""
