"""Stamps: a file that remembers from which inputs something was made, so that it need not be made again."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path


def digest(files: Iterable[Path], *words: str) -> str:
    """Hash names and contents of files, and some words."""
    whole = hashlib.sha256()
    for word in words:
        whole.update(f"{len(word)}:{word};".encode())
    for file in files:
        content = file.read_bytes()
        whole.update(f"{file.name}:{len(content)};".encode())
        whole.update(content)
    return whole.hexdigest()


def is_fresh(stamp: Path, expected: str) -> bool:
    """Tell whether the stamp holds the expected hash."""
    return stamp.is_file() and stamp.read_text(encoding="utf-8").strip() == expected


def write(stamp: Path, value: str) -> None:
    """Remember a hash."""
    stamp.write_text(value + "\n", encoding="utf-8")
