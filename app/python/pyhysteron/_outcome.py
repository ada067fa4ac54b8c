"""Outcomes: from JSON to data classes and back."""

from __future__ import annotations

import dataclasses
import functools
import html
import types
import typing
from typing import Any, Literal, Union

__all__ = ["Outcome", "read"]

# JSON has no word for them.
_NOT_FINITE = {"NaN": float("nan"), "Infinity": float("inf"), "-Infinity": float("-inf")}


class Outcome:
    """The base of all outcomes and their parts: data classes with the keys of `metrics.json`, all numbers in SI."""

    def to_dict(self) -> dict[str, Any]:
        """The outcome as nested dictionaries and lists, without the keys that do not apply."""
        return typing.cast("dict[str, Any]", _plain(self))

    def _repr_html_(self) -> str:
        verdict = getattr(self, "verdict", None)
        sentence = getattr(verdict, "sentence", None)
        head = f"<p><b>{html.escape(str(sentence))}</b></p>" if sentence else ""
        rows = "".join(
            f"<tr><td>{html.escape(key)}</td><td>{_short(value)}</td></tr>"
            for key, value in self.to_dict().items()
        )
        return f"{head}<table><tr><th>{type(self).__name__}</th><th></th></tr>{rows}</table>"


def _short(value: object) -> str:
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return html.escape(text if len(text) <= 120 else text[:117] + "…")


def _key(field: dataclasses.Field[Any]) -> str:
    """The key of a field; one that is no name of Python stands with the field."""
    return str(field.metadata.get("key", field.name))


def _plain(value: object) -> object:
    if dataclasses.is_dataclass(value):
        pairs = ((_key(field), getattr(value, field.name)) for field in dataclasses.fields(value))
        return {key: _plain(item) for key, item in pairs if item is not None}
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value


@functools.lru_cache(maxsize=None)
def _hints(cls: type) -> dict[str, Any]:
    return typing.get_type_hints(cls)


def read(kind: Any, value: Any) -> Any:
    """A value of JSON as `kind`; numbers that are not finite come from their texts."""
    if kind is float:
        return _NOT_FINITE[value] if isinstance(value, str) else float(value)
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        hints = _hints(kind)
        fields = [(field.name, _key(field)) for field in dataclasses.fields(kind)]
        return kind(**{name: read(hints[name], value[key]) for name, key in fields if key in value})
    origin = typing.get_origin(kind)
    arguments = typing.get_args(kind)
    if origin is list:
        return [read(arguments[0], item) for item in value]
    if origin is dict:
        return {key: read(arguments[1], item) for key, item in value.items()}
    if origin in (Union, types.UnionType):
        return read(next(one for one in arguments if _fits(one, value)), value)
    return value


def _fits(kind: Any, value: Any) -> bool:
    """Whether a value of JSON can be of this kind: the first member of a union that fits is taken."""
    if kind is type(None):
        return value is None
    if kind is float:
        return (isinstance(value, (int, float)) and not isinstance(value, bool)) or (
            isinstance(value, str) and value in _NOT_FINITE
        )
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        fields = dataclasses.fields(kind)
        required = {_key(field) for field in fields if field.default is dataclasses.MISSING}
        known = {_key(field) for field in fields}
        return isinstance(value, dict) and required <= value.keys() <= known
    origin = typing.get_origin(kind)
    if origin is Literal:
        return value in typing.get_args(kind)
    if origin is dict:
        key = typing.get_args(kind)[0]
        return isinstance(value, dict) and all(key is str or _fits(key, name) for name in value)
    if origin is list:
        return isinstance(value, list)
    if kind is Any:
        return True
    return isinstance(value, kind)
