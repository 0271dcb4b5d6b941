"""Figures of a flight: what a control engineer reads off the plot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

JUMP = np.deg2rad(1.0)
"""A reference that moves this far (rad) within a sample has stepped; ramps of the trim pitch are slower."""


SETTLED = 0.02
"""The band around the new reference, relative to the step, within which a response counts as settled.

The same as of `squid simulate`, in `crates/flight/src/metrics.rs`.
"""


OUT_OF_WATER = 1e-3
"""A vehicle that has come so far out of the water (m) has left it. The same as in `crates/flight/src/flight.rs`."""


def until_surface(signals: Mapping[str, Array]) -> tuple[dict[str, Array], int | None]:
    """Return the part of a flight that is in the water, and the row at which the vehicle leaves it, if it does."""
    above = np.flatnonzero(signals["depth"] < -OUT_OF_WATER)
    row = int(above[0]) if len(above) else None
    return {name: column[:row] for name, column in signals.items()}, row


@dataclass(frozen=True)
class StepFigures:
    """What one step response amounts to; relative figures are relative to the step."""

    time: float
    """When the step came, s."""
    height: float
    """Its height, rad, signed."""
    overshoot: float
    """Largest excursion beyond the new reference."""
    settling_time: float
    """From the step until the error stays within `SETTLED`, s; infinity if it does not before the next step."""
    steady_error: float
    """Size of the mean error over the last tenth of the response."""


def steps(time: Array, pitch: Array, reference: Array) -> list[StepFigures]:
    """Find the steps of a reference and read the figures off each response, up to the next step."""
    jumps = np.flatnonzero(np.abs(np.diff(reference)) > JUMP) + 1
    ends = [*jumps[1:], len(time)]
    return [_step(time, pitch, reference, begin, end) for begin, end in zip(jumps, ends, strict=True)]


def _step(time: Array, pitch: Array, reference: Array, begin: int, end: int) -> StepFigures:
    height = float(reference[begin] - reference[begin - 1])
    error = (reference[begin:end] - pitch[begin:end]) / height
    outside = np.flatnonzero(np.abs(error) > SETTLED)
    last = int(outside[-1]) if len(outside) else -1
    settled = last + 1 < len(error)
    tail = error[-max(len(error) // 10, 1) :]
    return StepFigures(
        time=float(time[begin]),
        height=height,
        overshoot=max(0.0, float(np.max(-error))),
        settling_time=float(time[begin + last + 1] - time[begin]) if settled else float("inf"),
        steady_error=abs(float(np.mean(tail))),
    )


def worst_error_after(time: Array, error: Array, events: Sequence[float], grace: float) -> float | None:
    """Return the largest error from the first event on, without the `grace` (s) that follows each.

    Without events it is that of the whole record; `None` when the record ends before any such time.
    """
    counted = time > min(events, default=-np.inf)
    for event in events:
        counted &= (time < event) | (time > event + grace)
    return float(np.max(np.abs(error[counted]))) if counted.any() else None


def actuator_use(signals: Mapping[str, Array], limits: Mapping[str, tuple[float, float]]) -> float:
    """Return the largest use of an actuator: 1 is at a limit."""
    return max(
        float(max(np.max(signals[name]) / high, np.min(signals[name]) / low))
        for name, (low, high) in limits.items()
    )
