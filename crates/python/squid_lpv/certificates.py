"""Proofs of a gain, and their check."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from squid_lpv import _core


@dataclass(frozen=True)
class Theorem:
    """What a certificate proves: `gamma` is None where it claims nothing of parameters that move however fast."""

    claim: str
    gamma: float | None
    gamma_with_model_error: float | None = None
    gamma_at_rate: float | None = None

    def __str__(self) -> str:
        """Return the claim."""
        return self.claim


@dataclass(frozen=True)
class Certificate:
    """The matrices that prove a gain, as JSON; `squid verify` and a program of your own can check them, too."""

    text: str

    @classmethod
    def read(cls, path: str | Path) -> Certificate:
        """Read a file."""
        return cls(Path(path).read_text(encoding="utf-8"))

    def save(self, path: str | Path) -> None:
        """Write a file."""
        Path(path).write_text(self.text, encoding="utf-8")

    def verify(self) -> Theorem:
        """Prove the gain again, in exact rational arithmetic.

        Raises:
            NumericalError: it is not proved.
            InputError: the text is no certificate.

        """
        return Theorem(**json.loads(_core.prove(self.text)))
