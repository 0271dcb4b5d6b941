"""Longitudinal motion of an underwater vehicle, implemented a second time, to check the plant FMU.

Reads a vehicle file with tomllib, solves for level trim with SciPy, and integrates the equations of motion with SciPy's
DOP853. It shares nothing with the program under test but the vehicle file and the physics:

- the equations are in component form, force by force, after Feldman (1979, DTNSRDC report SPD-0393-09) for the rigid
  body and Lamb (1932, ch. VI) for the added mass;
- the command of a thruster with a curve is mapped to thrust by linear interpolation or a square law;
- the lag of each actuator is one more state of the differential equation, whose rate may be limited;
- friction follows the ITTC (1957) line, C_f = 0.075 / (log10 Re - 2)^2, Re = |u| L / nu, at least 1e4.

Units are SI, angles are radians. The state is y = [u, w, q, theta, x, depth, T_1 .. T_m], with velocities through the
water; a steady, uniform current carries the vehicle, and when it changes, the velocity over ground stays.

    vehicle = read_vehicle(Path("vehicles/squid/vehicle.toml"))
    start = trim(vehicle, 1.75, 50.0)
    legs = [Leg(5.0, start[6:]), Leg(60.0, start[6:] + [20, 0, 0], current=(0.2, 0.0))]
    y = fly(vehicle, start, legs, times)
"""

import math
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import tomllib
from scipy.integrate import solve_ivp

LEAST_REYNOLDS_NUMBER = 1e4
RELATIVE_TOLERANCE = 1e-10
ABSOLUTE_TOLERANCE = 1e-12
NEWTON_STEPS = 40
LARGEST_TURN = 0.1
LARGEST_UNBALANCE = 1e-9

U, W, Q, THETA, X, DEPTH = range(6)


@dataclass(frozen=True)
class Actuator:
    """Limits, lag, curve and effect; `kind` is `thruster`, `thruster_group` or `control_surface`.

    `rate` limits the rate of the output. A curve is an array of rows (command, thrust), the factor of a square law, or
    None.
    """

    name: str
    kind: str
    min: float
    max: float
    lag: float
    effect: dict
    curve: np.ndarray | float | None = None
    rate: float = math.inf

    def asked(self, command):
        """Return the output that a command requests."""
        if self.curve is None:
            return command
        if isinstance(self.curve, float):
            return self.curve * command * abs(command)
        return np.interp(command, *self.curve.T)

    def taken(self, output):
        """Return a command that requests an output; any such command in a dead band."""
        if self.curve is None:
            return output
        if isinstance(self.curve, float):
            return math.copysign(math.sqrt(abs(output) / self.curve), output)
        return np.interp(output, *self.curve.T[::-1])

    def force(self, u, output):
        """Return surge force, heave force and pitch moment."""
        e = self.effect
        if self.kind == "thruster":
            forward, down = output * math.cos(e["direction"]), output * math.sin(e["direction"])
            return np.array([forward, down, e["z"] * forward - e["x"] * down])
        if self.kind == "thruster_group":
            return sum(one.force(u, share * output) for share, one in e["members"])
        pressure = u * abs(u)
        return pressure * np.array(
            [e["X_uu_delta2"] * output**2, e["Z_uu_delta"] * output, e["M_uu_delta"] * output]
        )


@dataclass(frozen=True)
class Vehicle:
    """Name, coefficients by key, and actuators, thrusters first."""

    name: str
    coefficients: dict
    actuators: list

    def changed(self, **coefficients):
        """Return the same vehicle with other coefficients."""
        return Vehicle(self.name, defaultdict(float, {**self.coefficients, **coefficients}), self.actuators)


@dataclass(frozen=True)
class Leg:
    """A part of a simulation, up to time `end`: held commands, one for each actuator, and a current (along x, down).

    The command of a thruster with a curve is the argument of the curve. An external load (surge, heave, pitch) is
    added, and some coefficients may change.
    """

    end: float
    commands: np.ndarray
    current: tuple = (0.0, 0.0)
    load: tuple = (0.0, 0.0, 0.0)
    changed: dict = field(default_factory=dict)


def _si(quantity):
    factor = math.pi / 180.0 if quantity["unit"] in ("deg", "deg/s") else 1.0
    return quantity["value"] * factor


