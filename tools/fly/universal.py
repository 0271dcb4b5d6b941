"""Join libraries for the processors of macOS into one, as Apple's `lipo` does; the format is that of <mach-o/fat.h>.

cargo-zigbuild 0.24 joins libraries in the order in which cargo finished them, which mixes up those of several crates.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

THIN = 0xFEEDFACF
FAT = 0xCAFEBABE
ALIGNMENT = 14
"""Exponent of two: a page of Apple's processors has 16 kB."""


def join(parts: Sequence[Path], to: Path) -> None:
    """Write one library that contains those of several processors."""
    page = 1 << ALIGNMENT
    head = struct.pack(">II", FAT, len(parts))
    body, start = b"", page
    for part in parts:
        code = part.read_bytes()
        magic, processor, variant = struct.unpack_from("<III", code)
        if magic != THIN:
            raise ValueError(f"{part} is no 64-bit Mach-O library")
        head += struct.pack(">IIIII", processor, variant, start + len(body), len(code), ALIGNMENT)
        body += code + bytes(-len(code) % page)
    to.parent.mkdir(parents=True, exist_ok=True)
    unfinished = to.with_name(f".{to.name}")
    unfinished.write_bytes(head.ljust(page, b"\0") + body)
    unfinished.replace(to)
