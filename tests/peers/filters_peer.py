"""Filters of random signals: Butterworth by order and by specification, medians, Savitzky-Golay, beside scipy's."""

import json
import pathlib
import subprocess
import sys

import numpy as np
from scipy.signal import butter, buttord, medfilt, savgol_filter, sosfilt, sosfiltfilt

COUNT = 200
# Sections of a Butterworth filter of order n at a part c of the rate amplify rounding by some (1/c)^2 where poles are near one.
ROUNDING = 1e-9


def signal(rng):
    n = rng.integers(60, 800)
    slow = np.cumsum(rng.normal(size=n)) / 10
    return slow + rng.normal(0, 0.3, n)


def ask(rng):
    """What the program is asked, and a function of its answer that gives pairs of arrays which must agree."""
    x, rate = signal(rng), float(rng.uniform(50, 2000))
    kind = rng.integers(0, 4)
    if kind == 0:
        order, cutoff = int(rng.integers(1, 9)), float(rate * rng.uniform(0.02, 0.45))
        sos = butter(order, cutoff, fs=rate, output="sos")
        asked = {"filter": "butterworth", "order": order, "cutoff": cutoff, "rate": rate}
        return x, asked, {"causal": sosfilt(sos, x), "zero_phase": sosfiltfilt(sos, x)}
    if kind == 1:
        low = float(rate * rng.uniform(0.03, 0.2))
        asked = {"filter": "specification", "pass": low, "stop": float(min(low * rng.uniform(1.5, 3), 0.48 * rate)), "rate": rate,
                 "pass_db": -float(rng.uniform(0.1, 3)), "stop_db": -float(rng.uniform(10, 50))}
        order, cutoff = buttord(asked["pass"], asked["stop"], -asked["pass_db"], -asked["stop_db"], fs=rate)
        return x, asked, {"causal": sosfilt(butter(order, cutoff, fs=rate, output="sos"), x)}
    if kind == 2:
        half = int(rng.integers(1, 8))
        inner = slice(half, len(x) - half)
        # scipy pads with zeros; the program takes the neighbours there are: the inside is compared.
        return x, {"filter": "median", "half": half}, {"centred": (inner, medfilt(x, 2 * half + 1)), "causal": (slice(2 * half, None), np.concatenate([np.zeros(half), medfilt(x, 2 * half + 1)])[: len(x)])}
    half = int(rng.integers(2, 15))
    degree = int(rng.integers(1, min(2 * half, 6)))
    derivative = int(rng.integers(0, min(degree, 2) + 1))
    asked = {"filter": "savitzky-golay", "half": half, "degree": degree, "derivative": derivative, "rate": rate}
    return x, asked, {"centred": savgol_filter(x, 2 * half + 1, degree, deriv=derivative, delta=1 / rate)}


def main():
    program = pathlib.Path(sys.argv[1])
    rng = np.random.default_rng(1)
    asked = [ask(rng) for _ in range(COUNT)]
    lines = "".join(json.dumps({**options, "signal": x.tolist()}) + "\n" for x, options, _ in asked)
    example = program.parent / "examples" / "filters"
    done = subprocess.run([example], input=lines.encode(), check=True, stdout=subprocess.PIPE)
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(answers) == COUNT
    worst = {}
    for (_, options, expected), answer in zip(asked, answers):
        assert set(expected) == set(answer), (expected.keys(), answer.keys())
        for name, peer in expected.items():
            part, peer = peer if isinstance(peer, tuple) else (slice(None), peer)
            found, peer = np.array(answer[name])[part], peer[part]
            error = np.max(np.abs(found - peer)) / np.max(np.abs(peer))
            key = f"{options['filter']}, {name}"
            worst[key] = max(worst.get(key, 0.0), error)
            assert error <= ROUNDING, (key, error, {k: v for k, v in options.items()})
    for key, error in sorted(worst.items()):
        print(f"  {key}: largest relative difference {error:.1e}")


if __name__ == "__main__":
    main()
