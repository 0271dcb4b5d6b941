"""Claims of a certificate."""

from __future__ import annotations


def claims(certificate: dict, kind: str) -> list[dict]:
    """Return the claims of a kind; for `gain` and `rate`, that without model error is first."""
    return [claim[kind] for claim in certificate["claims"] if kind in claim]


def claim(certificate: dict, kind: str) -> dict:
    """Return the first claim of a kind."""
    return claims(certificate, kind)[0]


def robust_gain(certificate: dict) -> dict:
    """Return the claim about the gain with the model error."""
    return claims(certificate, "gain")[1]


def without_limits(certificate: dict) -> dict:
    """Return the certificate without its claim with limits, which needs the model error; changes it in place."""
    certificate["claims"] = [one for one in certificate["claims"] if "limits" not in one]
    return certificate


def without_model_error(certificate: dict) -> dict:
    """Return the certificate without the claims that cover the model error; changes it in place."""
    del without_limits(certificate)["errors"]
    certificate["claims"] = [
        one for one in certificate["claims"] if not any("lambda" in matrices for matrices in one.values())
    ]
    return certificate
