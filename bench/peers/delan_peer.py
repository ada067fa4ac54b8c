"""A structured Lagrangian (DeLaN) of seven joints and 2 x 128 units beside the same model in JAX: a step of training on 512
samples (loss, gradient, Adam), and the torque of one sample.

    cargo build --release -p hysteron-arm-learning --examples
    python3 bench/peers/delan_peer.py [--rounds N] [--cores N] [--example FILE]

Both in single precision and on the same work: batches of 512 drawn from 10 240 samples, the mean of the 20 steps that go through them once,
the best of several rounds; on one core in processor time, on more by the clock. JAX differentiates the Lagrangian itself, as the
published code does, compiled. Says "skipped" where jax is missing.
"""

import argparse
import json
import os
import pathlib
import subprocess
import time

ONE_CORE = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
JOINTS, BATCH, STEPS, UNITS, EPSILON = 7, 512, 20, 128, 1e-4


def arguments():
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target"))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--cores", type=int, default=1)
    parser.add_argument("--example", type=pathlib.Path, default=target / "release/examples/lagrangian_rates")
    return parser.parse_args()


def best(call, rounds, clock):
    """Shortest time of a call by `clock` [s]; one call to compile goes first."""
    call()
    times = []
    for _ in range(rounds):
        start = clock()
        call()
        times.append(clock() - start)
    return min(times)


def theirs(jax, activation, rounds, clock):
    jnp = jax.numpy
    f = {"relu": jax.nn.relu, "softplus": jax.nn.softplus}[activation]
    keys = iter(jax.random.split(jax.random.PRNGKey(1), 16))
    n_lower = JOINTS * (JOINTS + 1) // 2
    rows, columns = jnp.tril_indices(JOINTS)

    def network(outputs):
        widths = [2 * JOINTS, UNITS, UNITS, outputs]
        return [(jax.random.normal(next(keys), (a, b)) / a**0.5, jnp.zeros(b)) for a, b in zip(widths, widths[1:])]

    def apply(layers, x):
        for w, b in layers[:-1]:
            x = f(x @ w + b)
        w, b = layers[-1]
        return x @ w + b

    def lagrangian(parameters, q, dq):
        x = jnp.concatenate([jnp.sin(q), jnp.cos(q)])
        raw = jnp.zeros((JOINTS, JOINTS)).at[rows, columns].set(apply(parameters["mass"], x))
        lower = raw - jnp.diag(jnp.diag(raw)) + jnp.diag(jax.nn.softplus(jnp.diag(raw) + 0.5413))
        momentum = lower.T @ dq
        return 0.5 * momentum @ momentum + 0.5 * EPSILON * dq @ dq - apply(parameters["potential"], x)[0]

    def torque(parameters, q, dq, ddq):
        by_dq = lambda q, dq: jax.grad(lagrangian, 2)(parameters, q, dq)
        _, rate = jax.jvp(by_dq, (q, dq), (dq, ddq))
        return rate - jax.grad(lagrangian, 1)(parameters, q, dq)

    def loss(parameters, q, dq, ddq, tau):
        found = jax.vmap(torque, (None, 0, 0, 0))(parameters, q, dq, ddq)
        return jnp.mean(jnp.sum((found - tau) ** 2, axis=1))

    def step(parameters, means, squares, count, rows, data):
        gradient = jax.grad(loss)(parameters, *[values[rows] for values in data])
        means = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * g, means, gradient)
        squares = jax.tree.map(lambda s, g: 0.999 * s + 0.001 * g * g, squares, gradient)
        rate = 1e-4 * jnp.sqrt(1 - 0.999**count) / (1 - 0.9**count)
        parameters = jax.tree.map(lambda p, m, s: p - rate * m / (jnp.sqrt(s) + 1e-8), parameters, means, squares)
        return parameters, means, squares, count + 1

    parameters = {"mass": network(n_lower), "potential": network(1)}
    zeros = jax.tree.map(jnp.zeros_like, parameters)
    data = [jax.random.normal(next(keys), (BATCH * STEPS, JOINTS)) for _ in range(4)]
    compiled, single = jax.jit(step), jax.jit(torque)
    sample = [values[0] for values in data[:3]]
    batches = jax.random.permutation(next(keys), BATCH * STEPS).reshape(STEPS, BATCH)
    batches = [batch for batch in batches]

    def epoch():
        state = (parameters, zeros, zeros, 1.0)
        for batch in batches:
            state = compiled(*state, batch, data)
        jax.block_until_ready(state)

    train = best(epoch, rounds, clock) / STEPS
    one = best(lambda: [jax.block_until_ready(single(parameters, *sample)) for _ in range(50)], rounds, clock) / 50
    return 1e3 * train, 1e6 * one


def main():
    options = arguments()
    is_alone = options.cores == 1
    if is_alone:
        os.environ["XLA_FLAGS"] = ONE_CORE
    else:
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:options.cores])
    try:
        import jax
    except ImportError:
        print("skipped: delan_peer: jax is missing")
        return
    threads = {"RAYON_NUM_THREADS": str(options.cores)}
    done = subprocess.run([options.example], check=True, stdout=subprocess.PIPE, env={**os.environ, **threads})
    for model in json.loads(done.stdout)["models"]:
        clock, ours = (time.process_time, "training_step_ms") if is_alone else (time.perf_counter, "training_step_by_clock_ms")
        step, one = theirs(jax, model["activation"], options.rounds, clock)
        print(json.dumps({
            "activation": model["activation"], "jax": jax.__version__, "cores": options.cores,
            "training_step_ms": model[ours], "jax_training_step_ms": step,
            "training_ratio": step / model[ours],
            "torque_us": model["torque_us"], "jax_torque_us": one,
        }))


if __name__ == "__main__":
    main()
