"""Gains and structured singular values of given systems."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from squid_lpv import _core, systems
from squid_lpv.certificates import Certificate
from squid_lpv.errors import InputError
from squid_lpv.synthesis import Progress, as_lists, without_none


def hinfnorm(P: Any) -> tuple[float, float]:
    """Return the H-infinity norm of a system and the frequency of its peak, rad/s, to 1e-9.

    An unstable system returns infinity and zero.
    """
    system = systems.of(P)
    parts = (part.tolist() for part in (system.A, system.B, system.C, system.D))
    return _core.hinfnorm(*parts, system.D.shape[1], system.sample_time or None)


@dataclass(frozen=True)
class Performance:
    """Robust performance and the worst-case gain from w to z.

    For every perturbation smaller than `1/upper` the gain is below `upper`; `lower` bounds the same mu from below. With
    a perturbation of norm `size` the gain is at most `gain_upper` (None if the loop is not shown to stay stable), and
    with `gain_delta` it is `gain_lower` at `gain_frequency`, rad/s.
    """

    upper: float
    lower: float
    size: float
    gain_upper: float | None
    gain_lower: float | None
    gain_frequency: float | None
    gain_delta: np.ndarray | None


@dataclass(frozen=True)
class Mu:
    """Bounds on mu: no perturbation smaller than `1/upper` destabilises; `delta` does.

    `frequency` (rad/s) is that of the largest upper bound; `performance` is set if it was requested.
    """

    upper: float
    lower: float
    frequency: float | None
    delta: np.ndarray | None
    performance: Performance | None = None


def _complex(rows: list | None) -> np.ndarray | None:
    return None if rows is None else np.array([[complex(*v) for v in row] for row in rows])


def _frequency(value: float | str | None) -> float | None:
    return float("inf") if value == "infinity" else value


def mu(
    M: Any,
    blocks: Sequence[Sequence[int]],
    *,
    performance: tuple[int, int] | None = None,
    size: float | None = None,
) -> Mu:
    """Return bounds on the structured singular value of a matrix, or of a stable system over all frequencies.

    Args:
        M: a real or complex matrix, or anything with A, B, C, D, or a transfer function; in discrete time mu is over
            the unit circle.
        blocks: rows in MATLAB's notation: [-r, 0] a real scalar repeated r times, [r, 0] a complex one, [p, q] a full
            complex block of p rows and q columns.
        performance: (p, q): the last p inputs of a system are w and its last q outputs z.
        size: the size of the perturbation for the worst-case gain from w to z, 1 by default.

    Raises:
        InputError: the blocks do not match M, or the system is not stable.
        NumericalError: the bounds did not close over all frequencies.

    """
    M = systems.realised(M, "M")
    if all(hasattr(M, part) for part in "ABCD"):
        system = systems.of(M, "M")
        data: dict[str, Any] = {"P": {part: getattr(system, part).tolist() for part in "ABCD"}}
        if system.dt:
            data["dt"] = system.sample_time
    else:
        try:
            m = np.atleast_2d(np.asarray(M, dtype=complex))
        except (TypeError, ValueError):
            m = np.array(np.nan)
        if m.ndim != 2 or not np.isfinite(m).all():
            raise InputError("M must be a matrix of finite numbers, or a system with A, B, C, D")
        data = {"M": [[[v.real, v.imag] for v in row] for row in m.tolist()]}
    data["blocks"] = np.atleast_2d(np.asarray(blocks)).tolist()
    if performance is not None:
        data["performance"] = np.asarray(performance).tolist()
    data |= without_none(size=size)
    report = json.loads(_core.mu(json.dumps({"data": data})))
    found = report.get("performance")
    if found is not None:
        found = Performance(
            **{
                **found,
                "gain_frequency": _frequency(found["gain_frequency"]),
                "gain_delta": _complex(found["gain_delta"]),
            }
        )
    frequency = _frequency(report["frequency"])
    return Mu(report["upper"], report["lower"], frequency, _complex(report["delta"]), found)


@dataclass(frozen=True)
class LpvGain:
    """Bounds on the gain of a closed loop with parameters: see `lpvgain`."""

    proved: float | None
    proved_at_rate: float | None
    constant_upper: float | None
    constant_lower: float | None
    constant_theta: list[float] | None
    reasons: list[str]
    certificate: Certificate | None


def lpvgain(
    P: Mapping[str, Any],
    blocks: Sequence[int],
    *,
    rate: float | None = None,
    dt: float | None = None,
    progress: Progress | None = None,
) -> LpvGain:
    """Return bounds on the L2 gain of a closed loop with parameters within [-1, 1].

    `proved` holds for parameters that change arbitrarily fast, `proved_at_rate` if |theta'| of the single parameter
    stays within `rate` (at most `proved`, and often the only one of the two); both are proved in exact arithmetic.
    `constant_upper` and `constant_lower` hold for constant parameters, the latter at `constant_theta`. Bounds that were
    not found are None, with the cause in `reasons`.

    Args:
        P: the matrices A, Bt, B1, Ct, C1, Dtt, Dt1, D1t, D11 by name.
        blocks: the repetitions of the parameters.
        rate: a bound on |theta'| of the single parameter.
        dt: the sample time, s, of a discrete-time loop.
        progress: a function called with progress reports.

    """
    data: dict[str, Any] = {"P": as_lists(P), "blocks": np.asarray(blocks).tolist()}
    data |= without_none(rate=rate, dt=dt)
    text, certificate = _core.gain(json.dumps({"data": data}), progress)
    report = json.loads(text)
    keys = ("proved", "constant_upper", "constant_lower", "constant_theta", "reasons")
    return LpvGain(
        proved_at_rate=report.get("proved_at_rate"),
        certificate=None if certificate is None else Certificate(certificate),
        **{key: report[key] for key in keys},
    )
