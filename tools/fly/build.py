"""Build the command `squid` and the three binaries inside the FMUs with cargo."""

from __future__ import annotations

import json
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

from fly.stages import answer, run

LIBRARIES = ("fmu-plant-library", "fmu-controller-library", "fmu-squid-library")
"""The crates that are the shared libraries in the FMUs."""
BUILD_LIBRARIES = ("build", "--profile", "fmu", *(word for name in LIBRARIES for word in ("-p", name)))
"""What cargo is asked for: all at once, so that what they share is compiled once."""


def build() -> None:
    """Build the command and, at the same time, the binaries, whose output goes to a log; cargo skips what is done."""
    variables = {"CARGO_ENCODED_RUSTFLAGS": without_paths()}
    with ThreadPoolExecutor() as pool:
        binaries_built = pool.submit(
            run, ["cargo", *BUILD_LIBRARIES], variables=variables, log="fmu-binaries"
        )
        build_command()
        binaries_built.result()


def without_paths() -> str:
    """Return the user's compiler flags and one that keeps the path of cargo's packages out of the binaries.

    The path of this checkout is not among the flags: cargo recompiles everything when a flag changes, so moving
    the checkout would recompile all. It is not needed, because cargo compiles workspace members by relative paths.
    The flags are joined as CARGO_ENCODED_RUSTFLAGS requires, so that paths may contain spaces.
    """
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    encoded = os.environ.get("CARGO_ENCODED_RUSTFLAGS")
    own = encoded.split("\x1f") if encoded else os.environ.get("RUSTFLAGS", "").split()
    return "\x1f".join([*own, f"--remap-path-prefix={home}=cargo"])


def build_command() -> None:
    """Build only the command."""
    run(["cargo", "build", "--release", "-p", "squid", "--bin", "squid"])


@cache
def target_directory() -> Path:
    """Return the target directory of cargo."""
    words = ["cargo", "metadata", "--format-version", "1", "--no-deps"]
    return Path(json.loads(answer(words))["target_directory"])


def squid() -> Path:
    """Return the path of the command `squid`."""
    return target_directory() / "release" / ("squid.exe" if os.name == "nt" else "squid")


def binaries() -> list[Path]:
    """Return the paths of the shared libraries."""
    pattern = {"win32": "{}.dll", "darwin": "lib{}.dylib"}.get(sys.platform, "lib{}.so")
    names = [pattern.format(crate.replace("-", "_")) for crate in LIBRARIES]
    return [target_directory() / "fmu" / name for name in names]
