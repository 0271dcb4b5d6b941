"""What can go wrong, in three kinds."""


class SquidError(Exception):
    """Base of the three kinds."""


class InfeasibleError(SquidError):
    """There is no solution, as computed in floating point, or none within a limit; the message says why."""


class NumericalError(SquidError):
    """Nothing was concluded; the message says where it ended."""


class InputError(SquidError, ValueError):
    """What was given is wrong; the message names it, what was found, and what is allowed."""
