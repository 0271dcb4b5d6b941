"""Doc comments have a subject: the item that they describe, or a verb in the third person of which it is one."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator

import pytest
from fly.stages import ROOT

pytestmark = pytest.mark.change

WITHOUT_SUBJECT = re.compile(
    "After|Again|Also|Among|As|At|Because|Before|Beside|Between|Beyond|By|For|From|How|If|In|Into|Its?|Like|None|Not"
    "|Of|On|Only|Out|Over|Same|So|That|Their|Them|Then|These|They|Those|Through|To|Under|Up|What|When|Where|Whether"
    "|Which|Why|With|Without"
)
"""First words of a comment that says something of an item without saying what the item is or does."""
COMMENT = re.compile(r"\s*//[/!] ?(.*)")


def first_words(text: str) -> Iterator[tuple[int, str]]:
    """Yield the line and the first word of each doc comment of a Rust file."""
    inside = False
    for line, code in enumerate(text.splitlines(), 1):
        comment = COMMENT.match(code)
        if comment and not inside and comment[1].strip():
            yield line, re.split(r"[\s,.:;]", comment[1].strip())[0]
        inside = bool(comment) and (inside or bool(comment[1].strip()))


def test_doc_comments_have_a_subject() -> None:
    words = ["git", "ls-files", "*.rs"]
    listed = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    found = [
        f"{name}:{line}: {word}"
        for name in listed
        if "/tests/" not in name and "/examples/" not in name
        for line, word in first_words((ROOT / name).read_text(encoding="utf-8"))
        if WITHOUT_SUBJECT.fullmatch(word)
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("/// Speed, m/s.\n/// Of the body.\nspeed: f64,", [(1, "Speed")]),
        ("//! What it is.\n\n/// Of one.\n", [(1, "What"), (3, "Of")]),
        ("// Of code.\n    /// Whether it is.\n", [(2, "Whether")]),
    ],
)
def test_the_first_word_is_seen(text: str, expected: list[tuple[int, str]]) -> None:
    assert list(first_words(text)) == expected
