"""Recordings as data frames of other packages."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas
    import polars
    import xarray

    from ._pyhysteron import Recording

__all__ = ["to_pandas", "to_polars", "to_xarray", "unit_of"]

_UNITS = ("m", "n", "rad", "a", "v", "s", "hz", "c", "nm", "w", "pa")


def unit_of(name: str) -> str:
    """The unit that a channel's name ends in; empty where it has none."""
    last = name.rsplit("_", 1)[-1]
    return last if last in _UNITS else ""


def to_pandas(recording: Recording) -> pandas.DataFrame:
    """A data frame with the times as index."""
    import pandas

    index = pandas.Index(recording.time, name="time_s")
    frame = pandas.DataFrame(dict(recording.items()), index=index, copy=False)
    frame.attrs.update(recording.metadata)
    return frame


def to_polars(recording: Recording) -> polars.DataFrame:
    """A data frame with the times first."""
    import polars

    return polars.DataFrame({"time_s": recording.time, **dict(recording.items())})


def to_xarray(recording: Recording) -> xarray.Dataset:
    """A data set over the times."""
    import xarray

    def variable(name: str) -> tuple[str, object, dict[str, str]]:
        unit = unit_of(name)
        return "time_s", recording[name], {"units": unit} if unit else {}

    return xarray.Dataset(
        {name: variable(name) for name in recording},
        coords={"time_s": ("time_s", recording.time, {"units": "s"})},
        attrs=recording.metadata,
    )
