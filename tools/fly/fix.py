"""Format what the tests check: Rust, Python, and prose in Markdown of at most 120 columns.

Tools that format all of Markdown (mdformat) would rewrite every table of the repository.
"""

from __future__ import annotations

import re
import textwrap
from pathlib import Path

from fly import environment
from fly.all_tests import PYTHON_SOURCES
from fly.stages import ROOT, answer, run, stage

COLUMNS = 120
ITEM = re.compile(r"(?P<indent>[ >]*)(?P<mark>(?:[-*+]|\d+[.)]) +)?(?P<text>\S.*)")
"""A line of prose: indentation or quotation, the mark of a list item, and the words."""
STRUCTURE = re.compile(r"[ >]*(\||#|<|\$\$|!\[|\[[^]]+\]:|:?-{3,}|={3,}|$)")
"""What is no prose: tables, headings, HTML, formulas, pictures, link targets, rules, empty lines."""
PACKAGE = re.compile(r'^name = "(.*)"', re.MULTILINE)
SNAPSHOT = "SnapshotAssertion"
"""What a test that holds messages names."""
FENCE = re.compile(r"[ >]*(```|~~~)")
MARK = re.compile(r" (?=(?:[-*+]|\d+[.)]|#+|>|\||=+)(?: |$))")
"""The space before what would become a list item, a heading or a quotation at the start of a line."""


def fix() -> int:
    """Format Rust, Python and Markdown in place; return the exit code."""
    with stage("Rust: cargo fmt"):
        run(["cargo", "fmt", "--all"])
    with stage("Python: ruff format, ruff check --fix"):
        python = environment.for_tests()
        configuration = ["--config", ROOT / "tests" / "ruff.toml"]
        python.run("-m", "ruff", "format", *configuration, *PYTHON_SOURCES)
        python.run("-m", "ruff", "check", "--fix", *configuration, *PYTHON_SOURCES)
    with stage(f"Markdown: prose of more than {COLUMNS} columns"):
        for name in answer(["git", "ls-files", "*.md"]).splitlines():
            if wrap_file(ROOT / name):
                print(f"    {name}")
    print("\nAfter a change of a message: `python3 run.py fix --snapshots`.")
    print("After a change of a vehicle, a result or a dependency: `python3 run.py freeze`.")
    return 0


def snapshots() -> int:
    """Write the messages that tests hold again, to be reviewed in the diff; return the exit code."""
    manifests = [
        (ROOT / name).read_text("utf-8") for name in answer(["git", "ls-files", "*Cargo.toml"]).splitlines()
    ]
    holders = [text for text in manifests if "\ninsta.workspace" in text]
    packages = [f"--package={name[1]}" for text in holders if (name := PACKAGE.search(text))]
    with stage("Rust: the tests of the crates with snapshots"):
        run(
            ["cargo", "test", "--release", *packages, "--tests"],
            variables={"INSTA_UPDATE": "always", "CI": ""},
        )
    with stage("Python: pytest --snapshot-update"):
        tests = (ROOT / "tests" / "python").rglob("test_*.py")
        holding = [path for path in sorted(tests) if SNAPSHOT in path.read_text("utf-8")]
        python = environment.for_tests()
        python.run("-m", "pytest", "-c", ROOT / "tests" / "pytest.ini", "--snapshot-update", *holding)
    return 0


def wrap_file(path: Path) -> bool:
    """Wrap the long paragraphs of a file; return True if there were any."""
    text = path.read_text(encoding="utf-8")
    wrapped = wrap(text)
    if wrapped != text:
        path.write_text(wrapped, encoding="utf-8")
    return wrapped != text


def wrap(text: str) -> str:
    """Wrap each paragraph and list item with a line of more than 120 columns; leave everything else unchanged."""
    done: list[str] = []
    paragraph: list[str] = []
    in_code = False
    for line in text.splitlines():
        fence = bool(FENCE.match(line))
        item = ITEM.match(line)
        code = in_code or fence or (line.startswith(("    ", "\t")) and not paragraph)
        prose = not (code or STRUCTURE.match(line))
        if not prose or (item and item["mark"]):
            done += wrapped(paragraph)
            paragraph = []
        (paragraph if prose else done).append(line)
        in_code ^= fence
    return "\n".join([*done, *wrapped(paragraph), ""])


def wrapped(paragraph: list[str]) -> list[str]:
    """Wrap one paragraph if one of its lines is too long."""
    if all(len(line) <= COLUMNS for line in paragraph):
        return paragraph
    matches = [ITEM.match(line) for line in paragraph]
    first = matches[0]
    mark = first["mark"] or ""
    words = " ".join([first["text"], *((match["mark"] or "") + match["text"] for match in matches[1:])])
    hanging = matches[1]["indent"] if len(matches) > 1 and not mark else first["indent"] + " " * len(mark)
    lines = textwrap.wrap(
        MARK.sub("\0", words),
        COLUMNS,
        initial_indent=first["indent"] + mark,
        subsequent_indent=hanging,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace("\0", " ") for line in lines]
