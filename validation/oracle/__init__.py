"""Independent reference solver of the motor with contact: event-driven, slow, in plain shape coordinates.

It shares no code with the package it judges.
"""
