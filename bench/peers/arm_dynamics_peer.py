"""Rigid-body dynamics beside Pinocchio's C++ and MuJoCo's C, on the Panda with its fingers locked: calls per second on one core.

    cargo build --release -p hysteron-arm-dynamics --example dynamics_rates
    python3 bench/peers/arm_dynamics_peer.py [--example FILE] [--flags FLAGS]

Needs g++, and for headers and libraries the wheels `pin` and `cmeel-eigen`, and `mujoco`; says "skipped" by name what is missing. All
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
ROBOT = HERE.parent.parent / "arm/dynamics/robots/panda.urdf"
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


def built(options, source, flags, arguments, text):
    """What a C++ program of this folder reports, compiled with `flags`."""
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder) / "peer"
        subprocess.run(["g++", "-std=c++17", "-w", *options.flags.split(), HERE / source, *flags, "-o", program], check=True)
        done = subprocess.run([program, *arguments], input=text, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)


def pinocchio_rates(options):
    """Pinocchio's report; None where it cannot be had."""
    try:
        import pinocchio
    except ImportError:
        print("skipped: Pinocchio (pip install pin cmeel-eigen)")
        return None
    prefix = next(p for p in pathlib.Path(pinocchio.__file__).parents if (p / "include/pinocchio").exists())
    if not (prefix / "include/eigen3").exists():
        print("skipped: Pinocchio's C++ (pip install cmeel-eigen)")
        return None
    include = [f"-I{prefix}/include", f"-I{prefix}/include/eigen3"]
    link = [f"-L{prefix}/lib", "-lpinocchio_default", f"-Wl,-rpath,{prefix}/lib"]
    return built(options, "arm_dynamics_peer.cpp", [*BOOST, *include, *link], [], chain(pinocchio))


def mujoco_rates(options):
    """MuJoCo's report; None where it cannot be had."""
    try:
        import mujoco
    except ImportError:
        print("skipped: MuJoCo (pip install mujoco)")
        return None
    wheel = pathlib.Path(mujoco.__file__).parent
    library = next(wheel.glob("libmujoco.so*"))
    spec = mujoco.MjSpec.from_file(str(ROBOT))
    for part in [*spec.equalities, *(joint for joint in spec.joints if joint.name in LOCKED)]:
        spec.delete(part)
    spec.compile()
    with tempfile.TemporaryDirectory() as folder:
        model = pathlib.Path(folder) / "panda.xml"
        model.write_text(spec.to_xml())
        flags = [f"-I{wheel}/include", str(library), f"-Wl,-rpath,{wheel}"]
        return built(options, "arm_dynamics_mujoco.cpp", flags, [model], None)


def main():
    options = arguments()
    done = subprocess.run([options.example, ROBOT, *LOCKED], check=True, stdout=subprocess.PIPE)
    ours = json.loads(done.stdout)
    if shutil.which("g++") is None:
        print("skipped: Pinocchio and MuJoCo (they need g++)")
        peers = {}
    else:
        peers = {"Pinocchio": pinocchio_rates(options), "MuJoCo": mujoco_rates(options)}
    for way, rates in ours.items():
        if not isinstance(rates, dict):
            continue
        for name, rate in rates.items():
            beside = [
                f"{program} {peer[name]:>9.0f} ({rate / peer[name]:.2f} times)"
                for program, peer in peers.items()
                if peer and name in peer
            ]
            shown = f"{rate:.2f}" if way.startswith("speed_up") else f"{rate:.0f}"
            print(f"{way:<15} {name:<22} {shown:>10}   {'   '.join(beside)}")


if __name__ == "__main__":
    main()
