"""H-infinity and LPV synthesis with proved gains, mu analysis, and autopilots for underwater vehicles."""

from squid_lpv._core import __version__
from squid_lpv.analysis import LpvGain, Mu, Performance, hinfnorm, lpvgain, mu
from squid_lpv.certificates import Certificate, Theorem
from squid_lpv.errors import InfeasibleError, InputError, NumericalError, SquidError
from squid_lpv.mat import loadmat, savemat
from squid_lpv.synthesis import (
    H2Synthesis,
    HinfSynthesis,
    LpvController,
    LpvSynthesis,
    MixSynthesis,
    MuSynthesis,
    Proved,
    augw,
    h2syn,
    hinfsyn,
    hinfsyn_proved,
    lpvsyn,
    mixsyn,
    musyn,
)
from squid_lpv.systems import StateSpace
from squid_lpv.vehicles import Autopilot, Design, Flight, Linearisation, Trim, Vehicle

__all__ = [
    "Autopilot",
    "Certificate",
    "Design",
    "Flight",
    "H2Synthesis",
    "HinfSynthesis",
    "InfeasibleError",
    "InputError",
    "Linearisation",
    "LpvController",
    "LpvGain",
    "LpvSynthesis",
    "MixSynthesis",
    "Mu",
    "MuSynthesis",
    "NumericalError",
    "Performance",
    "Proved",
    "SquidError",
    "StateSpace",
    "Theorem",
    "Trim",
    "Vehicle",
    "__version__",
    "augw",
    "h2syn",
    "hinfnorm",
    "hinfsyn",
    "hinfsyn_proved",
    "loadmat",
    "lpvgain",
    "lpvsyn",
    "mixsyn",
    "mu",
    "musyn",
    "savemat",
]
