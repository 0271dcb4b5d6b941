"""The crates of the shared libraries in the FMUs, and the settings with which cargo builds them."""

from __future__ import annotations

import json
import os
from functools import cache
from pathlib import Path

from fly.stages import answer

CRATES = ("squid-fmu-plant-library", "squid-fmu-controller-library", "squid-fmu-loop-library")
"""Of the plant, the controller and the loop."""
BUILD = ("build", "--profile", "fmu", *(word for name in CRATES for word in ("-p", name)))
"""What cargo is asked for: all at once, so that what they share is compiled once."""


def without_paths() -> str:
    """Return the user's compiler flags with one that keeps the path of cargo's packages out of the binaries.

    The path of this checkout is not among the flags: cargo recompiles everything when a flag changes, so moving the
    checkout would recompile all. It is not needed, because cargo compiles workspace members by relative paths. The
    flags are joined as CARGO_ENCODED_RUSTFLAGS requires, so that paths may contain spaces.
    """
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    encoded = os.environ.get("CARGO_ENCODED_RUSTFLAGS")
    own = encoded.split("\x1f") if encoded else os.environ.get("RUSTFLAGS", "").split()
    return "\x1f".join([*own, f"--remap-path-prefix={home}=cargo"])


@cache
def target_directory() -> Path:
    """Return the target directory of cargo."""
    words = ["cargo", "metadata", "--format-version", "1", "--no-deps"]
    return Path(json.loads(answer(words))["target_directory"])


def files(folder: Path, pattern: str) -> list[Path]:
    """Return the libraries in a folder, by the pattern of a library's name."""
    return [folder / pattern.format(crate.replace("-", "_")) for crate in CRATES]
