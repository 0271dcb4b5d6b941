"""Gains and structured singular values of what is finished."""

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

    Both are infinite and zero for a system that is not stable.
    """
    system = systems.of(P)
    parts = (part.tolist() for part in (system.A, system.B, system.C, system.D))
    return _core.hinfnorm(*parts, system.D.shape[1], system.sample_time or None)


@dataclass(frozen=True)
class Mu:
    """Bounds on mu: `1/upper` is a size that no perturbation may have to do harm, `delta` one that does."""

    upper: float
    lower: float
    frequency: float | None
    delta: np.ndarray | None


def mu(M: Any, blocks: Sequence[Sequence[int]]) -> Mu:
    """Return bounds on the structured singular value of a matrix, or of a stable system over all frequencies.

    Args:
        M: a real or complex matrix, or anything with A, B, C, D in continuous time.
        blocks: rows in MATLAB's notation: [-r, 0] a real scalar repeated r times, [r, 0] a complex one, [p, q] a full
            complex block of p rows and q columns.

    Raises:
        InputError: the blocks do not fit, or the system is not stable.
        NumericalError: the bounds did not close over all frequencies.

    """
    if all(hasattr(M, part) for part in "ABCD"):
        system = systems.of(M, "M")
        if system.dt:
            raise InputError("M is in discrete time; take it to continuous time first")
        data: dict[str, Any] = {"P": {part: getattr(system, part).tolist() for part in "ABCD"}}
    else:
        m = np.atleast_2d(np.asarray(M, dtype=complex))
        if m.ndim != 2 or not np.isfinite(m).all():
            raise InputError("M must be a matrix of finite numbers, or a system with A, B, C, D")
        data = {"M": [[[v.real, v.imag] for v in row] for row in m.tolist()]}
    data["blocks"] = np.atleast_2d(np.asarray(blocks)).tolist()
    report = json.loads(_core.mu(json.dumps({"data": data})))
    found = report["delta"]
    delta = None if found is None else np.array([[complex(*v) for v in row] for row in found])
    frequency = float("inf") if report["frequency"] == "infinity" else report["frequency"]
    return Mu(report["upper"], report["lower"], frequency, delta)


@dataclass(frozen=True)
class LpvGain:
    """Bounds on the gain of a loop with parameters: see `lpvgain`."""

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
    """Return bounds on the L2 gain of a finished loop with parameters within [-1, 1].

    `proved` holds however fast they move, `proved_at_rate` where |theta'| of the only one stays within `rate` (at most
    `proved`, and often there alone); both are proved in exact arithmetic. `constant_upper` and `constant_lower` are of
    constant ones, the latter at `constant_theta`. What was not found is None, and `reasons` says why.

    Args:
        P: the matrices A, Bt, B1, Ct, C1, Dtt, Dt1, D1t, D11 by name.
        blocks: the repetitions of the parameters.
        rate: a bound on |theta'| of the only one.
        dt: the sample time, s, of a loop in discrete time.
        progress: called back.

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
