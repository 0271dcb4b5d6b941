"""Check the disk space in advance: on a full disk compilers and tests fail with misleading messages."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

from fly.stages import BUILD, ROOT, StageError

ENOUGH = 0.5
"""Free disk space (GB) that suffices for all files that change from one run to the next."""


def ask_for(gigabytes: float, temporary: float, what: str) -> None:
    """Raise an error unless the disk has space for the first run, less the existing files, and for temporary files."""
    wanted = {
        ROOT: max(ENOUGH, gigabytes - taken_by(ROOT / "target") - taken_by(BUILD)),
        Path(tempfile.gettempdir()): temporary,
    }
    for folder, needed in wanted.items():
        free = free_in(folder)
        if free < needed:
            raise StageError(
                f"{what} need {needed:.1f} GB of disk space, and {folder} has {free:.1f} GB free."
            )


def free_in(folder: Path) -> float:
    """Return the free disk space of a folder (GB)."""
    return shutil.disk_usage(folder).free / 1e9


def taken_by(folder: Path) -> float:
    """Return the total size of the files under a folder (GB); hard links count once."""
    sizes = {}
    for parent, _, names in os.walk(folder):
        for name in names:
            try:
                status = os.lstat(Path(parent) / name)
            except FileNotFoundError:
                continue
            sizes[status.st_dev, status.st_ino] = status.st_size
    return sum(sizes.values()) / 1e9
