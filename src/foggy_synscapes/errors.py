"""Errors that a person is meant to read: what, where, what was found, what to do."""


class FoggyError(Exception):
    """The work failed: the command prints the message and ends with status 1."""


class UsageError(FoggyError):
    """The call was wrong: the command prints the message and ends with status 2."""


UNFORESEEN = (ValueError, ArithmeticError, LookupError, TypeError, AttributeError, RecursionError)
"""What an input that no check foresaw ends in; whoever catches it says which input it was."""
