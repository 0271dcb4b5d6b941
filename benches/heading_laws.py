"""Heading laws simulated on REMUS 100 and LAUV, with the gains that their authors publish.

The equations are implemented from the sources named below; gains and limits are theirs unless `source` says otherwise.
Angles are in rad and not wrapped, which turns of less than 180 deg do not need. A law returns the rudder angle with its
own sign, positive to starboard; that of this vehicle is positive to port.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol


class Law(Protocol):
    """A heading law, called once per tick."""

    def rudder(self, reference: float, heading: float, rate: float) -> float:
        """Return the rudder angle, positive to starboard, from reference, heading and yaw rate of the hull."""


def within(value: float, limit: float) -> float:
    """Return a value, saturated at plus or minus a limit."""
    return max(-limit, min(limit, value))


@dataclass
class Fossen:
    """PID with integral and sliding mode behind a third-order reference model: the law of both PVS and MSS.

    T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd edition, 2021, eq. 16.479 and 12.10.
    MSS: GNC/integralSMCheading.m and GNC/refModel.m; PVS: lib/control.py and lib/guidance.py.
    """

    tick: float
    frequency: float = 0.1  # wn_d; MSS: wn_d_psi
    turn_rate: float = math.radians(5.0)  # r_max
    surface: float = 0.1  # lam; MSS: lambda
    proportional: float = 0.5  # K_d
    switching: float = 0.0  # K_sigma
    layer: float = 0.1  # phi_b
    gain: float = 5.0 / 20.0  # K_nomoto; MSS: K_yaw
    lag: float = 1.0  # T_nomoto; MSS: T_yaw
    damping: float = 1.0  # zeta_d; MSS: zeta_d_psi
    wanted: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    integral: float = 0.0

    def rudder(self, reference: float, heading: float, rate: float) -> float:
        """Return the rudder angle, and advance integral and reference model by a tick."""
        angle, turn, acceleration = self.wanted
        error, rate_error = heading - angle, rate - turn
        off = rate_error + 2.0 * self.surface * error + self.surface**2 * self.integral
        pull = acceleration - 2.0 * self.surface * rate_error - self.surface**2 * error
        switched = self.switching * within(off / self.layer, 1.0)
        self.integral += self.tick * error
        self.follow(reference)
        return (self.lag * pull + rate - off - self.proportional * off - switched) / self.gain

    def follow(self, reference: float) -> None:
        """Advance the reference model by a tick, with Euler's method."""
        angle, turn, acceleration = self.wanted
        w, order = self.frequency, 2.0 * self.damping + 1.0
        jerk = w**3 * (reference - angle) - order * w**2 * turn - order * w * acceleration
        self.wanted = [
            angle + self.tick * turn,
            within(turn + self.tick * acceleration, self.turn_rate),
            acceleration + self.tick * jerk,
        ]


@dataclass
class Dune:
    """Heading loop around a yaw rate loop, both proportional, without a reference model.

    DUNE: src/Control/AUV/Attitude/Task.cpp; Allocator/Task.cpp maps a torque n to fin angles n/(2 `Fin effect N`).
    """

    heading_gain: float = 1.5  # Heading PID Gains
    turn_rate: float = math.radians(30.0)  # Maximum Heading Rate
    rate_gain: float = 1.2  # Heading Rate PID Gains
    fin: float = math.radians(25.0)  # Maximum Fin Rotation
    effect: float = 0.5  # Fin effect N

    def rudder(self, reference: float, heading: float, rate: float) -> float:
        """Return the fin angle."""
        turn = within(self.heading_gain * (reference - heading), self.turn_rate)
        torque = within(self.rate_gain * (turn - rate), self.fin)
        return within(torque / (2.0 * self.effect), self.fin)


@dataclass(frozen=True)
class Peer:
    """A law under comparison, its constructor for a sample time (s), and the source of its gains."""

    name: str
    make: Callable[[float], Law]
    source: str


SIM = "`CRAFT/AUV/SIMremus100.m` of [MSS](https://github.com/cybergalactic/MSS)"
FAST, TURN_RATE = 0.6, math.radians(8.0)
"""Frequency (rad/s) and rate of turn of the reference model of MSS for fast turns; ours. The rate is that to which
vehicles/remus100/design.toml limits the reference."""

PEERS = (
    Peer(
        "PVS",
        lambda tick: Fossen(tick, switching=0.05),
        "`src/python_vehicle_simulator/vehicles/remus100.py` of "
        "[PythonVehicleSimulator](https://github.com/cybergalactic/PythonVehicleSimulator), "
        "`depthHeadingAutopilot`: `lam` 0.1, `phi_b` 0.1, `K_d` 0.5, `K_sigma` 0.05, `K_nomoto` 5/20, `T_nomoto` 1; "
        "`wn_d` 0.1, `zeta_d` 1, `r_max` 5 deg/s",
    ),
    Peer(
        "MSS",
        Fossen,
        f"{SIM}, `ControlFlag` 1 (PID): `lambda` 0.1, `K_d` 0.5, `K_sigma` 0, `K_yaw` 5/20, `T_yaw` 1; `wn_d_psi` 0.1, "
        "`zeta_d_psi` 1, `r_max` 5 deg/s. Its `ControlFlag` 2 (`K_d` 0, `K_sigma` 0.05, `phi_b` 0.1) is the same law "
        "within the boundary layer",
    ),
    Peer(
        "MSS, fast model",
        lambda tick: Fossen(tick, frequency=FAST, turn_rate=TURN_RATE),
        f"the same with `wn_d_psi` {FAST:g} and `r_max` 8 deg/s, the rate of squid's reference. Both numbers are ours: "
        "the file has no such variant",
    ),
    Peer(
        "MSS, path gains",
        lambda tick: Fossen(
            tick, frequency=FAST, turn_rate=TURN_RATE, surface=1.0, proportional=0.0, switching=0.05
        ),
        "the gains of that file for following a path, `ControlFlag` 3 and 4: `lambda` 1, `K_d` 0, `K_sigma` 0.05, "
        "`phi_b` 0.1. There a guidance law gives the reference; here it is that faster model",
    ),
    Peer(
        "DUNE",
        lambda _: Dune(),
        "`etc/auv/control.ini` of [DUNE](https://github.com/LSTS/dune), the file that the LAUVs have in common: "
        "`Heading PID Gains` 1.5, 0, 0, `Maximum Heading Rate` 30, `Heading Rate PID Gains` 1.2, 0, 0, `Maximum Fin "
        "Rotation` 25, `Fin effect N` 0.5. The files of single vehicles change the second gain to 1.5 or add 0.15 of D",
    ),
)
