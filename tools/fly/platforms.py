"""Cross-compile the binaries of the FMUs for all platforms with cargo-zigbuild and Zig as the linker."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

from fly import build, environment
from fly.environment import Environment
from fly.stages import ROOT, StageError, run

REQUIREMENTS = ROOT / "tools" / "platforms.txt"
GLIBC = "2.17"
"""The oldest glibc that Rust's standard library supports: of 2012, in RHEL 7 and later."""
TARGETS = {
    "linux64": "x86_64-unknown-linux-gnu",
    "win64": "x86_64-pc-windows-gnu",
    "aarch64-linux": "aarch64-unknown-linux-gnu",
}
"""The platforms by their names in FMI, and Rust's target names."""
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


def option(names: list[str]) -> str:
    """Return the value of `--platforms` of `squid package`; the host platform is always included, for the flights."""
    here = HERE.get((sys.platform, platform.machine()))
    return ",".join(names if here in names else ["host", *names])


def tools() -> Environment:
    """Return the environment with Zig, cargo-zigbuild and maturin; create it if it is missing."""
    return environment.ready("platforms", REQUIREMENTS)


def build_all(names: list[str]) -> None:
    """Build the binaries for platforms, by their FMI names."""
    if not names:
        return
    add_targets(names)
    zig = tools()
    scripts = zig.scripts
    path = os.pathsep.join([str(scripts), os.environ["PATH"]])
    variables = {**zig.variables, "PATH": path, "CARGO_ENCODED_RUSTFLAGS": build.without_paths()}
    targets = (TARGETS[name] + ("" if name == "win64" else f".{GLIBC}") for name in names)
    words = [word for target in targets for word in ("--target", target)]
    run([scripts / "cargo-zigbuild", *build.BUILD_LIBRARIES, *words], variables=variables)


def add_targets(names: list[str]) -> None:
    """Install Rust's standard library for platforms with rustup; without rustup it must be installed already."""
    if shutil.which("rustup") is None:
        return
    words = ["rustup", "target", "list", "--installed"]
    there = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()
    missing = [TARGETS[name] for name in names if TARGETS[name] not in there]
    if missing:
        run(["rustup", "target", "add", *missing])


def binaries(names: list[str]) -> list[Path]:
    """Return the paths of the shared libraries for platforms."""
    stems = [crate.replace("-", "_") for crate in build.LIBRARIES]
    return [
        build.target_directory()
        / TARGETS[name]
        / "fmu"
        / (f"{stem}.dll" if name == "win64" else f"lib{stem}.so")
        for name in names
        for stem in stems
    ]
