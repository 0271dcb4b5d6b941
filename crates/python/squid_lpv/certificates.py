"""Proofs of a gain, and their verification."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from squid_lpv import _core


@dataclass(frozen=True)
class Theorem:
    """Theorem of a certificate; `gamma` is None without a claim for parameters that change arbitrarily fast."""

    claim: str
    gamma: float | None
    gamma_with_model_error: float | None = None
    gamma_at_rate: float | None = None

    def __str__(self) -> str:
        """Return the claim."""
        return self.claim


@dataclass(frozen=True)
class Certificate:
    """Matrices that prove a gain, as JSON; `squid verify` and other programs can also check them."""

    text: str

    @classmethod
    def read(cls, path: str | Path) -> Certificate:
        """Read a certificate from a file."""
        return cls(Path(path).read_text(encoding="utf-8"))

    def save(self, path: str | Path) -> None:
        """Write the certificate to a file."""
        Path(path).write_text(self.text, encoding="utf-8")

    def verify(self) -> Theorem:
        """Prove the gain again, in exact rational arithmetic.

        Raises:
            NumericalError: the gain is not proved.
            InputError: the text is not a certificate.

        """
        return Theorem(**json.loads(_core.prove(self.text)))
