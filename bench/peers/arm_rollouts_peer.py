"""Rollouts and their gradients beside MJX on the same processor, on OpenManipulator-X with its gripper locked: data steps per second.

    cargo build --release -p hysteron-arm-dynamics --example dynamics_rates
    python3 bench/peers/arm_rollouts_peer.py [--example FILE]

256 trajectories of 25 steps of 10 ms, each in four parts, semi-implicit Euler; the gradient is that of the sum of all states by all
torques. Needs the wheels `jax` and `mujoco-mjx`; says "skipped" by name where they are missing. Both run on one core, the best of seven
rounds after the first, which compiles.
"""

import argparse
import json
import os
import pathlib
import subprocess
import time

HERE = pathlib.Path(__file__).resolve().parent
ROBOT = HERE.parent.parent / "arm/dynamics/robots/open_manipulator_x.urdf"
LOCKED = ["gripper_left_joint", "gripper_right_joint"]
TRAJECTORIES, STEPS, PARTS, PERIOD = 256, 25, 4, 0.01


def arguments():
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target"))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--example", type=pathlib.Path, default=target / "release/examples/dynamics_rates")
    return parser.parse_args()


def arm(mujoco, period):
    """The arm alone, with its gripper locked, as a specification with steps of `period` [s]: no contacts, semi-implicit Euler."""
    spec = mujoco.MjSpec.from_file(str(ROBOT))
    for part in [*spec.equalities, *spec.geoms, *(joint for joint in spec.joints if joint.name in LOCKED)]:
        spec.delete(part)
    spec.option.timestep = period
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return spec


def theirs():
    """MJX's data steps per second, without and with gradient; None where it cannot be had."""
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    try:
        import jax
        import jax.numpy as jnp
        import mujoco
        from mujoco import mjx
    except ImportError:
        print("skipped: MJX (pip install jax mujoco-mjx)")
        return None
    jax.config.update("jax_enable_x64", True)
    model = mjx.put_model(arm(mujoco, PERIOD / PARTS).compile())
    start = mjx.make_data(model)

    def rollout(initial, torques):
        def step(data, torque):
            def part(data, _):
                return mjx.step(model, data.replace(qfrc_applied=torque)), None

            data, _ = jax.lax.scan(part, data, None, length=PARTS)
            return data, jnp.concatenate([data.qpos, data.qvel])

        n = model.nq
        _, states = jax.lax.scan(step, start.replace(qpos=initial[:n], qvel=initial[n:]), torques)
        return states

    many = jax.vmap(rollout)
    key = jax.random.PRNGKey(1)
    initial = jax.random.uniform(key, (TRAJECTORIES, 2 * model.nq), minval=-1.0)
    torques = jax.random.uniform(key, (TRAJECTORIES, STEPS, model.nv), minval=-1.0)
    forwards = jax.jit(many)
    gradient = jax.jit(jax.grad(lambda initial, torques: many(initial, torques).sum(), argnums=(0, 1)))

    def rate(run):
        jax.block_until_ready(run(initial, torques))
        best = 0.0
        for _ in range(7):
            begin = time.process_time()
            jax.block_until_ready(run(initial, torques))
            best = max(best, TRAJECTORIES * STEPS / (time.process_time() - begin))
        return best

    return {"rollout": rate(forwards), "rollout_and_adjoint": rate(gradient)}


def main():
    options = arguments()
    os.sched_setaffinity(0, {0})
    done = subprocess.run([options.example, ROBOT, *LOCKED], check=True, stdout=subprocess.PIPE)
    ours = json.loads(done.stdout)
    peer = theirs()
    for way, rates in ours.items():
        if not way.endswith("_rollouts"):
            continue
        for name, rate in rates.items():
            beside = f"   MJX {peer[name]:>9.0f} ({rate / peer[name]:.1f} times)" if peer else ""
            print(f"{way:<24} {name:<20} {rate:>10.0f}{beside}")


if __name__ == "__main__":
    main()
