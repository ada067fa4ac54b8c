"""QPs of an identification, solved by scipy's BVLS (bounded least squares by active sets) beside the program's own answers.

An augmented Lagrangian method was here before. Where strokes are weakly regularised it stops early: ProxQP 0.7.2 says that it
has solved to 1e-11, and leaves objectives up to 3.3e-4 above the minimum.
"""

import json
import pathlib
import subprocess
import sys

import numpy as np
from scipy.optimize import lsq_linear

COUNT = 200
# What the two objectives may differ by, relative to the objective, and the answer be outside its bounds.
RELATIVE = 1e-6


def qps(program, folder):
    data = folder / "data"
    record = [program, "-q", "record", "--rig", "virtual:typical", "--plan", "quick", "--only", "circle"]
    subprocess.run([*record, "--out", data / "circle.parquet", "--figures", folder], check=True, stdout=subprocess.DEVNULL)
    example = pathlib.Path(program).parent / "examples" / "identification_qps"
    scene = "meshes/tpu80/scene-coreact.toml"
    done = subprocess.run([example, scene, data / "circle.parquet", str(COUNT)], check=True, stdout=subprocess.PIPE)
    return [json.loads(line) for line in done.stdout.splitlines()]


def solve(qp):
    """The minimum, the objective of the answer, and how far the answer is outside its bounds."""
    assert not qp["rows"], "BVLS knows bounds alone"
    g = np.array(qp["linear"])
    h = np.array(qp["hessian"]).reshape(len(g), len(g))
    low, high = np.array(qp["bounds"], dtype=float).T
    # H = A'A and g = -A'b make the objective |A x - b|^2 / 2, less a constant.
    a = np.linalg.cholesky(h).T
    b = np.linalg.solve(a.T, -g)
    x = lsq_linear(a, b, (low, high), method="bvls", tol=1e-15, max_iter=5000).x
    answer = np.array(qp["answer"])
    objective = lambda x: 0.5 * x @ h @ x + g @ x
    outside = max(np.max(low - answer), np.max(answer - high), 0.0)
    return objective(x), objective(answer), outside / max(np.abs(answer).max(), 1e-300)


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    sampled = qps(program, folder)
    assert len(sampled) >= COUNT, f"{len(sampled)} QPs"
    worst = outside = 0.0
    for number, qp in enumerate(sampled):
        assert qp["status"] == "Solved", f"QP {number}: {qp['status']}"
        peer, own, beyond = solve(qp)
        worst = max(worst, abs(own - peer) / abs(peer))
        outside = max(outside, beyond)
    print(f"{len(sampled)} QPs: objectives within {worst:.1e} relative, bounds within {outside:.1e}")
    assert worst <= RELATIVE and outside <= RELATIVE


main()
