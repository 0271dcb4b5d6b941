"""The licences of the crates that are compiled into the FMUs, as one file that goes into each of them.

`python3 run.py freeze` writes crates/package/third_party.txt; a test checks that it is current and that every licence
is allowed.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from fly import build, platforms
from fly.stages import ROOT, StageError, answer

FILE = ROOT / "crates" / "package" / "third_party.txt"
ALLOWED = ("MIT", "Apache-2.0")
"""Accepted licences, in order of preference."""
TEXTS = re.compile(r"^licen[cs]e([-.](mit|txt|md))*$", re.IGNORECASE)
HEAD = """\
The binaries of this FMU contain Rust's standard library (MIT OR Apache-2.0, https://www.rust-lang.org) and the crates
below, each under the licence named first in its line. The text of the Apache License 2.0 is in LICENSE-APACHE.
"""


def compiled_in() -> list[dict]:
    """Return the third-party packages linked into the FMUs, by name; procedural macros are not linked.

    `cargo metadata` has their licences, but also lists packages of disabled features; `cargo tree` has those built.
    """
    words = [
        "cargo",
        "tree",
        "--locked",
        "--edges",
        "normal,no-proc-macro",
        "--prefix",
        "none",
        "--format",
        "{p}",
    ]
    for crate in build.LIBRARIES:
        words += ["--package", crate]
    for target in platforms.TARGETS.values():
        words += ["--target", target]
    built = {tuple(line.split()[:2]) for line in answer(words).splitlines() if line}
    packages = json.loads(answer(["cargo", "metadata", "--locked", "--format-version", "1"]))["packages"]
    foreign = [p for p in packages if p["source"] and (p["name"], f"v{p['version']}") in built]
    return sorted(foreign, key=lambda package: (package["name"], package["version"]))


def chosen(package: dict) -> str:
    """Return the licence under which a crate is shipped."""
    offered = set(re.split(r"\s+OR\s+|/", package["license"] or ""))
    for licence in ALLOWED:
        if licence in offered:
            return licence
    name = f"{package['name']} {package['version']}"
    raise StageError(f"{name} is under '{package['license']}', but only {', '.join(ALLOWED)} can be shipped.")


def text() -> str:
    """Return the file: a line for each crate, followed by the text of its MIT licence if that was chosen."""
    parts = [HEAD]
    for package in compiled_in():
        licence = chosen(package)
        line = f"{package['name']} {package['version']}: {licence} (offered: {package['license']})"
        if package["repository"]:
            line += f", {package['repository']}"
        parts.append(f"{'-' * 80}\n{line}\n")
        if licence == "MIT":
            parts.append(mit(package))
    return "\n".join(parts)


def mit(package: dict) -> str:
    """Return the text of a crate's MIT licence."""
    folder = Path(package["manifest_path"]).parent
    files = sorted((path for path in folder.iterdir() if TEXTS.match(path.name)), key=preference)
    for path in files:
        words = path.read_text(encoding="utf-8", errors="replace")
        if "Permission is hereby granted, free of charge" in words:
            return "\n".join(line.rstrip() for line in words.strip().splitlines()) + "\n"
    raise StageError(f"{package['name']} {package['version']} does not contain the text of the MIT licence.")


def preference(path: Path) -> tuple[bool, str]:
    """Return the sort key: files with MIT in their name first."""
    return "mit" not in path.name.lower(), path.name


def write() -> None:
    """Write the file."""
    FILE.write_text(text(), encoding="utf-8", newline="\n")
