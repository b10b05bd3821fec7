"""What the command does around a run: composing, checking, interrupting, running."""
