"""The binaries of the FMUs for all platforms, by cargo-zigbuild with Zig as the linker, from any one of them."""

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
"""The oldest C library of Linux that Rust's own library runs on: of 2012, in RHEL 7 and all that is younger."""
TARGETS = {
    "linux64": "x86_64-unknown-linux-gnu",
    "win64": "x86_64-pc-windows-gnu",
    "aarch64-linux": "aarch64-unknown-linux-gnu",
}
"""FMI's names of the platforms, and Rust's."""
HERE = {("linux", "x86_64"): "linux64", ("linux", "aarch64"): "aarch64-linux", ("win32", "AMD64"): "win64"}
"""FMI's name of the platform that this runs on."""


def named(words: str) -> list[str]:
    """Return the platforms that a command line names, `all` or some with commas between; none for `host`."""
    names = list(TARGETS) if words == "all" else [] if words == "host" else words.split(",")
    unknown = [name for name in names if name not in TARGETS]
    if unknown:
        raise StageError(
            f"--platforms is '{words}'; it must be host, all, or some of {', '.join(TARGETS)} with commas between."
        )
    return names


def option(names: list[str]) -> str:
    """Return the value of `--platforms` of `squid package`: this platform is always there, for the flights."""
    here = HERE.get((sys.platform, platform.machine()))
    return ",".join(names if here in names else ["host", *names])


def tools() -> Environment:
    """Return the environment with cargo-zigbuild and Zig, made first if it is missing."""
    return environment.ready("platforms", REQUIREMENTS)


def build_all(names: list[str]) -> None:
    """Build the binaries for platforms, by their FMI names."""
    if not names:
        return
    add_targets(names)
    found = tools()
    scripts = found.scripts
    path = os.pathsep.join([str(scripts), os.environ["PATH"]])
    variables = {**found.variables, "PATH": path, "CARGO_ENCODED_RUSTFLAGS": build.without_paths()}
    for name in names:
        target = TARGETS[name] + ("" if name == "win64" else f".{GLIBC}")
        for crate in build.FMU_CRATES:
            words = [scripts / "cargo-zigbuild", "rustc", "--target", target, "-p", crate]
            run([*words, *build.CDYLIB], variables=variables)


def add_targets(names: list[str]) -> None:
    """Let rustup install Rust's own library for platforms; without rustup it must be there already."""
    if shutil.which("rustup") is None:
        return
    words = ["rustup", "target", "list", "--installed"]
    there = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()
    missing = [TARGETS[name] for name in names if TARGETS[name] not in there]
    if missing:
        run(["rustup", "target", "add", *missing])


def binaries(names: list[str]) -> list[Path]:
    """Return the paths of the shared libraries for platforms."""
    stems = [crate.replace("-", "_") for crate in build.FMU_CRATES]
    return [
        build.target_directory()
        / TARGETS[name]
        / "fmu"
        / (f"{stem}.dll" if name == "win64" else f"lib{stem}.so")
        for name in names
        for stem in stems
    ]
