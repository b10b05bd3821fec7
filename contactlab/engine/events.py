"""What can end a step early; the loop acts on it after the step is committed."""

NOTHING, TOUCH, RELEASE, REVERSAL, CONE = range(5)
"""No event; the gap closes; the gap opens or the contact would pull; slip changes sign; friction that
sticks reaches its bound."""
