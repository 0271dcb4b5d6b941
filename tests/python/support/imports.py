"""Dependencies between the files of a crate, read from its Rust sources, and their cycles.

A re-export is not a dependency: a name is followed to the file that defines it. Code compiled only for tests is
ignored.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

NOT_CODE = re.compile(
    r"""r(?P<hashes>\#*)"(?s:.*?)"(?P=hashes)|"(?:\\(?s:.)|[^"\\])*"|'(?:\\[^']*|[^'\\])'|//[^\n]*|/\*(?s:.*?)\*/""",
    re.VERBOSE,
)
USE = re.compile(r"(?P<public>pub(?:\([^)]*\))?\s+)?\buse\s+(?P<tree>[^;]+);")
PATH = re.compile(r"(?<![\w:])(?:\w+::)+\w+")
FOR_TESTS = re.compile(r"#\[cfg\(test\)\]\s*(?:pub(?:\([^)]*\))?\s+)?mod\s+(\w+)\s*(;|\{)")

Name = tuple[str, ...]
"""A module: the names on the way to it from the root of the crate, whose own is empty."""


@dataclass
class Module:
    """Declarations and uses of a file."""

    code: str
    """The text without comments, strings and `use`."""
    imports: dict[str, Name] = field(default_factory=dict)
    """The path behind each name that `use` brings in."""
    exports: set[str] = field(default_factory=set)
    """Which of these others may use in turn."""
    globs: list[Name] = field(default_factory=list)
    """The modules of which everything is brought in."""


def leaves(tree: str, before: Name = ()) -> Iterator[tuple[str, Name]]:
    """Yield name and path of each leaf of a tree of `use`."""
    tree = tree.strip()
    head, brace, inner = tree.partition("{")
    if not brace:
        path, _, alias = (part.strip() for part in tree.partition(" as "))
        segments = (*before, *path.split("::"))
        if segments[-1] == "self":
            segments = segments[:-1]
        yield alias or segments[-1], segments
        return
    before = (*before, *head.strip().split("::")[:-1])
    depth, begin = 0, 0
    inner = inner[: inner.rindex("}")] + ","
    for place, character in enumerate(inner):
        depth += (character == "{") - (character == "}")
        if character == "," and depth == 0:
            if inner[begin:place].strip():
                yield from leaves(inner[begin:place], before)
            begin = place + 1


def without_tests(code: str) -> str:
    """Remove inline modules that are only for tests."""
    while found := next((m for m in FOR_TESTS.finditer(code) if m[2] == "{"), None):
        depth, end = 1, found.end()
        while depth:
            depth += {"{": 1, "}": -1}.get(code[end], 0)
            end += 1
        code = code[: found.start()] + code[end:]
    return code


def parsed(text: str) -> tuple[Module, set[str]]:
    """Return the declarations of a file, and the modules that it declares only for tests."""
    code = without_tests(NOT_CODE.sub(" ", text))
    module = Module(USE.sub(" ", code))
    for use in USE.finditer(code):
        for name, path in leaves(use["tree"]):
            if name == "*":
                module.globs.append(path[:-1])
                continue
            module.imports[name] = path
            if use["public"]:
                module.exports.add(name)
    return module, {found[1] for found in FOR_TESTS.finditer(code)}


class Crate:
    """The modules of a crate."""

    def __init__(self, source: Path) -> None:
        self.modules: dict[Name, Module] = {}
        self.files: dict[Name, str] = {}
        root = next(path for name in ("lib.rs", "main.rs") if (path := source / name).is_file())
        tests: set[Name] = set()
        for path in sorted(source.rglob("*.rs")):
            name = () if path == root else path.relative_to(source).with_suffix("").parts
            if path != root and name in (("main",), ("lib",)):
                continue
            self.files[name] = str(path.relative_to(source))
            self.modules[name], own = parsed(path.read_text(encoding="utf-8"))
            tests |= {(*name, test) for test in own}
        for name in list(self.modules):
            if any(name[: len(test)] == test for test in tests):
                del self.modules[name]

    def file_of(self, here: Name, path: Name, seen: frozenset = frozenset()) -> Name | None:
        """Return the module whose file defines what a path names; none for another crate."""
        first, rest = path[0], path[1:]
        if (here, path) in seen:
            return None
        seen |= {(here, path)}
        if first in ("crate", "self", "super"):
            at = {"crate": (), "self": here, "super": here[:-1]}[first]
            while rest and rest[0] == "super":
                at, rest = at[:-1], rest[1:]
        elif (*here, first) in self.modules:
            at = (*here, first)
        elif first in self.modules[here].imports:
            return self.file_of(here, (*self.modules[here].imports[first], *rest), seen)
        else:
            return None
        while rest and (*at, rest[0]) in self.modules:
            at, rest = (*at, rest[0]), rest[1:]
        if rest and rest[0] in self.modules[at].exports:
            return self.file_of(at, (*self.modules[at].imports[rest[0]], *rest[1:]), seen)
        return at

    def used_by(self, here: Name) -> set[Name]:
        """Return the modules whose files one uses."""
        module = self.modules[here]
        words = set(re.findall(r"\w+", module.code))
        paths = [path for name, path in module.imports.items() if name not in module.exports or name in words]
        paths += module.globs + [tuple(path.split("::")) for path in PATH.findall(module.code)]
        return {used for path in paths if (used := self.file_of(here, path)) is not None} - {here}

    def circles(self) -> list[str]:
        """Return the cycles, each as `user.rs -> used.rs -> ...`; each is cut where it closes, to find the next."""
        uses = {name: sorted(self.used_by(name)) for name in self.modules}
        found = []
        while True:
            try:
                TopologicalSorter(uses).prepare()
            except CycleError as circle:
                used, user, *_ = way = circle.args[1]
                found.append(" -> ".join(self.files[name] for name in reversed(way)))
                uses[user].remove(used)
            else:
                return found
