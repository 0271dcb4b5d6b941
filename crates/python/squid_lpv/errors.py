"""Errors, in three kinds."""


class SquidError(Exception):
    """Base class of the three kinds."""


class InfeasibleError(SquidError):
    """No solution exists, as computed in floating point, or none within a limit; the message gives the reason."""


class NumericalError(SquidError):
    """The computation was inconclusive; the message says where it ended."""


class InputError(SquidError, ValueError):
    """An argument is wrong; the message names it, the value found, and the values allowed."""
