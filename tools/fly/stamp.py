"""Stamps: files with a hash of the inputs of a result, so that it is not computed again."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path


def digest(files: Iterable[Path], *words: str) -> str:
    """Return the hash of names and contents of files, and of texts."""
    whole = hashlib.sha256()
    for word in words:
        whole.update(f"{len(word)}:{word};".encode())
    for file in files:
        content = file.read_bytes()
        whole.update(f"{file.name}:{len(content)};".encode())
        whole.update(content)
    return whole.hexdigest()


def is_fresh(stamp: Path, expected: str) -> bool:
    """Return True if the stamp has the expected hash."""
    return stamp.is_file() and stamp.read_text(encoding="utf-8").strip() == expected


def write(stamp: Path, value: str) -> None:
    """Write a hash."""
    stamp.write_text(value + "\n", encoding="utf-8")
