"""MJCF files that Python packages carry, beside MuJoCo's inverse dynamics; by hand, because the packages have 700 MB:

    pip install mujoco==4.0.0 && pip install --no-deps robosuite gymnasium-robotics dm_control metaworld
    python tests/peers/mjcf_models.py target/release/hysteron FOLDER...

Every file below the folders that MuJoCo loads and that has hinges and slides alone is either equal to MuJoCo (constraint forces switched off) or
refused; the refusals are counted by their reason.
"""

import collections
import json
import pathlib
import re
import subprocess
import sys

import mujoco
import numpy as np

from mjcf_schema import RELATIVE, inverse, states


def main():
    program, folders = pathlib.Path(sys.argv[1]), sys.argv[2:]
    example = program.parent / "examples" / "robot_torques"
    kinds, cases = collections.Counter(), []
    for folder in folders:
        for file in sorted(pathlib.Path(folder).rglob("*.xml")):
            if "<mujoco" not in file.read_text(errors="replace"):
                continue
            try:
                model = mujoco.MjModel.from_xml_path(str(file))
            except Exception:
                kinds["not loaded by MuJoCo"] += 1
                continue
            if model.nq != model.nv or np.isin(model.jnt_type, [0, 1]).any():
                kinds["floating or with balls"] += 1
                continue
            if model.nv == 0:
                kinds["without joints"] += 1
                continue
            kinds["fixed base"] += 1
            rows = states(model, 0)
            cases.append((file, rows, inverse(model, rows)))
    lines = "".join(json.dumps({"file": str(file), "rows": rows}) + "\n" for file, rows, _ in cases)
    done = subprocess.run([example], input=lines.encode(), check=True, stdout=subprocess.PIPE)
    equal, worst, refused, other = 0, 0.0, collections.Counter(), []
    for (file, _, expected), line in zip(cases, done.stdout.splitlines(), strict=True):
        answer = json.loads(line)
        if "error" in answer:
            refused[re.sub(r"\[.*?\]|\d+", "", answer["error"].split("line", 1)[-1])[:140]] += 1
        elif answer["tau"] is None or np.shape(answer["tau"]) != expected.shape:
            other.append(f"{file}: joints {answer['joints']}")
        else:
            error = np.abs(np.array(answer["tau"]) - expected).max() / max(np.abs(expected).max(), 1e-9)
            worst, equal = max(worst, error if error <= RELATIVE else 0.0), equal + (error <= RELATIVE)
            if error > RELATIVE:
                other.append(f"{file}: {error:.1e}")
    print(f"MuJoCo {mujoco.__version__}: {dict(kinds)}; of {len(cases)} with fixed base {equal} equal (worst {worst:.1e}), "
          f"{sum(refused.values())} refused, {len(other)} neither")
    for reason, count in refused.most_common():
        print(f"{count:5} {reason}")
    print("\n".join(other))
    sys.exit(bool(other))


if __name__ == "__main__":
    main()
