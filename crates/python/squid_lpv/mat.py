"""MATLAB's files, by SciPy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from squid_lpv import systems
from squid_lpv.errors import InputError
from squid_lpv.synthesis import HinfSynthesis, Proved
from squid_lpv.systems import StateSpace


def savemat(path: str | Path, found: HinfSynthesis | Proved) -> None:
    """Write K, CL and gam to a .mat file: after MATLAB's `load`, `ss(K.a, K.b, K.c, K.d, K.Ts)` is the controller."""
    from scipy.io import savemat as write

    synthesis = found.synthesis if isinstance(found, Proved) else found
    parts = {name: _struct(getattr(synthesis, name)) for name in ("K", "CL")}
    write(path, {**parts, "gam": synthesis.gam, "rcond": synthesis.rcond})


def _struct(system: Any) -> dict[str, Any]:
    s = systems.of(system)
    # MATLAB writes a sample time that is not known as -1.
    return {"a": s.A, "b": s.B, "c": s.C, "d": s.D, "Ts": -1.0 if s.dt is True else s.dt}


def loadmat(path: str | Path, name: str = "P") -> tuple[StateSpace, int, int]:
    """Read a plant from a .mat file: `P, nmeas, ncon`, as `hinfsyn` takes them.

    The file has a struct `name` with a, b, c, d (and Ts), or the matrices A, B, C, D; and nmeas and ncon.

    Raises:
        InputError: one of them is missing.

    """
    from scipy.io import loadmat as read

    held = read(path, simplify_cells=True)
    parts = held.get(name, held)
    lowered = {str(key).lower(): value for key, value in parts.items()}
    for key in "abcd":
        if key not in lowered:
            raise InputError(f"{path}: '{key}' of '{name}' is missing")
    for key in ("nmeas", "ncon"):
        if key not in held:
            raise InputError(f"{path}: '{key}' is missing; it is the number that hinfsyn takes")
    d = np.atleast_2d(lowered["d"])
    n = np.atleast_2d(lowered["a"]).shape[0]
    shaped = [
        np.reshape(lowered[key], shape) for key, shape in zip("abc", [(n, n), (n, -1), (-1, n)], strict=True)
    ]
    time = float(lowered.get("ts", 0.0))
    d = d.reshape(shaped[2].shape[0], shaped[1].shape[1])
    plant = StateSpace(*shaped, d, True if time == -1.0 else time)
    return plant, int(held["nmeas"]), int(held["ncon"])
