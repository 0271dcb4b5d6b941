"""Exceptions of three kinds."""


class SquidError(Exception):
    """Base class of all exceptions of this package."""


class InfeasibleError(SquidError):
    """No solution exists, as computed in floating point, or none within a limit; the message gives the reason."""


class NumericalError(SquidError):
    """The computation was inconclusive; the message says where it ended."""


class InputError(SquidError, ValueError):
    """An argument is invalid; the message gives its name, its value, and the allowed values."""
