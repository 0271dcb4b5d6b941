"""Cross-compile the binaries of the FMUs for all platforms with cargo-zigbuild and Zig as the linker."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from fly import environment, libraries, universal
from fly.environment import Environment
from fly.stages import ROOT, StageError, run

REQUIREMENTS = ROOT / "tools" / "platforms.txt"
GLIBC = "2.17"
"""The oldest glibc that Rust's standard library supports: of 2012, in RHEL 7 and later."""
MACOS = "11.0"
"""The oldest macOS that runs on both of its processors: of 2020."""
TARGETS = {
    "linux64": "x86_64-unknown-linux-gnu",
    "win64": "x86_64-pc-windows-gnu",
    "aarch64-linux": "aarch64-unknown-linux-gnu",
    "darwin64": "universal2-apple-darwin",
}
"""The platforms by their names in FMI, and Rust's target names; for macOS that of maturin and cargo-zigbuild for a
library with both of its processors."""
UNIVERSAL = ("x86_64-apple-darwin", "aarch64-apple-darwin")
"""Rust's names for the two processors of macOS."""
PATTERNS = {"win64": "{}.dll", "darwin64": "lib{}.dylib"}
"""File names of libraries by platform, where they are not those of Linux."""
HERE = {("linux", "x86_64"): "linux64", ("linux", "aarch64"): "aarch64-linux", ("win32", "AMD64"): "win64"}
"""The host platform's name in FMI."""


def named(words: str) -> list[str]:
    """Return the platforms of a comma-separated list or `all`; none for `host`."""
    names = list(TARGETS) if words == "all" else [] if words == "host" else words.split(",")
    unknown = [name for name in names if name not in TARGETS]
    if unknown:
        raise StageError(
            f"--platforms is '{words}'; it must be host, all, or a comma-separated list of {', '.join(TARGETS)}."
        )
    return names


def here() -> str | None:
    """Return the FMI name of this machine if Zig links its binaries, and None otherwise.

    Zig does so on Linux with glibc, for an old version of it; not with another C library.
    """
    name = HERE.get((sys.platform, platform.machine()))
    return name if sys.platform == "linux" and platform.libc_ver()[0] == "glibc" else None


def with_own(names: Sequence[str]) -> list[str]:
    """Return platforms with this machine first, if Zig links its binaries."""
    own = here()
    return list(names) if own is None else [own, *(name for name in names if name != own)]


def option(names: Sequence[str]) -> str:
    """Return the value of `--platforms` of `squid package`; the host is always included, for the simulations."""
    every = with_own(names)
    return ",".join(every if HERE.get((sys.platform, platform.machine())) in every else ["host", *every])


def rust_targets(names: Sequence[str]) -> list[str]:
    """Return Rust's names of platforms."""
    return [target for name in names for target in (UNIVERSAL if name == "darwin64" else (TARGETS[name],))]


def tools() -> Environment:
    """Return the environment with Zig, cargo-zigbuild and maturin; create it if it is missing."""
    return environment.ready("platforms", REQUIREMENTS)


def build_all(names: Sequence[str], log: str | None = None) -> None:
    """Build the binaries for platforms, by their FMI names."""
    if not names:
        return
    add_targets(names)
    zig = tools()
    scripts = zig.scripts
    path = os.pathsep.join([str(scripts), os.environ["PATH"]])
    variables = {**zig.variables, "PATH": path, "CARGO_ENCODED_RUSTFLAGS": libraries.without_paths()}
    variables["MACOSX_DEPLOYMENT_TARGET"] = MACOS
    targets = (f"{target}.{GLIBC}" if "linux" in target else target for target in rust_targets(names))
    words = [word for target in targets for word in ("--target", target)]
    run([scripts / "cargo-zigbuild", *libraries.BUILD, *words], variables=variables, log=log)
    if "darwin64" in names:
        parts = zip(*(libraries_of(target, "darwin64") for target in UNIVERSAL), strict=True)
        for of_each, whole in zip(parts, binaries(["darwin64"]), strict=True):
            universal.join(of_each, whole)


def add_targets(names: Sequence[str]) -> None:
    """Install Rust's standard library for platforms with rustup; without rustup it must be installed already."""
    if shutil.which("rustup") is None:
        return
    words = ["rustup", "target", "list", "--installed"]
    there = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()
    missing = [target for target in rust_targets(names) if target not in there]
    if missing:
        run(["rustup", "target", "add", *missing])


def binaries(names: Sequence[str]) -> list[Path]:
    """Return the paths of the shared libraries for platforms."""
    return [path for name in names for path in libraries_of(TARGETS[name], name)]


def libraries_of(target: str, name: str) -> list[Path]:
    """Return the paths of the shared libraries of a Rust target, for a platform by its FMI name."""
    return libraries.files(libraries.target_directory() / target / "fmu", PATTERNS.get(name, "lib{}.so"))
