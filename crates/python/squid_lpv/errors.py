"""What can go wrong, in three kinds."""


class SquidError(Exception):
    """Base of the three kinds."""


class InfeasibleError(SquidError):
    """There is provably no solution; the message says why."""


class NumericalError(SquidError):
    """Nothing was concluded; the message says where it ended."""


class InputError(SquidError, ValueError):
    """What was given is wrong; the message names it, what was found, and what is allowed."""
