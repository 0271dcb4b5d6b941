"""Stages of a job: each is announced and timed, and a failure stops the job."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
LOGS = BUILD / "logs"


class StageError(Exception):
    """A stage failed; the message says which one and why."""


@contextmanager
def stage(title: str) -> Iterator[None]:
    """Print the title of a stage, and its time when it ends."""
    print(f"\n==> {title}", flush=True)
    begin = time.monotonic()
    yield
    print(f"    done in {time.monotonic() - begin:.1f} s", flush=True)


def run(
    command: Sequence[str | Path], *, variables: Mapping[str, str] | None = None, log: str | None = None
) -> None:
    """Run a command in the root of the repository.

    Its output is passed through, or written to a log that is printed if the command fails.
    """
    words = [str(word) for word in command]
    environment = {**os.environ, **(variables or {})}
    if log is None:
        done, where = call(words, env=environment), "."
    else:
        LOGS.mkdir(parents=True, exist_ok=True)
        path = LOGS / f"{log}.log"
        with path.open("wb") as file:
            done = call(words, env=environment, stdout=file, stderr=subprocess.STDOUT)
        where = f"; its output is in {path}."
        if done.returncode != 0:
            sys.stderr.write(path.read_text(encoding="utf-8", errors="replace"))
    if done.returncode != 0:
        raise StageError(f"`{' '.join(words)}` ended with exit code {done.returncode}{where}")


def answer(command: Sequence[str | Path]) -> str:
    """Run a command in the root of the repository and return its standard output."""
    words = [str(word) for word in command]
    done = call(words, capture_output=True, encoding="utf-8")
    if done.returncode != 0:
        raise StageError(f"`{' '.join(words)}` failed: {done.stderr.strip()}")
    return done.stdout


def call(words: Sequence[str], **options: Any) -> subprocess.CompletedProcess:
    """Run a program with options of `subprocess.run`; raise an error if it is not installed."""
    sys.stdout.flush()
    try:
        return subprocess.run(words, cwd=ROOT, check=False, **options)
    except FileNotFoundError:
        hint = " Install Rust from https://rustup.rs." if words[0] == "cargo" else ""
        raise StageError(f"the program `{words[0]}` was not found.{hint}") from None
