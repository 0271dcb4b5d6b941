"""Licences of the crates compiled into the shipped FMUs and the Python package, one file for each.

`python3 run.py freeze` writes the files; a test checks that they are current and that every licence is allowed.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

from fly import libraries, platforms
from fly.stages import ROOT, StageError, answer


@dataclass(frozen=True)
class Shipped:
    """A shipped product: its licence file, the crates from which it is built, and the names of its binaries."""

    file: Path
    crates: tuple[str, ...]
    what: str
    allowed: tuple[str, ...]
    """Accepted licences, in order of preference."""


FMUS = Shipped(
    ROOT / "crates" / "package" / "third_party.txt",
    libraries.CRATES,
    "The binaries of this FMU contain",
    ("MIT", "Apache-2.0"),
)
WHEEL = Shipped(
    ROOT / "crates" / "python" / "third_party.txt",
    ("squid-python",),
    "The binary of this package contains",
    ("MIT", "Apache-2.0", "BSD-3-Clause"),
)
TEXTS = re.compile(r"^licen[cs]e([-.](mit|txt|md))*$", re.IGNORECASE)
HEAD = """\
{what} Rust's standard library (MIT OR Apache-2.0, https://www.rust-lang.org) and the crates
below, each under the licence named first in its line. The text of the Apache License 2.0 is in LICENSE-APACHE.
"""


def compiled_in(shipped: Shipped) -> list[dict]:
    """Return the third-party packages linked into a product, by name; procedural macros are not linked.

    `cargo metadata` has their licences, but also lists packages of disabled features; `cargo tree` lists those built.
    """
    words = ["cargo", "tree", "--locked", "--edges=normal,no-proc-macro", "--prefix=none", "--format={p}"]
    for crate in shipped.crates:
        words += ["--package", crate]
    for target in platforms.rust_targets(list(platforms.TARGETS)):
        words += ["--target", target]
    built = {tuple(line.split()[:2]) for line in answer(words).splitlines() if line}
    packages = json.loads(answer(["cargo", "metadata", "--locked", "--format-version", "1"]))["packages"]
    foreign = [p for p in packages if p["source"] and (p["name"], f"v{p['version']}") in built]
    return sorted(foreign, key=lambda package: (package["name"], package["version"]))


def chosen(package: dict, allowed: tuple[str, ...]) -> str:
    """Return the licence under which a crate is shipped."""
    offered = set(re.split(r"\s+OR\s+|/", package["license"] or ""))
    for licence in allowed:
        if licence in offered:
            return licence
    name = f"{package['name']} {package['version']}"
    raise StageError(f"{name} is under '{package['license']}', but only {', '.join(allowed)} can be shipped.")


def text(shipped: Shipped) -> str:
    """Return the file: a line for each crate, followed by the text of its licence if it requires a notice."""
    parts = [HEAD.format(what=shipped.what)]
    for package in compiled_in(shipped):
        licence = chosen(package, shipped.allowed)
        line = f"{package['name']} {package['version']}: {licence} (offered: {package['license']})"
        if package["repository"]:
            line += f", {package['repository']}"
        parts.append(f"{'-' * 80}\n{line}\n")
        if licence in NOTICES:
            parts.append(notice(package, licence))
    return "\n".join(parts)


NOTICES = {
    "MIT": "Permission is hereby granted, free of charge",
    "BSD-3-Clause": "Redistribution and use in source and binary forms",
}
"""Licences whose text goes along, and words of it."""


def notice(package: dict, licence: str) -> str:
    """Return the text of a crate's licence; for a crate under MIT without one, its authors."""
    folder = Path(package["manifest_path"]).parent
    files = sorted((path for path in folder.iterdir() if TEXTS.match(path.name)), key=preference)
    for path in files:
        words = path.read_text(encoding="utf-8", errors="replace")
        if NOTICES[licence] in words:
            return "\n".join(line.rstrip() for line in words.strip().splitlines()) + "\n"
    if licence == "MIT":
        authors = ", ".join(package["authors"]) or f"the authors of {package['name']}"
        return f"Copyright (c) {authors}\nThe terms are those of LICENSE-MIT.\n"
    raise StageError(
        f"{package['name']} {package['version']} does not contain the text of its licence, {licence}."
    )


def preference(path: Path) -> tuple[bool, str]:
    """Return the sort key: files with MIT in their name first."""
    return "mit" not in path.name.lower(), path.name


def write() -> None:
    """Write the files."""
    for shipped in (FMUS, WHEEL):
        shipped.file.write_text(text(shipped), encoding="utf-8", newline="\n")
