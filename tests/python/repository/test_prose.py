"""Tests ask for fields; sentences that the user reads are held by snapshots, which one command updates."""

from __future__ import annotations

import ast
import re
import subprocess
from collections.abc import Iterator

import pytest
from fly.stages import ROOT

pytestmark = pytest.mark.change

PROSE = re.compile(r"[A-Za-z]{2,}[,;:.]? [a-z]{2,}[,;:.]? [A-Za-z]{2,}")
"""Three words in a row."""
RUST_ASSERTION = re.compile(r"\bassert(?:_eq|_ne)?!\(|\.(?:contains|starts_with|ends_with)\(")
RUST_TOKEN = re.compile(r"""'(?:[^'\\]|\\.)'|"(?:[^"\\]|\\.)*"|[(\[{}\])]|,""", re.DOTALL)


def of_python(text: str) -> Iterator[tuple[int, str]]:
    """Yield the line and the text of each sentence that an assertion compares."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Assert):
            compared: list[ast.expr] = [node.test]
        elif isinstance(node, ast.Call):
            compared = [word.value for word in node.keywords if word.arg == "match"]
        else:
            continue
        for part in (part for expression in compared for part in ast.walk(expression)):
            if isinstance(part, ast.Constant) and isinstance(part.value, str) and PROSE.search(part.value):
                yield part.lineno, part.value


def of_rust(text: str) -> Iterator[tuple[int, str]]:
    """Yield the line and the text of each sentence that an assertion compares; its own message is none."""
    for call in RUST_ASSERTION.finditer(text):
        depth, argument = 1, 0
        compared = 2 if call[0].endswith(("_eq!(", "_ne!(")) else 1
        for token in RUST_TOKEN.finditer(text, call.end()):
            word = token[0]
            if word in "([{":
                depth += 1
            elif word in ")]}":
                depth -= 1
            elif word == "," and depth == 1:
                argument += 1
            elif word.startswith('"') and argument < compared and PROSE.search(word):
                yield text.count("\n", 0, token.start()) + 1, word
            if depth == 0 or argument == compared:
                break


def found(pattern: str) -> list[str]:
    words = ["git", "ls-files", "--cached", "--others", "--exclude-standard", pattern]
    listed = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    prose = []
    for name in listed:
        text = (ROOT / name).read_text(encoding="utf-8")
        if name.endswith(".py"):
            sentences = set(of_python(text))
        elif "/tests/" in name:
            sentences = set(of_rust(text))
        else:
            before, _, tests = text.partition("#[cfg(test)]")
            offset = before.count("\n")
            sentences = {(offset + line, word) for line, word in of_rust(tests)}
        prose += [f"{name}:{line}: {word[:80]}" for line, word in sorted(sentences)]
    return prose


@pytest.mark.parametrize("pattern", ["tests/python/*.py", "*.rs"])
def test_no_assertion_holds_a_sentence(pattern: str) -> None:
    prose = found(pattern)
    assert not prose, "\n".join(prose)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('assert "one of these words" in text, "this is not seen"', [1]),
        ('with raises(Error, match="one of these words"):\n    run("one of these words")', [1]),
        ('assert text["one"] == "two words"', []),
    ],
)
def test_sentences_of_python_are_seen(text: str, expected: list[int]) -> None:
    assert [line for line, _ in of_python(text)] == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('assert_eq!(a.b(c, "d"),\n"one of these words", "the message is free");', [2]),
        ('assert!(a, "the message is free");', []),
        ('let found = text\n.contains("one of these words");', [2]),
        ("assert!(a == ')', \"the message is free\");", []),
    ],
)
def test_sentences_of_rust_are_seen(text: str, expected: list[int]) -> None:
    assert [line for line, _ in of_rust(text)] == expected
