"""Room on the disk, asked for before the work: compilers and tests tell of a full disk in words that mislead."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

from fly.stages import BUILD, ROOT, StageError

ENOUGH = 0.5
"""Free disk (GB) with which everything can be made anew that changes from one run to the next."""


def ask_for(gigabytes: float, temporary: float, what: str) -> None:
    """Stop unless there is room for what the first run makes, less what is there already, and for temporary files."""
    wanted = {
        ROOT: max(ENOUGH, gigabytes - taken_by(ROOT / "target") - taken_by(BUILD)),
        Path(tempfile.gettempdir()): temporary,
    }
    for folder, needed in wanted.items():
        free = free_in(folder)
        if free < needed:
            raise StageError(f"{what} take {needed:.1f} GB of disk, and {folder} has {free:.1f} GB left.")


def free_in(folder: Path) -> float:
    """Return the free disk under a folder (GB)."""
    return shutil.disk_usage(folder).free / 1e9


def taken_by(folder: Path) -> float:
    """Return the sizes of the files under a folder (GB), each counted once however many names it has."""
    found = {}
    for parent, _, names in os.walk(folder):
        for name in names:
            try:
                status = os.lstat(Path(parent) / name)
            except FileNotFoundError:
                continue
            found[status.st_dev, status.st_ino] = status.st_size
    return sum(found.values()) / 1e9
