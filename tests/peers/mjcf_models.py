"""MJCF files that Python packages carry, beside MuJoCo's inverse dynamics; by hand, because the packages have 700 MB:

    pip install mujoco==4.0.0 && pip install --no-deps robosuite gymnasium-robotics dm_control metaworld
    cargo build --release -p hysteron-arm-dynamics --example robot_torques
    python tests/peers/mjcf_models.py target/release/hysteron FOLDER... [--csv FILE]

Every file below a folder that MuJoCo loads and that has hinges and slides alone is either equal to MuJoCo (constraint forces switched off) or
refused; the refusals are counted by the feature that they name. A line for each folder, which is a package, and one for all; what is neither equal
nor refused makes it fail. Every file has `SECONDS` in either program.
"""

import argparse
import collections
import csv
import json
import multiprocessing
import pathlib
import re
import subprocess
import sys

import mujoco
import numpy as np

from mjcf_schema_peer import RELATIVE, inverse, states

SECONDS = 20
# MuJoCo ends its search for the principal axes of a mesh of density one at 1e-12 kg m² off the diagonal; bodies have up to 5000 kg/m³.
# At accelerations of the size of one that is a torque [N m].
MESH = 5e-9


def expected(file):
    """The kind of a file, and where it has a fixed base rows of states with MuJoCo's torques, and their error [N m]."""
    try:
        model = mujoco.MjModel.from_xml_path(str(file))
    except Exception:
        return "not loaded by MuJoCo", None, None, None
    if model.nq != model.nv or np.isin(model.jnt_type, [0, 1]).any():
        return "floating or with balls", None, None, None
    if model.nv == 0:
        return "without joints", None, None, None
    rows = states(model, 0)
    torques = inverse(model, rows)
    return "fixed base", rows, torques, RELATIVE * np.abs(torques).max() + (MESH if model.nmesh else 0.0)


def answered(example, file, rows):
    """What the program says of a file: torques, the feature that it refuses, or something that it should not say."""
    line = json.dumps({"file": str(file), "rows": rows}) + "\n"
    try:
        done = subprocess.run([example], input=line.encode(), check=True, stdout=subprocess.PIPE, timeout=SECONDS)
    except (subprocess.TimeoutExpired, subprocess.CalledProcessError) as error:
        return None, str(error)
    answer = json.loads(done.stdout)
    if "error" in answer:
        return None, answer["error"]
    return answer["tau"], f"joints {answer['joints']}"


def feature(error):
    """The element or attribute that an error names, without file, line and numbers."""
    at = re.search(r"line \d+: (\w+)(?:\[[^\]]*\])?: expected ([^:(]*?)(:|,? got)", error)
    if at is None:
        return re.sub(r"\d+", "n", error.split(": expected ", 1)[-1])[:80]
    element, wanted = at[1], re.sub(r"\s+0$", "", at[2].strip())
    return wanted if wanted.startswith("no <") else f"<{element}> {wanted}"


def examined(task):
    example, package, file = task
    kind, rows, torques, tolerance = expected(file)
    if rows is None:
        return package, file, kind, "", None, ""
    tau, said = answered(example, file, rows)
    if tau is None:
        return package, file, kind, "neither" if said.startswith("joints") else "refused", None, said
    if np.shape(tau) != torques.shape:
        return package, file, kind, "neither", None, said
    error = np.abs(np.array(tau) - torques).max()
    return package, file, kind, "equal" if error <= tolerance else "neither", error / max(np.abs(torques).max(), 1e-9), ""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    parser.add_argument("--csv", type=pathlib.Path)
    options = parser.parse_args()
    example = (options.program.parent / "examples" / "robot_torques").resolve()
    tasks = [(example, folder.name, file) for folder in options.folders for file in sorted(folder.rglob("*.xml"))
             if "<mujoco" in file.read_text(errors="replace")]
    table, refusals, other = collections.defaultdict(collections.Counter), collections.defaultdict(collections.Counter), []
    worst, rows = collections.Counter(), []
    with multiprocessing.Pool(2, maxtasksperchild=20) as pool:
        waiting = [(task, pool.apply_async(examined, (task,))) for task in tasks]
        for task, result in waiting:
            try:
                package, file, kind, outcome, error, said = result.get(2 * SECONDS)
            except multiprocessing.TimeoutError:
                package, file, kind, outcome, error, said = task[1], task[2], f"not loaded by MuJoCo in {SECONDS} s", "", None, ""
            table[package].update(["files", kind, *filter(None, [outcome])])
            if outcome == "equal":
                worst[package] = max(worst[package], error)
            elif outcome == "refused":
                refusals[package][feature(said)] += 1
            elif outcome:
                other.append(f"{file}: {said or f'{error:.1e}'}")
            rows.append([package, file.name, kind, outcome, "" if error is None else f"{error:.1e}", feature(said) if said else ""])
    for package, counts in table.items():
        named = "; ".join(f"{count} {name}" for name, count in refusals[package].most_common())
        print(f"| {package} | {counts['files']} | {counts['fixed base']} | {counts['equal']} | {counts['refused']} | {counts['neither']} | "
              f"{worst[package]:.1e} | {named} |")
    whole = sum(table.values(), collections.Counter())
    print(f"MuJoCo {mujoco.__version__}: {dict(whole)}; worst relative difference {max(worst.values(), default=0):.1e}")
    if options.csv:
        with options.csv.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([["package", "file", "kind", "outcome", "relative difference", "refused"], *rows])
    print("\n".join(other))
    sys.exit(bool(other) or whole["equal"] == 0)


if __name__ == "__main__":
    main()
