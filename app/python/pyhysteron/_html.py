"""How scenes and recordings look in a notebook."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._pyhysteron import Recording, Scene

__all__ = ["recording", "scene"]

_POINTS = 200


def _table(rows: Sequence[tuple[str, ...]], head: tuple[str, ...]) -> str:
    def line(cells: tuple[str, ...], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{cell}</{tag}>" for cell in cells) + "</tr>"

    return "<table>" + line(head, "th") + "".join(line(row, "td") for row in rows) + "</table>"


def scene(of: Scene) -> str:
    """A table of the robot and one of its tendons."""
    rows = [
        ("Young's modulus", f"{of.youngs_modulus / 1e6:.4g} MPa"),
        ("Poisson's ratio", f"{of.poisson_ratio:.4g}"),
        ("gravity", ", ".join(f"{c:.4g}" for c in of.gravity) + " m/s²"),
        ("auxiliary tendons", str(of.n_auxiliary)),
        ("mesh", html.escape(str(of.mesh_path))),
    ]
    tendons = [
        (html.escape(name), drive, f"{1e3 * low:.4g} to {1e3 * high:.4g} mm")
        for name, drive, (low, high) in zip(of.tendon_names, of.drives, of.stroke_bounds)
    ]
    return _table(rows, (html.escape(of.name), "")) + _table(tendons, ("tendon", "driven by", "stroke"))


def _line(time: NDArray[np.float64], values: NDArray[np.float64]) -> str:
    """A small drawing of a channel over time."""
    step = max(1, len(time) // _POINTS)
    x, y = time[::step], values[::step]
    width = float(np.ptp(x)) or 1.0
    height = float(np.ptp(y)) or 1.0
    points = " ".join(
        f"{160 * (a - x[0]) / width:.1f},{22 - 20 * (b - y.min()) / height:.1f}" for a, b in zip(x, y)
    )
    line = f'<polyline points="{points}" fill="none" stroke="currentColor"/>'
    return f'<svg width="160" height="24" viewBox="0 0 160 24">{line}</svg>'


def recording(of: Recording) -> str:
    """A table of the channels: smallest and largest value, and a drawing of each."""
    rows = [
        (html.escape(name), f"{values.min():.6g}", f"{values.max():.6g}", _line(of.time, values))
        for name, values in of.items()
    ]
    rate = f", {of.rate_hz:.6g} Hz" if of.rate_hz else ""
    source = html.escape(of.metadata.get("source", ""))
    head = f"<p>{of.n_samples} samples{rate}{': ' + source if source else ''}</p>"
    return head + _table(rows, ("channel", "smallest", "largest", ""))
