"""Build the Python package `squid-lpv` as wheels with maturin."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from fly import libraries, platforms
from fly.stages import BUILD, ROOT, StageError, run, stage

MANIFEST = ROOT / "crates" / "python" / "Cargo.toml"
WHEELS = BUILD / "wheels"

UNOPTIMISED = {"CARGO_PROFILE_RELEASE_OPT_LEVEL": "0", "CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS": "false"}
"""A third of the processor time: for what is tried and not shipped."""


def build(platform: str = "host", to: Path = WHEELS, *, optimised: bool = True) -> Path:
    """Build the wheel for a platform: `host` for this machine alone, or an FMI name for any such machine.

    One wheel serves every Python from 3.10 on.
    """
    tools = platforms.tools()
    out = to / platform
    shutil.rmtree(out, ignore_errors=True)
    words: list[str | Path] = [
        tools.scripts / "maturin",
        "build",
        "--release",
        "--manifest-path",
        MANIFEST,
        "--out",
        out,
    ]
    path = os.pathsep.join([str(tools.scripts), os.environ["PATH"]])
    # No interpreter of that platform is needed, because the compiler knows the stable ABI. Stripped like the FMUs,
    # including dependencies: for unstripped libraries Zig compiles the C library of Windows once more.
    flags = "\x1f".join([libraries.without_paths(), "-Cstrip=symbols"])
    variables = {**tools.variables, "PATH": path, "CARGO_ENCODED_RUSTFLAGS": flags}
    variables |= {} if optimised else UNOPTIMISED
    if platform == "host":
        words += ["--interpreter", sys.executable, "--compatibility", "linux"]
        variables.pop("CARGO_ENCODED_RUSTFLAGS")
    else:
        platforms.add_targets([platform])
        words += ["--target", platforms.TARGETS[platform]]
        if platform == "win64":
            variables |= windows_tools(tools.scripts / "maturin")
        elif platform == "darwin64":
            words += ["--zig"]
            variables["MACOSX_DEPLOYMENT_TARGET"] = platforms.MACOS
        else:
            words += ["--zig", "--compatibility", "manylinux2014"]
    run(words, variables=variables, log=f"wheel-{platform}")
    return next(out.glob("*.whl"))


def windows_tools(maturin: Path) -> dict[str, str | Path]:
    """Write the commands with which cargo links with Zig for Windows, and return the variables that name them.

    With `--zig` for Windows, maturin 1.16 makes the linker look for a function `PyInit_squid_lpv._core`, named after
    the module with its package, in every library.
    """
    if os.name == "nt":
        raise StageError("on Windows the wheel for it is built with --platforms host")
    folder = WHEELS / "zig-win64"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    linker = folder / "zig-link"
    linker.write_text(f'#!/bin/sh\nexec "{maturin}" zig cc -- -target x86_64-windows-gnu "$@"\n')
    linker.chmod(0o755)
    (folder / "x86_64-w64-mingw32-dlltool").symlink_to(maturin)
    path = os.pathsep.join([str(folder), str(maturin.parent), os.environ["PATH"]])
    return {"CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER": linker, "PATH": path}


def build_all(words: str) -> int:
    """Build the wheels for `host`, `all`, or platforms by name; return the exit code."""
    names = list(platforms.TARGETS) if words == "all" else words.split(",")
    unknown = [name for name in names if name not in (*platforms.TARGETS, "host")]
    if unknown:
        raise StageError(
            f"--platforms is '{words}'; it must be host, all, or a list of {', '.join(platforms.TARGETS)}."
        )
    for platform in names:
        with stage(f"Building the wheel for {platform}"):
            print(f"    {build(platform)}")
    return 0
