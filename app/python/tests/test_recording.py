"""Recordings: memory, files, other packages."""

from __future__ import annotations

import gc
import resource
import sys

import numpy as np
import pyhysteron as ph
import pytest


def small() -> ph.Recording:
    channels = {"stroke_1_m": [0.0, 1e-3, 2e-3], "load_1": np.arange(3)}
    return ph.Recording.from_arrays(channels, rate_hz=50.0, metadata={"source": "a test", "seed": "7", "lab": "a"})


def test_a_recording_is_a_mapping_of_channels():
    recording = small()
    assert list(recording) == recording.keys() == ["stroke_1_m", "load_1"]
    assert len(recording) == 2 and "load_1" in recording and "none" not in recording and 3 not in recording
    np.testing.assert_array_equal(recording["load_1"], [0.0, 1.0, 2.0])
    np.testing.assert_allclose(recording.time, [0.0, 0.02, 0.04])
    assert dict(recording).keys() == {"stroke_1_m", "load_1"}
    assert recording.get("none") is None and recording.get("none", 1) == 1
    with pytest.raises(KeyError, match="none"):
        recording["none"]
    assert recording.metadata == {"source": "a test", "seed": "7", "lab": "a"}
    assert not recording.gap.any() and recording.n_samples == 3
    assert "load_1" in recording._repr_html_()


def test_arrays_show_the_memory_of_the_recording_and_keep_it_alive():
    recording = small()
    channel = recording["stroke_1_m"]
    assert np.shares_memory(channel, recording["stroke_1_m"]) and channel.base is recording
    with pytest.raises(ValueError, match="read-only"):
        channel[0] = 1.0
    with pytest.raises(ValueError):
        channel.setflags(write=True)
    with pytest.raises(ValueError):
        recording.time.setflags(write=True)
    del recording
    gc.collect()
    np.testing.assert_array_equal(channel, [0.0, 1e-3, 2e-3])


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ru_maxrss has another unit")
def test_a_million_rows_are_not_copied():
    n = 1_000_000
    channels = {f"stroke_{k}_m": np.full(n, float(k)) for k in range(1, 6)}
    recording = ph.Recording.from_arrays(channels, rate_hz=1000.0)
    del channels
    gc.collect()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    views = [recording[name] for name in recording for _ in range(20)]
    views += [recording.time for _ in range(20)]
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    # A copy of one channel would be 7800 kB.
    assert sum(view.nbytes for view in views) == 120 * 8 * n and grown < 1000, grown


@pytest.mark.parametrize("ending", ["parquet", "csv"])
def test_files_give_back_the_same_doubles(tmp_path, ending):
    recording = small()
    recording.write(tmp_path / f"a.{ending}")
    assert ph.Recording.read(tmp_path / f"a.{ending}") == recording


def test_bad_recordings_are_refused(tmp_path):
    with pytest.raises(ph.BadInput, match="row 2: load_1: expected a finite number, got NaN"):
        ph.Recording.from_arrays({"load_1": [0.0, float("nan")]}, rate_hz=1.0)
    with pytest.raises(ph.BadInput, match="rate_hz: expected a channel time_s, or a rate, got neither"):
        ph.Recording.from_arrays({"load_1": [0.0]})
    with pytest.raises(ph.BadInput) as caught:
        ph.Recording.read(tmp_path / "none.parquet")
    assert caught.value.hint.startswith("check the path") and isinstance(caught.value, ValueError)
    with pytest.raises(ph.BadInput):
        small().write(tmp_path / "a.txt")


def test_other_packages_take_a_recording():
    recording = small()
    pandas, polars, xarray = (pytest.importorskip(name) for name in ("pandas", "polars", "xarray"))
    frame = recording.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and list(frame.columns) == list(recording)
    assert frame.index.name == "time_s" and frame.attrs["lab"] == "a"
    table = recording.to_polars()
    assert isinstance(table, polars.DataFrame) and table.columns == ["time_s", *recording]
    data = recording.to_xarray()
    assert isinstance(data, xarray.Dataset) and data["stroke_1_m"].attrs["units"] == "m"
    for name in recording:
        np.testing.assert_array_equal(frame[name], recording[name])
        np.testing.assert_array_equal(table[name].to_numpy(), recording[name])
        np.testing.assert_array_equal(data[name], recording[name])
