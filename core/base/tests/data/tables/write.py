"""Writes the tables of this folder, except those that a person made: python3 write.py FOLDER (pyarrow 26.0.1, polars 2.1.0, scipy 1.17.1)."""

import datetime
import sys
from decimal import Decimal as D

import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io

out, n = sys.argv[1], 5
t = [0, 50_000_000, 100_000_000, 150_000_000, 200_000_000]
base = 1_700_000_000_000_000_000


def of(kind, values):
    return pa.array(values, type=kind)


wide = [D("1.5"), D("-2.25"), D("0.000001"), D("3"), D("4")]
table = pa.table({
    "stamp_ns": of(pa.timestamp("ns", tz="UTC"), [base + x for x in t]),
    "stamp_us": of(pa.timestamp("us"), [(base + x) // 1000 for x in t]),
    "stamp_ms": of(pa.timestamp("ms"), [(base + x) // 10**6 for x in t]),
    "stamp_s": of(pa.timestamp("s"), [base // 10**9 + k for k in range(n)]),
    "span_ns": of(pa.duration("ns"), t),
    "span_us": of(pa.duration("us"), [x // 1000 for x in t]),
    "span_ms": of(pa.duration("ms"), [x // 10**6 for x in t]),
    "span_s": of(pa.duration("s"), list(range(n))),
    "clock_ns": of(pa.time64("ns"), t),
    "clock_us": of(pa.time64("us"), [x // 1000 for x in t]),
    "clock_ms": of(pa.time32("ms"), [x // 10**6 for x in t]),
    "day": of(pa.date32(), [datetime.date(2023, 11, 14) + datetime.timedelta(k) for k in range(n)]),
    **{f"i{8 * w}": of(getattr(pa, f"int{8 * w}")(), [-2, -1, 0, 1, 2]) for w in [1, 2, 4, 8]},
    **{f"u{8 * w}": of(getattr(pa, f"uint{8 * w}")(), [2 ** (8 * w) - 1 if w < 8 else 2**63, 1, 2, 3, 4]) for w in [1, 2, 4, 8]},
    "f16": pa.array(np.array([1.5, -2, 0.25, 65504, 0], dtype=np.float16)),
    "f32": of(pa.float32(), [1.5, -2, 0.25, 3, 4]),
    "f64": of(pa.float64(), [1.5, -2, 0.25, None, 4]),
    "flag": of(pa.bool_(), [True, False, True, True, False]),
    "dec": of(pa.decimal128(9, 3), [D("1.500"), D("-2.250"), D("0.001"), D("3"), D("4")]),
    "dec_wide": of(pa.decimal128(30, 6), wide),
    "dec_256": of(pa.decimal256(50, 6), wide),
    "word": of(pa.string(), ["a", "b", "a", None, "c"]),
    "large_word": of(pa.large_string(), ["a", "b", "a", "b", "c"]),
    "dict_word": pa.array(["a", "b", "a", "b", "c"]).dictionary_encode(),
    "dict_number": pa.array([1.5, 2.5, 1.5, 2.5, 1.5]).dictionary_encode(),
    "text_stamp": of(pa.string(), [f"2023-11-14T22:13:2{k}.5Z" for k in range(n)]),
    "pair": of(pa.list_(pa.float32()), [[1, 2], [3, 4], None, [5, 6], [7, None]]),
    "fixed": of(pa.list_(pa.float64(), 3), [[1, 2, 3]] * 5),
    "large_list": of(pa.large_list(pa.int16()), [[1, 2]] * 5),
    "ragged": of(pa.list_(pa.float64()), [[1], [1, 2], [3], [4], [5]]),
    "pose": pa.array([{"x": float(k), "y": None} for k in range(n)], type=pa.struct([("x", pa.float64()), ("y", pa.float64())])),
    "raw": of(pa.binary(), [b"a"] * 5),
})
pq.write_table(table, f"{out}/types.parquet", compression="zstd")
pq.write_table(table.select(["stamp_ns", "i32", "f64"]), f"{out}/int96.parquet", use_deprecated_int96_timestamps=True)
whole = pa.table({"dec4": of(pa.decimal128(5, 2), [D("1.50"), D("-2.25")]), "dec8": of(pa.decimal128(15, 4), [D("1.5"), D("-2.25")])})
pq.write_table(whole, f"{out}/decimal_as_integer.parquet", store_decimal_as_integer=True)
pq.write_table(pa.table({"time_s": [0.0, 0.1], "stroke_1_mm": of(pa.duration("ms"), [1, 2])}), f"{out}/span_as_length.parquet")
small = pa.table({"time_s": [0.05 * k for k in range(41)], "stroke_1_mm": [0.1 * k for k in range(41)]})
for codec in ["none", "snappy", "gzip", "brotli", "lz4", "zstd"]:
    pq.write_table(small, f"{out}/{codec}.parquet", compression=codec)
encoding = {"time_s": "BYTE_STREAM_SPLIT", "stroke_1_mm": "PLAIN"}
pq.write_table(small, f"{out}/v2_pages.parquet", compression="brotli", data_page_version="2.0", use_dictionary=False, column_encoding=encoding)
pl.DataFrame({
    "time_s": pl.Series([datetime.timedelta(milliseconds=50 * k) for k in range(n)]),
    "when": pl.Series([datetime.datetime(2023, 11, 14, 22, 13, 20, 50000 * k) for k in range(n)]),
    "stroke_1_mm": [0.1 * k for k in range(n)],
    "cat": pl.Series(["a", "b", "a", "b", "a"], dtype=pl.Categorical),
}).write_parquet(f"{out}/polars.parquet")
seconds = np.arange(n) * 0.05
arrays = {
    "t": seconds.reshape(-1, 1), "stroke": np.arange(10.0).reshape(5, 2) / 7, "f32": np.array([1.5, -2, 0.25, 3, 4], dtype=np.float32),
    "i16": np.array([[-2, -1, 0, 1, 2]], dtype=np.int16), "u64": np.array([2**63, 1, 2, 3, 4], dtype=np.uint64),
    "flag": np.array([True, False, True, True, False]), "fs": 20.0, "label": "abc", "cell": np.array(["a", 1], dtype=object),
    "log": {"x": np.arange(5.0) + 1, "deep": {"y": np.arange(5)}}, "cube": np.zeros((5, 2, 2)), "z": np.array([1 + 2j] * 5),
}
scipy.io.savemat(f"{out}/v5.mat", arrays, do_compression=False)
scipy.io.savemat(f"{out}/v5_compressed.mat", arrays, do_compression=True)
scipy.io.savemat(f"{out}/v4.mat", {"t": arrays["t"]}, format="4")
records = np.zeros(n, dtype=[("t", "<f8"), ("n", ">i2"), ("f", "<f2"), ("flag", "?")])
records["t"], records["n"], records["f"], records["flag"] = seconds, [-2, -1, 0, 1, 2], [1.5, -2, 0.25, 65504, 0], [1, 0, 1, 1, 0]
np.save(f"{out}/structured.npy", records)
half = np.array([1.5, -2, 0.25, 65504, 0], dtype=">f2")
np.savez_compressed(f"{out}/arrays.npz", t=seconds, half=half, stroke=np.asfortranarray(arrays["stroke"]), other=np.zeros(3), name="a")
