"""Compare the plant FMU with the independent equations of motion, and return the differences at the end.

The simulation takes 60 s from trim: steps of the first actuator, also beyond its limit, in a current that turns and
ends.
"""

from pathlib import Path

import numpy as np
import reference_plant as reference
from fly.master import Slave

PITCH_TOLERANCE = 1e-6  # rad
LOAD = ["external_force_x", "external_force_z", "external_moment"]
TUNABLE = ("weight", "buoyancy", "x_G", "z_G")
MOTION = ["speed", "heave", "pitch_rate", "pitch", "distance", "depth"]


def outputs_of(vehicle):
    """Return the names of the FMU's outputs in the order of the reference's state."""
    return MOTION + [f"{actuator.name}_output" for actuator in vehicle.actuators]


def manoeuvre(vehicle, start):
    """Return sixty seconds of steps, each a fifth of the first actuator's range, or beyond its limit."""
    trim = start[6:]
    step = np.zeros(len(trim))
    step[0] = 0.2 * vehicle.actuators[0].max

    def commands(outputs):
        return np.array([a.taken(output) for a, output in zip(vehicle.actuators, outputs, strict=True)])

    beyond = np.zeros(len(trim))
    beyond[0] = 2.0 * vehicle.actuators[0].taken(vehicle.actuators[0].max)
    return [
        reference.Leg(5.0, commands(trim), (0.3, 0.0)),
        reference.Leg(20.0, commands(trim + step), (0.3, 0.0)),
        reference.Leg(40.0, commands(trim - step), (-0.2, 0.1)),
        reference.Leg(45.0, commands(trim) + beyond),
        reference.Leg(60.0, commands(trim)),
    ]


def fly_fmu(path, vehicle, speed, depth, legs, step, parameters=None):
    """Simulate the FMU with a communication step, from its own trim; return times and outputs.

    Only tunable parameters of a leg are set in the FMU; the mass follows the weight.
    """
    times = np.round(np.arange(round(legs[-1].end / step) + 1) * step, 9)
    with Slave(Path(path), "plant") as plant:
        actuators = [actuator.name for actuator in vehicle.actuators]
        inputs = plant.references([*actuators, "current_horizontal", "current_vertical"])
        loaded = plant.references(LOAD) if any(any(leg.load) for leg in legs) else []
        outputs = plant.references(outputs_of(vehicle))
        plant.begin({"initial_speed": speed, "initial_depth": depth, **(parameters or {})})
        plant.fmu.setReal(inputs, [*legs[0].commands, *legs[0].current])
        plant.ready()
        rows = [plant.fmu.getReal(outputs)]
        before = None
        for time in times[:-1]:
            leg = next(leg for leg in legs if time < leg.end)
            plant.fmu.setReal(inputs, [*leg.commands, *leg.current])
            if loaded:
                plant.fmu.setReal(loaded, list(leg.load))
            if leg is not before:
                changed = [name for name in TUNABLE if name in leg.changed]
                plant.fmu.setReal(plant.references(changed), [leg.changed[name] for name in changed])
            before = leg
            plant.fmu.doStep(time, step)
            rows.append(plant.fmu.getReal(outputs))
    return times, np.array(rows)


def differences(path, vehicle, speed=1.75, depth=50.0, step=0.02, parameters=None):
    """Return the largest difference of each output over the manoeuvre, and the range of the pitch, in rad."""
    vehicle = vehicle.changed(**(parameters or {}))
    start = reference.trim(vehicle, speed, depth)
    legs = manoeuvre(vehicle, start)
    times, flown = fly_fmu(path, vehicle, speed, depth, legs, step, parameters)
    expected = reference.fly(vehicle, start, legs, times)
    greatest = np.abs(flown - expected).max(axis=0)
    return dict(zip(outputs_of(vehicle), greatest, strict=True)), np.ptp(expected[:, reference.THETA])
