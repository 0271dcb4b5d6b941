"""What cargo builds: the command `squid` and the three binaries inside the FMUs."""

from __future__ import annotations

import json
import os
import sys
from functools import cache
from pathlib import Path

from fly.stages import answer, run

FMU_CRATES = ("fmu-plant", "fmu-controller", "fmu-squid")
CDYLIB = ("--lib", "--crate-type", "cdylib", "--features", "export", "--profile", "fmu")


def build() -> None:
    """Build the command and the binaries; instant when nothing has changed."""
    build_command()
    for crate in FMU_CRATES:
        run(["cargo", "rustc", "-p", crate, *CDYLIB], variables={"CARGO_ENCODED_RUSTFLAGS": without_paths()})


def without_paths() -> str:
    """Return the flags that keep the builder's folders out of the binaries, added to those of the user.

    That of cargo's packages is renamed. This one must not be named: cargo compiles everything anew when a flag
    changes, and this folder may be moved. It need not be, for cargo compiles what lies here by relative paths.
    They are joined as cargo's encoded variable wants it, which bears folders with spaces.
    """
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    encoded = os.environ.get("CARGO_ENCODED_RUSTFLAGS")
    own = encoded.split("\x1f") if encoded else os.environ.get("RUSTFLAGS", "").split()
    return "\x1f".join([*own, f"--remap-path-prefix={home}=cargo"])


def build_command() -> None:
    """Build the command alone."""
    run(["cargo", "build", "--release", "-p", "squid", "--bin", "squid"])


@cache
def target_directory() -> Path:
    """Ask cargo where it puts what it builds."""
    words = ["cargo", "metadata", "--format-version", "1", "--no-deps"]
    return Path(json.loads(answer(words))["target_directory"])


def squid() -> Path:
    """Return the path of the command `squid`."""
    return target_directory() / "release" / ("squid.exe" if os.name == "nt" else "squid")


def binaries() -> list[Path]:
    """Return the paths of the shared libraries."""
    pattern = {"win32": "{}.dll", "darwin": "lib{}.dylib"}.get(sys.platform, "lib{}.so")
    names = [pattern.format(crate.replace("-", "_")) for crate in FMU_CRATES]
    return [target_directory() / "fmu" / name for name in names]
