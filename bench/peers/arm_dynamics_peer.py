"""Rigid-body dynamics beside Pinocchio's C++, on the Panda with its fingers locked: calls per second on one core.

    cargo build --release -p hysteron-arm --example dynamics_rates
    python3 bench/peers/arm_dynamics_peer.py [--example FILE] [--flags FLAGS]

Needs the wheels `pin` and `cmeel-eigen` for headers and libraries, and g++; says "skipped" by name where they are missing. Both
programs take processor time and the best of seven rounds. Compiling takes some minutes.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROBOT = HERE.parent.parent / "arm/robots/panda.urdf"
LOCKED = ["panda_finger_joint1", "panda_finger_joint2"]
# What Pinocchio's own build sets: more than twenty kinds of joints, functions of ten arguments.
BOOST = [
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=10",
    "-DBOOST_FUSION_INVOKE_PROCEDURE_MAX_ARITY=10",
    "-DBOOST_FUSION_INVOKE_FUNCTION_OBJECT_MAX_ARITY=10",
]


def arguments():
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target"))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--example", type=pathlib.Path, default=target / "release/examples/dynamics_rates")
    parser.add_argument("--flags", default="-O3 -march=native -DNDEBUG")
    return parser.parse_args()


def chain(pinocchio):
    """The robot as numbers: the number of joints, then a line for each."""
    whole = pinocchio.buildModelFromUrdf(str(ROBOT))
    locked = [whole.getJointId(name) for name in LOCKED]
    model = pinocchio.buildReducedModel(whole, locked, pinocchio.neutral(whole))
    lines = [str(model.nq)]
    for i in range(1, model.njoints):
        placement, body = model.jointPlacements[i], model.inertias[i]
        numbers = [*placement.rotation.flatten(), *placement.translation, body.mass, *body.lever, *body.inertia.flatten()]
        axis = model.joints[i].shortname()[-1]
        lines.append(" ".join([str(model.parents[i]), axis, *map(repr, map(float, numbers))]))
    return "\n".join(lines)


def theirs(options):
    """Pinocchio's report; None where it cannot be had."""
    try:
        import pinocchio
    except ImportError:
        print("skipped: Pinocchio (pip install pin cmeel-eigen)")
        return None
    prefix = next(p for p in pathlib.Path(pinocchio.__file__).parents if (p / "include/pinocchio").exists())
    if not (prefix / "include/eigen3").exists() or shutil.which("g++") is None:
        print("skipped: Pinocchio's C++ (needs g++ and pip install cmeel-eigen)")
        return None
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder) / "peer"
        include = [f"-I{prefix}/include", f"-I{prefix}/include/eigen3"]
        link = [f"-L{prefix}/lib", "-lpinocchio_default", f"-Wl,-rpath,{prefix}/lib"]
        source = HERE / "arm_dynamics_peer.cpp"
        command = ["g++", "-std=c++17", *options.flags.split(), *BOOST, *include, source, *link, "-o", program]
        subprocess.run(command, check=True)
        done = subprocess.run([program], input=chain(pinocchio), check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)


def main():
    options = arguments()
    done = subprocess.run([options.example, ROBOT, *LOCKED], check=True, stdout=subprocess.PIPE)
    ours = json.loads(done.stdout)
    peer = theirs(options)
    for way, rates in ours.items():
        if not isinstance(rates, dict):
            continue
        for name, rate in rates.items():
            beside = f"{peer[name]:>12.0f} {rate / peer[name]:>6.2f}" if peer and name in peer else ""
            print(f"{way:<15} {name:<22} {rate:>12.0f} {beside}")


if __name__ == "__main__":
    main()