def _actuator(kind, table):
    numbers = {key: _si(value) for key, value in table.items() if key not in ("name", "thruster", "curve")}
    curve = numbers.get("T_nn")
    if "curve" in table:
        curve = np.array(table["curve"]["value"])
        numbers = {"min": curve[0, 1], "max": curve[-1, 1], **numbers}
    keys = {
        "thruster": ("x", "z", "direction"),
        "thruster_group": (),
        "control_surface": ("Z_uu_delta", "M_uu_delta", "X_uu_delta2"),
    }
    effect = {key: numbers.get(key, 0.0) for key in keys[kind]}
    if kind == "thruster_group":
        whole = {key: {"value": numbers[key], "unit": "N"} for key in ("min", "max")} | {
            "name": table["name"]
        }
        members = [
            (_si(one.pop("share")), _actuator("thruster", {**whole, **one})) for one in table["thruster"]
        ]
        effect = {"members": members}
    limits = numbers["min"], numbers["max"]
    lag, rate = numbers.get("lag", 0.0), numbers.get("rate", math.inf)
    return Actuator(table["name"], kind, *limits, lag, effect, curve, rate)


def read_vehicle(path):
    """Read a vehicle file; omitted keys are zero, except length, form factor and viscosity."""
    with Path(path).open("rb") as file:
        tables = tomllib.load(file)
    c = defaultdict(float, length=1.0, form_factor=1.0, kinematic_viscosity=1.19e-6)
    for section in ("mass", "buoyancy", "water", "added_mass", "lift", "damping", "drag"):
        for key, value in tables.get(section, {}).items():
            if isinstance(value, dict):
                c[key] = _si(value)
    if tables["lift"]["convention"] == "combined":
        # The published sums contain -X_u' u q in heave, and (X_u' - Z_w') u w - Z_q' u q in pitch.
        c["Z_uq"] -= -c["X_u_dot"]
        c["M_uw"] -= c["X_u_dot"] - c["Z_w_dot"]
        c["M_uq"] -= -c["Z_q_dot"]
    actuators = [
        _actuator(kind, table)
        for kind in ("thruster", "thruster_group", "control_surface")
        for table in tables.get(kind, [])
        if _acts_in_plane(table)
    ]
    # A group whose thrusters cancel in the vertical plane does not act there.
    actuators = [one for one in actuators if one.kind != "thruster_group" or np.any(one.force(1.0, 1.0))]
    return Vehicle(tables["vehicle"]["name"], c, actuators)


def _acts_in_plane(table):
    """Return True if an actuator may act in the vertical plane: rudders and groups of turned thrusters do not."""
    steers = "Y_uu_delta" in table and "Z_uu_delta" not in table
    return not steers and not any("azimuth" in member for member in table.get("thruster", []))


def _rigid_body(c, u, w, q):
    """Return the inertial forces of the rigid body without accelerations, moved to the right-hand side."""
    m, x_g, z_g = c["mass"], c["x_G"], c["z_G"]
    surge = -m * (w * q - x_g * q**2)
    heave = -m * (-u * q - z_g * q**2)
    pitch = -m * (z_g * w * q + x_g * u * q)
    return np.array([surge, heave, pitch])


def _added_mass(c, u, w, q):
    """Return the added-mass forces without accelerations; the Munk moment is the first term of pitch."""
    surge = c["Z_w_dot"] * w * q + c["Z_q_dot"] * q**2
    heave = -c["X_u_dot"] * u * q
    pitch = -(c["Z_w_dot"] - c["X_u_dot"]) * u * w - c["Z_q_dot"] * u * q
    return np.array([surge, heave, pitch])


def _weight_and_buoyancy(c, theta, depth):
    buoyancy = c["buoyancy"] + c["buoyancy_gradient"] * (depth - c["reference_depth"])
    down = np.array([-math.sin(theta), math.cos(theta)])
    forces = {(c["x_G"], c["z_G"]): c["weight"] * down}
    total = np.zeros(3)
    for (x, z), (forward, below) in [*forces.items(), ((c["x_B"], c["z_B"]), -buoyancy * down)]:
        total += [forward, below, z * forward - x * below]
    return total


def _hull(c, u, w, q):
    reynolds = max(abs(u) * c["length"] / c["kinematic_viscosity"], LEAST_REYNOLDS_NUMBER)
    friction = 0.075 / (math.log10(reynolds) - 2.0) ** 2
    area = friction * c["form_factor"] * c["wetted_area"] + c["drag_area"]
    surge = c["X_u"] * u + (c["X_uu"] - 0.5 * c["density"] * area) * u * abs(u)
    flow = abs(u)
    heave = c["Z_uw"] * flow * w + c["Z_uq"] * flow * q + c["Z_w"] * w + c["Z_ww"] * w * abs(w)
    heave += c["Z_qq"] * q * abs(q)
    pitch = c["M_uw"] * flow * w + c["M_uq"] * flow * q + c["M_uu"] * u * flow
    heave += c["Z_q"] * q
    pitch += c["M_q"] * q + c["M_qq"] * q * abs(q) + c["M_ww"] * w * abs(w) + c["M_w"] * w
    return np.array([surge, heave, pitch])


