"""From keywords to the command line of a verb, and from its outcome as JSON to a typed one."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable
from typing import Any, Union, cast

from . import _pyhysteron
from ._errors import Error
from ._listener import Listener
from ._outcome import read

__all__ = ["PathLike", "flag", "option", "options", "positional", "positionals", "program", "run_verb"]

PathLike = Union[str, "os.PathLike[str]"]


def program() -> list[str]:
    """The words that start the program of this package."""
    return [sys.executable, "-m", "pyhysteron"]


def _word(value: object) -> str:
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    if isinstance(value, float):
        return repr(float(value))
    return str(value)


def positional(value: object) -> list[str]:
    """A positional argument, or none."""
    return [] if value is None else [_word(value)]


def positionals(values: object) -> list[str]:
    """Positional arguments: several values, or one."""
    return [word for value in _each(values) for word in positional(value)]


def _each(values: object) -> Iterable[object]:
    if values is None:
        return []
    if isinstance(values, (str, bytes, os.PathLike, int, float)):
        return [cast(object, values)]
    return cast("Iterable[object]", values)


def option(name: str, value: object) -> list[str]:
    """An option with one value, or none."""
    if value is None:
        return []
    word = _word(value)
    return [f"{name}={word}"] if word.startswith("-") else [name, word]


def options(name: str, values: object, delimiter: str | None) -> list[str]:
    """An option with several values, or one: in one word with a delimiter, else one option for each."""
    words = [_word(value) for value in _each(values)]
    if delimiter is None:
        return [word for value in words for word in option(name, value)]
    return option(name, delimiter.join(words)) if words else []


def flag(name: str, is_set: bool) -> list[str]:
    """An option without a value."""
    return [name] if is_set else []


def run_verb(outcome: Any, words: list[str], *, overwrite: bool, verbose: bool, progress: bool) -> Any:
    """Run a verb in this process and return its outcome, of this type."""
    arguments = words + flag("--overwrite", overwrite) + ([] if verbose else ["--quiet"])
    try:
        text = _pyhysteron.run_verb(arguments, program(), Listener(verbose, progress))
    except Error as error:
        if error.outcome_json is not None:
            error.outcome = read(outcome, json.loads(error.outcome_json))
        raise
    return read(outcome, json.loads(text))
