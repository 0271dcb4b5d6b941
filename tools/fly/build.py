"""Build the command `squid` and the three binaries inside the FMUs with cargo."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fly import libraries, platforms
from fly.stages import run


def build(names: Sequence[str] = ()) -> None:
    """Build the command and, in parallel, the binaries for this machine and for platforms by their FMI names.

    The output of the binaries goes to a log; cargo skips finished builds. If Zig links the binaries of this machine,
    they run on any such machine: with the system's linker they would require its version of glibc.
    """
    with ThreadPoolExecutor() as pool:
        binaries_built = pool.submit(build_binaries, platforms.with_own(names))
        build_command()
        binaries_built.result()


def build_binaries(names: list[str]) -> None:
    """Build the binaries for platforms, and those of this machine if Zig does not link them."""
    if platforms.here() is None:
        flags = {"CARGO_ENCODED_RUSTFLAGS": libraries.without_paths()}
        run(["cargo", *libraries.BUILD], variables=flags, log="fmu-binaries")
    platforms.build_all(names, log="fmu-binaries-of-platforms")


def build_command() -> None:
    """Build only the command."""
    run(["cargo", "build", "--release", "-p", "squid", "--bin", "squid"])


def squid() -> Path:
    """Return the path of the command `squid`."""
    return libraries.target_directory() / "release" / ("squid.exe" if os.name == "nt" else "squid")


def binaries() -> list[Path]:
    """Return the paths of the shared libraries of this machine."""
    here = platforms.here()
    if here is not None:
        return platforms.binaries([here])
    pattern = {"win32": "{}.dll", "darwin": "lib{}.dylib"}.get(sys.platform, "lib{}.so")
    return libraries.files(libraries.target_directory() / "fmu", pattern)
