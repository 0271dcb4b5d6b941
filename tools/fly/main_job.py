"""The main job: from a vehicle file to simulated FMUs."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

from fly import build, environment, package, platforms, room
from fly.stages import stage

DISK = 2.5
"""Disk space of the first run, with a margin (GB)."""
TEMPORARY = 0.1
"""Disk space of temporary files (GB)."""
DISK_OF_PLATFORMS = 2.0
"""Additional disk space of the first run for other platforms (GB)."""


def run(design: package.Design, platform_words: str = "host") -> int:
    """Build, design, package and simulate; return the exit code."""
    begin = time.monotonic()
    design.check()
    names = platforms.named(platform_words)
    room.ask_for(DISK + (DISK_OF_PLATFORMS if names else 0.0), TEMPORARY, "building and flying")
    of = f" for {', '.join(platforms.with_own(names))}" if names else ""
    with (
        stage(f"Building squid and the binaries of the FMUs{of}; creating the Python environment (FMPy)"),
        ThreadPoolExecutor() as pool,
    ):
        environment_made = pool.submit(environment.ready)
        build.build(names)
        python = environment_made.result()
    with stage(f"Designing the controller of {design} and packaging its FMUs"):
        packages = package.design_and_package(design, design.folder, names)
    whole = package.report_of(design, packages.folder)
    python.run("-m", "fly.flight", packages.folder, build.squid(), design.vehicle, whole)
    print(f"\nAll done in {time.monotonic() - begin:.1f} s.")
    return 0
