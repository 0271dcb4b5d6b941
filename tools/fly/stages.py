"""Stages of a job: each is announced and timed, and a failure stops the job."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
LOGS = BUILD / "logs"


class StageError(Exception):
    """A stage failed; the message says which and why."""


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
        code = call(words, environment, None)
        if code != 0:
            raise StageError(f"`{' '.join(words)}` ended with exit code {code}.")
        return
    LOGS.mkdir(parents=True, exist_ok=True)
    path = LOGS / f"{log}.log"
    code = call(words, environment, path)
    if code != 0:
        sys.stderr.write(path.read_text(encoding="utf-8", errors="replace"))
        raise StageError(f"`{' '.join(words)}` ended with exit code {code}; its output is in {path}.")


def answer(command: Sequence[str | Path]) -> str:
    """Run a command in the root of the repository and return its standard output."""
    words = [str(word) for word in command]
    try:
        done = subprocess.run(words, cwd=ROOT, capture_output=True, encoding="utf-8", check=False)
    except FileNotFoundError:
        raise missing(words[0]) from None
    if done.returncode != 0:
        raise StageError(f"`{' '.join(words)}` failed: {done.stderr.strip()}")
    return done.stdout


def missing(program: str) -> StageError:
    """Return the error of a program that is not installed."""
    hint = " Install Rust from https://rustup.rs." if program == "cargo" else ""
    return StageError(f"the program `{program}` was not found.{hint}")


def call(words: Sequence[str], environment: Mapping[str, str], log: Path | None) -> int:
    """Run a command and return its exit code."""
    sys.stdout.flush()
    try:
        if log is None:
            return subprocess.run(words, cwd=ROOT, env=environment, check=False).returncode
        with log.open("wb") as file:
            streams = {"stdout": file, "stderr": subprocess.STDOUT}
            return subprocess.run(words, cwd=ROOT, env=environment, check=False, **streams).returncode
    except FileNotFoundError:
        raise missing(words[0]) from None
