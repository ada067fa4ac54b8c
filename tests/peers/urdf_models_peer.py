#!/usr/bin/env python3
"""Torques of all robots of example-robot-data beside Pinocchio's.

    urdf_models_peer.py PROGRAM FOLDER [ROBOTS]

Every URDF that the package's loaders name is either refused by the program with one clear error, or gives the torques of
Pinocchio's recursive Newton-Euler algorithm at three states. The packages (420 MB) are not those of the other peers: where they are
absent this says so and ends well. ROBOTS names the folder of the robots; without it the package is looked for.
"""

import csv
import inspect
import math
import pathlib
import random
import subprocess
import sys

TOLERANCE = 1e-10  # of the largest torque of a robot: both sum some hundred terms in double precision
MUST_AGREE = 64
N_STATES = 3


def files(robots):
    """The URDF of every loader, once for each name."""
    from example_robot_data import robots_loader

    named = {}
    for name, loader in robots_loader.ROBOTS.items():
        kind = loader if inspect.isclass(loader) else None
        urdf = getattr(kind, "urdf_filename", "")
        sub = getattr(kind, "urdf_subpath", "robots")
        named[name] = robots / kind.path / sub / urdf if kind and urdf else None
    return named


def held(pin, path):
    """Pinocchio's model; joints of several degrees of freedom stay at their neutral place."""
    model = pin.buildModelFromUrdf(str(path))
    free = [j for j in range(1, model.njoints) if model.joints[j].nv > 1]
    return pin.buildReducedModel(model, free, pin.neutral(model)) if free else model


def states(model, pin, name):
    draw = random.Random(name)
    rows = []
    for _ in range(N_STATES):
        row = {}
        for j in range(1, model.njoints):
            row[model.names[j]] = [draw.uniform(-1, 1) for _ in range(3)]
        rows.append(row)
    return rows


def torques(pin, model, rows):
    import numpy

    data, result = model.createData(), []
    for row in rows:
        q, v, a = pin.neutral(model), numpy.zeros(model.nv), numpy.zeros(model.nv)
        for j in range(1, model.njoints):
            angle, v[model.joints[j].idx_v], a[model.joints[j].idx_v] = row[model.names[j]]
            at = model.joints[j].idx_q
            if model.joints[j].nq == 2:  # continuous: cosine and sine
                q[at], q[at + 1] = math.cos(angle), math.sin(angle)
            else:
                q[at] = angle
        tau = pin.rnea(model, data, q, v, a)
        result.append({model.names[j]: tau[model.joints[j].idx_v] for j in range(1, model.njoints)})
    return result


def run(program, *arguments):
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)


def joints(program, path, folder):
    """Names and kinds of the joints in the program's order, by the tables that it exports."""
    import xml.etree.ElementTree as tree

    tables = [folder / "joints.csv", folder / "joints.xml"]
    for table in tables:
        done = run(program, "arm", "export", path, "--fix-base", "--out", table, "--overwrite")
        if done.returncode:
            return None, done.stderr.strip().splitlines()[-1]
    kinds = {j.get("name"): j.get("type") for j in tree.parse(tables[1]).getroot().iter("joint")}
    with open(tables[0]) as file:
        names = [row["joint"] for row in csv.DictReader(line for line in file if not line.startswith("#"))]
    return [(name, kinds[name]) for name in names], ""


def compare(pin, program, folder, name, path):
    found, refusal = joints(program, path, folder)
    if found is None:
        return "refused", refusal
    model = held(pin, path)
    if sorted(own for own, _ in found) != sorted(model.names[1:]):
        return "differs", f"other joints: {len(found)} for {model.njoints - 1}"
    rows = states(model, pin, name)
    source, out = folder / "states.csv", folder / "torques.csv"
    units = {"hinge": ["rad", "rad_s", "rad_s2", "n_m"], "slide": ["m", "m_s", "m_s2", "n"]}
    with open(source, "w", newline="") as file:
        writer = csv.writer(file)
        stems = ["q", "dq", "ddq"]
        head = [f"{s}_{k + 1}_{units[kind][i]}" for i, s in enumerate(stems) for k, (_, kind) in enumerate(found)]
        writer.writerow(["time_s", *head])
        for k, row in enumerate(rows):
            writer.writerow([k, *(repr(row[own][i]) for i in range(3) for own, _ in found)])
    done = run(program, "arm", "dynamics", path, "--fix-base", "--states", source, "--out", out, "--overwrite")
    if done.returncode:
        return "refused", done.stderr.strip().splitlines()[-1]
    with open(out) as file:
        table = list(csv.DictReader(line for line in file if not line.startswith("#")))
    worst, largest = 0.0, 0.0
    for expected, row in zip(torques(pin, model, rows), table):
        for k, (own, kind) in enumerate(found):
            # The damping of the joints is in the torques of the drives, and not in Pinocchio's.
            tau = float(row[f"tau_{k + 1}_{units[kind][3]}"]) - float(row[f"damping_{k + 1}_{units[kind][3]}"])
            worst, largest = max(worst, abs(tau - expected[own])), max(largest, abs(expected[own]))
    error = worst / max(largest, 1e-300)
    return ("equal" if error <= TOLERANCE else "differs"), f"{len(found)} joints, {error:.1e}"


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    try:
        import pinocchio as pin
        import example_robot_data
    except ImportError as missing:
        print(f"skipped: urdf_models_peer: pip install pin example-robot-data example-robot-data-loaders ({missing})")
        return
    robots = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else pathlib.Path(example_robot_data.getModelPath("")) / "robots"
    if not robots.is_dir():
        base = pathlib.Path(pin.__file__).parents[4]
        robots = next(base.glob("share/example-robot-data/robots"))
    outcomes = {}
    for name, path in sorted(files(robots).items()):
        if path is None:
            outcome, said = "refused", "no URDF but SDF"
        else:
            outcome, said = compare(pin, program, folder, name, path)
        outcomes.setdefault(outcome, []).append(name)
        print(f"{name:32} {outcome:8} {said}")
    counts = {outcome: len(names) for outcome, names in outcomes.items()}
    n = sum(counts.values())
    print(f"{counts.get('equal', 0)} of {n} equal to Pinocchio within {TOLERANCE:.0e}, {counts.get('refused', 0)} refused by name")
    assert not outcomes.get("differs"), outcomes["differs"]
    assert counts.get("equal", 0) >= MUST_AGREE, counts


if __name__ == "__main__":
    main()
