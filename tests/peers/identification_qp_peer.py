"""QPs of an identification, solved by ProxQP (an augmented Lagrangian method) beside the program's own answers."""

import json
import pathlib
import subprocess
import sys

import numpy as np
import proxsuite

COUNT = 200
# What an answer may be outside the constraints.
RELATIVE = 1e-6
# What the two objectives may differ by. Not yet understood: clarabel and the active set agree, ProxQP ends up to 3.6e-4 above
# them (once 1.3e-4 below) where weakly regularised; 1e-6 is what is wanted.
OBJECTIVE = 1e-3


def qps(program, folder):
    data = folder / "data"
    record = [program, "-q", "record", "--rig", "virtual:typical", "--plan", "quick", "--only", "circle"]
    subprocess.run([*record, "--out", data / "circle.parquet", "--figures", folder], check=True, stdout=subprocess.DEVNULL)
    example = pathlib.Path(program).parent / "examples" / "identification_qps"
    scene = "meshes/tpu80/scene-coreact.toml"
    done = subprocess.run([example, scene, data / "circle.parquet", str(COUNT)], check=True, stdout=subprocess.PIPE)
    return [json.loads(line) for line in done.stdout.splitlines()]


def limits(pairs):
    low = np.array([-1e20 if low is None else low for low, _ in pairs])
    high = np.array([1e20 if high is None else high for _, high in pairs])
    return low, high


def solve(qp):
    """The minimum, and how far the answer is outside the constraints."""
    g = np.array(qp["linear"])
    n = len(g)
    h = np.array(qp["hessian"]).reshape(n, n)
    rows = np.array(qp["rows"]).reshape(-1, n)
    low, high = limits(qp["bounds"])
    row_low, row_high = limits(qp["row_bounds"])
    # Everything of order one, as the solver likes it.
    scale = np.abs(g).max()
    c = np.vstack([rows, np.eye(n)])
    l = np.concatenate([row_low, low]) / scale
    u = np.concatenate([row_high, high]) / scale
    problem = proxsuite.proxqp.dense.QP(n, 0, len(c))
    problem.settings.eps_abs = 1e-11
    problem.settings.eps_rel = 0.0
    problem.settings.max_iter = 20000
    problem.init(h, g / scale, None, None, c, l, u)
    problem.solve()
    x = problem.results.x * scale
    answer = np.array(qp["answer"])
    objective = lambda x: 0.5 * x @ h @ x + g @ x
    outside = max(np.max(low - answer), np.max(answer - high), np.max(np.append(np.abs(rows @ answer - row_low), 0)))
    return objective(x), objective(answer), max(outside, 0.0) / max(np.abs(answer).max(), 1e-300)


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
    print(f"{len(sampled)} QPs: objectives within {worst:.1e} relative, constraints within {outside:.1e}")
    assert worst <= OBJECTIVE and outside <= RELATIVE


main()
