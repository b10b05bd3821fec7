"""The contract of a contact law: the runs it is checked on, its properties, and pytest's way in."""
