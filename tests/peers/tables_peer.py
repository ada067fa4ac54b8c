"""Tables of pyarrow, pandas, polars, numpy and scipy, every codec and type: the program imports what they wrote."""

import datetime
import json
import pathlib
import subprocess
import sys

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io

N = 60
STEP = datetime.timedelta(milliseconds=20)
START = datetime.datetime(2024, 5, 6, 12, 0, 0)


def columns(rng):
    """Times [s], a stroke [mm] and a tip [mm], rounded so that halves and decimals hold them."""
    return 0.02 * np.arange(N), np.round(rng.normal(0, 3, N), 2), np.round(rng.normal(80, 5, N), 2)


def stamps():
    return [START + k * STEP for k in range(N)]


def files(folder, rng):
    """Files with their maps, the tolerance of the stroke [mm], and what they hold."""
    t, stroke, x = columns(rng)
    plain = "time_s=t; stroke_1_mm=s; tip_x_mm=x"
    table = pa.table({"t": t, "s": stroke, "x": x})
    for codec in ["none", "snappy", "gzip", "brotli", "lz4", "zstd"]:
        for version in ["1.0", "2.0"]:
            path = folder / f"{codec}_{version[0]}.parquet"
            pq.write_table(table, path, compression=codec, data_page_version=version, row_group_size=17)
            yield path, plain, 0, (t, stroke, x)
    for codec in ["lz4", "uncompressed", "snappy", "gzip", "brotli", "zstd"]:
        path = folder / f"polars_{codec}.parquet"
        pl.DataFrame({"t": t, "s": stroke, "x": x}).write_parquet(path, compression=codec)
        yield path, plain, 0, (t, stroke, x)
    nanoseconds = (t * 1e9).round().astype(np.int64)
    for unit, factor in [("ns", 1), ("us", 1000), ("ms", 1_000_000)]:
        for kind in [pa.timestamp(unit), pa.timestamp(unit, tz="Europe/Berlin"), pa.duration(unit)]:
            path = folder / f"{str(kind).split('[')[0]}_{unit}_{'tz' if 'tz' in str(kind) else ''}.parquet"
            pq.write_table(pa.table({"t": pa.array(nanoseconds // factor, type=kind), "s": stroke, "x": x}), path)
            yield path, plain, 0, (t, stroke, x)
    for kind in ["float32", "float16"]:
        path = folder / f"{kind}.parquet"
        pq.write_table(pa.table({"t": t, "s": stroke.astype(kind), "x": x}), path)
        yield path, plain, 1e-6 if kind == "float32" else 2e-2, (t, stroke, x)
    path = folder / "decimal.parquet"
    decimals = pa.array([f"{value:.2f}" for value in stroke]).cast(pa.decimal128(9, 2))
    pq.write_table(pa.table({"t": t, "s": decimals, "x": x}), path)
    yield path, plain, 0, (t, stroke, x)
    path = folder / "dictionary.parquet"
    pq.write_table(pa.table({"t": t, "s": pa.array(stroke).dictionary_encode(), "x": x}), path)
    yield path, plain, 0, (t, stroke, x)
    frame = pd.DataFrame({"t": stamps(), "s": stroke, "x": x})
    path = folder / "pandas.parquet"
    frame.to_parquet(path)
    yield path, plain, 0, (t, stroke, x)
    for name, options in {
        "semicolon": {"sep": ";", "decimal": ","}, "tab": {"sep": "\t"}, "bar": {"sep": "|"}, "space": {"sep": " ", "date_format": "%Y-%m-%dT%H:%M:%S.%f"},
        "quoted": {"quoting": 1}, "utf16": {"encoding": "utf-16"}, "bom": {"encoding": "utf-8-sig"},
    }.items():
        path = folder / f"{name}.csv"
        frame.to_csv(path, index=False, **options)
        yield path, plain, 0, (t, stroke, x)
    np.savez_compressed(folder / "arrays.npz", t=t, s=stroke.astype(">f8"), x=x)
    yield folder / "arrays.npz", plain, 0, (t, stroke, x)
    scipy.io.savemat(folder / "arrays.mat", {"t": t, "s": stroke, "x": x}, do_compression=True)
    yield folder / "arrays.mat", plain, 0, (t, stroke, x)


def main(program, folder):
    rng = np.random.default_rng(1)
    n = 0
    for path, columns_map, tolerance, (t, stroke, x) in files(pathlib.Path(folder), rng):
        out = path.with_name(path.name + ".out.parquet")
        done = subprocess.run([program, "import", path, "--map", columns_map, "--out", out, "--json"], capture_output=True, text=True)
        assert done.returncode == 0, f"{path.name}: {done.stderr}"
        assert json.loads(done.stdout)["rows"] == N, path.name
        read = pq.read_table(out).to_pydict()
        assert np.abs(np.array(read["time_s"]) - t).max() < 1e-9, path.name
        assert np.abs(1000 * np.array(read["stroke_1_m"]) - stroke).max() <= tolerance + 1e-12, path.name
        assert np.abs(1000 * np.array(read["tip_x_m"]) - x).max() <= 1e-12, path.name
        assert not any(read["gap"]), path.name
        n += 1
    print(f"{n} files of pyarrow, pandas, polars, numpy and scipy")


main(*sys.argv[1:])
