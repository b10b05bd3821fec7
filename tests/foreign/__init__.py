"""Judges by other people: packages that solve the same contact problem with their own methods.

They are given the modal matrices of a motor and share nothing else with the package: `problem` says
what they receive, the other modules state it in the words of one foreign package each.
"""