def _inertia(c):
    m, x_g, z_g = c["mass"], c["x_G"], c["z_G"]
    return np.array(
        [
            [m - c["X_u_dot"], 0.0, m * z_g],
            [0.0, m - c["Z_w_dot"], -m * x_g - c["Z_q_dot"]],
            [m * z_g, -m * x_g - c["M_w_dot"], c["I_yy"] - c["M_q_dot"]],
        ]
    )


def force(vehicle, y):
    """Return surge force, heave force and pitch moment, except the terms with accelerations."""
    c, (u, w, q, theta, _, depth) = vehicle.coefficients, y[:6]
    total = _rigid_body(c, u, w, q) + _added_mass(c, u, w, q) + _weight_and_buoyancy(c, theta, depth)
    total += _hull(c, u, w, q)
    for actuator, output in zip(vehicle.actuators, y[6:], strict=True):
        total += actuator.force(u, output)
    return total


def rate(vehicle, y, commands, current, load=(0.0, 0.0, 0.0)):
    """Return the derivative of the state."""
    u, w, q, theta = y[:4]
    acceleration = np.linalg.solve(_inertia(vehicle.coefficients), force(vehicle, y) + load)
    ahead = u * math.cos(theta) + w * math.sin(theta) + current[0]
    down = -u * math.sin(theta) + w * math.cos(theta) + current[1]
    outputs = [
        np.clip(
            (np.clip(actuator.asked(command), actuator.min, actuator.max) - output) / actuator.lag,
            -actuator.rate,
            actuator.rate,
        )
        for actuator, command, output in zip(vehicle.actuators, commands, y[6:], strict=True)
    ]
    return np.array([*acceleration, q, ahead, down, *outputs])


def trim(vehicle, speed, depth):
    """Return the state in level, steady flight at a speed along the path, by Newton's method.

    The actuators must leave one direction of force to the incidence, as axial thrusters or stern planes do. Outputs
    that cancel one another then stay zero, because each step is the shortest one, in units of each actuator's range.
    """
    reach = np.array([1.0, *(max(abs(a.min), abs(a.max)) for a in vehicle.actuators)])

    def state(unknowns):
        incidence, *outputs = unknowns
        along, across = speed * math.cos(incidence), speed * math.sin(incidence)
        return np.array([along, across, 0.0, incidence, 0.0, depth, *outputs])

    unknowns = np.zeros(len(reach))
    for _ in range(NEWTON_STEPS):
        columns = []
        for step in np.diag(1e-6 * reach):
            ahead, behind = force(vehicle, state(unknowns + step)), force(vehicle, state(unknowns - step))
            columns.append((ahead - behind) / 2e-6)
        change = np.linalg.lstsq(np.array(columns).T, -force(vehicle, state(unknowns)), rcond=1e-6)[0]
        unknowns = unknowns + reach * change * min(1.0, LARGEST_TURN / max(abs(change[0]), 1e-300))
    left = np.abs(force(vehicle, state(unknowns))).max()
    if left > LARGEST_UNBALANCE:
        raise RuntimeError(f"{vehicle.name}: no trim at {speed} m/s and {depth} m, {left} N or N.m are left")
    return state(unknowns)


def _enter_current(y, old, new):
    """Return the state in a new current, at the old velocity over ground."""
    cos, sin = math.cos(y[THETA]), math.sin(y[THETA])
    change = np.subtract(old, new)
    y[U] += change[0] * cos - change[1] * sin
    y[W] += change[0] * sin + change[1] * cos


def fly(vehicle, start, legs, times):
    """Return the state at each of `times` (increasing, from 0 on); the start is in the current of the first leg.

    The end of a leg has the state before the current changes. Changed coefficients remain changed, and change no
    velocity. Actuators without lag are refused: they follow a command at once, which a differential equation cannot.
    """
    if any(actuator.lag <= 0.0 for actuator in vehicle.actuators):
        raise ValueError("every actuator needs a lag above zero")
    times, y, begin, current = np.asarray(times), np.array(start, dtype=float), 0.0, legs[0].current
    flown = np.empty((len(times), len(y)))
    for leg in legs:
        vehicle = vehicle.changed(**leg.changed)
        _enter_current(y, current, leg.current)
        inside = ((times > begin) | (begin == 0.0)) & (times <= leg.end)
        wanted = np.unique(np.append(times[inside], leg.end))
        solution = solve_ivp(
            lambda _, state, leg=leg, of=vehicle: rate(of, state, leg.commands, leg.current, leg.load),
            (begin, leg.end),
            y,
            method="DOP853",
            t_eval=wanted,
            rtol=RELATIVE_TOLERANCE,
            atol=ABSOLUTE_TOLERANCE,
        )
        if not solution.success:
            raise RuntimeError(f"{vehicle.name}: {solution.message}")
        flown[inside] = solution.y.T[np.searchsorted(wanted, times[inside])]
        y, begin, current = solution.y[:, -1].copy(), leg.end, leg.current
    return flown
