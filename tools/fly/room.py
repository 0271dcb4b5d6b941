"""Room on the disk, asked for before the work: compilers and tests tell of a full disk in words that mislead."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from fly.stages import BUILD, ROOT, StageError

ENOUGH = 0.5
"""Free disk (GB) with which everything can be made anew that changes from one run to the next."""


def ask_for(gigabytes: float, what: str) -> None:
    """Stop unless the disks have room for what is made the first time, or for a run after the first."""
    needed = ENOUGH if BUILD.exists() else gigabytes
    for folder in (ROOT, Path(tempfile.gettempdir())):
        free = free_in(folder)
        if free < needed:
            raise StageError(f"{what} take {needed:g} GB of disk, and {folder} has {free:.1f} GB left.")


def free_in(folder: Path) -> float:
    """Return the free disk under a folder (GB)."""
    return shutil.disk_usage(folder).free / 1e9
