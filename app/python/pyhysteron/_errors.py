"""Exceptions: the words are those of the program."""

from __future__ import annotations

from typing import Any

__all__ = ["BadInput", "Cancelled", "Error", "Failed"]


class Error(Exception):
    """The error of a verb or a class of this package."""

    outcome: Any = None
    """The outcome that a verb ended with all the same, as `check` with recordings that cannot be right."""

    outcome_json: str | None = None
    """The same as JSON."""


class BadInput(Error, ValueError):
    """Input that cannot be used: `place: expected …, got … (hint: …)`. The program ends with exit code 2."""

    place: str
    """File and key, row or option."""
    expected: str
    """Accepted values."""
    found: str
    """The value found."""
    hint: str
    """Advice; empty where nothing helps."""

    def __init__(
        self, message: str, place: str = "", expected: str = "", found: str = "", hint: str = ""
    ) -> None:
        super().__init__(message, place, expected, found, hint)
        self.place, self.expected, self.found, self.hint = place, expected, found, hint

    def __str__(self) -> str:
        return str(self.args[0])


class Cancelled(Error):
    """A verb was interrupted; the message names the results that are kept."""


class Failed(Error, RuntimeError):
    """Everything else: a step without an equilibrium, a disk that is full. The program ends with exit code 1."""
