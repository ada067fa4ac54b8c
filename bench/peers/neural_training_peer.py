"""Training of an actuator through the simulated arm beside MJX with the same network: simulated steps per second, forward and back.

    cargo build --release -p hysteron-arm-learning --example neural_rates
    python3 bench/peers/neural_training_peer.py [--example FILE] [--rollouts N,...]

The network has the sizes of NeuralActuator's release (width 192, 4 layers, 9 tokens), in both forms: the published one looks at a window
of 9 tokens anew at every step, the streaming one keeps keys and values. The arm is an OpenManipulator-X, 64 steps of 17 ms in four parts,
semi-implicit Euler with implicit damping, and a gripper's motor as an axis of its own. The gradient is that of a sum of squared positions by
all weights. JAX is compiled, in single precision, with and without recomputation on the way back, for each number of arms side by side; its
fastest counts. Both run on one core, in processor time, the best of seven rounds after the first, which compiles. Needs the wheels `jax` and
`mujoco-mjx`; says "skipped" by name where they are missing.
"""

import argparse
import json
import os
import pathlib
import subprocess
import time

from arm_rollouts_peer import arm

HORIZON, PARTS, PERIOD, ROUNDS = 64, 4, 0.017, 7
ARMATURE, DAMPING, LIMITS = 0.1, 1.0, [5.0, 5.0, 5.0, 5.0, 1.5]
WIDTH, LAYERS, ATTENTION, FEED_FORWARD, LATENT, TOKENS = 192, 4, 4, 384, 96, 9
JOINTS, MOTORS, OUTPUTS = 4, 5, 14


def arguments():
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target"))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--example", type=pathlib.Path, default=target / "release/examples/neural_rates")
    parser.add_argument("--rollouts", default="16,64", help="arms side by side in JAX, the fastest counts [default: %(default)s]")
    return parser.parse_args()


def damped_arm(mujoco, mjx):
    spec = arm(mujoco, PERIOD / PARTS)
    for joint in spec.joints:
        joint.armature, joint.damping[0] = ARMATURE, DAMPING
    return mjx.put_model(spec.compile())


class Network:
    """Pre-norm Transformer with gated attention and one perceptron for each group of outputs."""

    def __init__(self, jax, inputs):
        self.jax, self.jnp = jax, jax.numpy
        keys = iter(jax.random.split(jax.random.PRNGKey(1), 64))

        def linear(a, b):
            return jax.random.normal(next(keys), (a, b)) / a**0.5, self.jnp.zeros(b)

        ones = (self.jnp.ones(WIDTH), self.jnp.zeros(WIDTH))
        self.parameters = {
            "input": linear(inputs, WIDTH),
            "position": self.jnp.zeros((TOKENS, WIDTH)),
            "layers": [
                {
                    "norms": [ones, ones], "attention": linear(WIDTH, 4 * WIDTH), "out": linear(WIDTH, WIDTH),
                    "up": linear(WIDTH, FEED_FORWARD), "down": linear(FEED_FORWARD, WIDTH),
                    "lags": self.jnp.zeros((ATTENTION, TOKENS)),
                }
                for _ in range(LAYERS)
            ],
            "norm": ones,
            "latent": linear(WIDTH, 4 * LATENT),
            "heads": linear(4 * LATENT, OUTPUTS),
        }

    @staticmethod
    def linear(layer, x):
        return x @ layer[0] + layer[1]

    def norm(self, layer, x):
        centred = x - x.mean(-1, keepdims=True)
        return centred / self.jnp.sqrt((centred**2).mean(-1, keepdims=True) + 1e-5) * layer[0] + layer[1]

    def split(self, x):
        return x.reshape(*x.shape[:-1], ATTENTION, WIDTH // ATTENTION)

    def read_out(self, p, x):
        return self.linear(p["heads"], self.jax.nn.silu(self.linear(p["latent"], x)))

    def feed_forward(self, layer, x):
        hidden = self.jax.nn.gelu(self.linear(layer["up"], self.norm(layer["norms"][1], x)))
        return x + self.linear(layer["down"], hidden)

    def window(self, p, tokens):
        """Outputs of one window (tokens x inputs)."""
        jnp = self.jnp
        x = self.linear(p["input"], tokens) + p["position"]
        for layer in p["layers"]:
            q, gate, k, v = jnp.split(self.linear(layer["attention"], self.norm(layer["norms"][0], x)), 4, axis=-1)
            q, k, v = self.split(q), self.split(k), self.split(v)
            scores = jnp.einsum("ihd,jhd->hij", q, k) / (WIDTH // ATTENTION) ** 0.5
            seen = jnp.einsum("hij,jhd->ihd", self.jax.nn.softmax(scores), v).reshape(TOKENS, WIDTH)
            x = x + self.linear(layer["out"], seen * self.jax.nn.sigmoid(gate))
            x = self.feed_forward(layer, x)
        return self.read_out(p, self.norm(p["norm"], x).mean(0))

    def streaming(self, p, token, cache):
        """Outputs of one token, and what is kept of it."""
        jnp = self.jnp
        keys, values, last = cache
        x = self.linear(p["input"], token)
        new_keys, new_values = [], []
        for at, layer in enumerate(p["layers"]):
            q, gate, k, v = jnp.split(self.linear(layer["attention"], self.norm(layer["norms"][0], x)), 4, axis=-1)
            k = jnp.concatenate([keys[at, 1:], self.split(k)[None]])
            v = jnp.concatenate([values[at, 1:], self.split(v)[None]])
            scores = jnp.einsum("hd,jhd->hj", self.split(q), k) / (WIDTH // ATTENTION) ** 0.5 + layer["lags"][:, ::-1]
            seen = jnp.einsum("hj,jhd->hd", self.jax.nn.softmax(scores), v).reshape(WIDTH)
            x = x + self.linear(layer["out"], seen * self.jax.nn.sigmoid(gate))
            x = self.feed_forward(layer, x)
            new_keys.append(k)
            new_values.append(v)
        last = jnp.concatenate([last[1:], self.norm(p["norm"], x)[None]])
        return self.read_out(p, last.mean(0)), (jnp.stack(new_keys), jnp.stack(new_values), last)

    def fresh(self, form, inputs):
        if form == "published":
            return self.jnp.zeros((TOKENS, inputs))
        kept = self.jnp.zeros((LAYERS, TOKENS, ATTENTION, WIDTH // ATTENTION))
        return kept, kept, self.jnp.zeros((TOKENS, WIDTH))

    def step(self, form, p, token, memory):
        if form == "streaming":
            return self.streaming(p, token, memory)
        window = self.jnp.concatenate([memory[1:], token[None]])
        return self.window(p, window), window


def gradient(jax, mjx, model, network, form, inputs, is_recomputed):
    """The gradient by the weights of rollouts side by side, compiled."""
    jnp, start, limits = jax.numpy, mjx.make_data(model), jax.numpy.array(LIMITS)

    def rollout(p, initial, goals):
        def step(carry, goal):
            (data, gripper), memory = carry
            state = jnp.concatenate([data.qpos, gripper[:1], data.qvel, gripper[1:]])
            token = jnp.concatenate([state, goal, goal - state[:MOTORS], jnp.zeros(inputs - 4 * MOTORS)])
            outputs, memory = network.step(form, p, token, memory)
            torque = limits * jnp.tanh(outputs[:MOTORS] / limits)

            def part(both, _):
                data, (angle, speed) = both
                data = mjx.step(model, data.replace(qfrc_applied=torque[:JOINTS]))
                dt = PERIOD / PARTS
                speed = (speed + dt * torque[JOINTS] / ARMATURE) / (1 + dt * DAMPING / ARMATURE)
                return (data, jnp.array([angle + dt * speed, speed])), None

            (data, gripper), _ = jax.lax.scan(part, (data, gripper), None, length=PARTS)
            return ((data, gripper), memory), jnp.append(data.qpos, gripper[0])

        data = start.replace(qpos=initial[:JOINTS], qvel=initial[MOTORS : MOTORS + JOINTS])
        memory = network.fresh(form, inputs)
        if form == "streaming":
            # What it has seen before the rollout begins; the published form's window holds it as it is.
            past = 0.1 * jnp.ones((TOKENS - 1, inputs))
            memory, _ = jax.lax.scan(lambda memory, token: (network.step(form, p, token, memory)[1], None), memory, past)
        carry = ((data, initial[jnp.array([JOINTS, -1])]), memory)
        _, positions = jax.lax.scan(jax.checkpoint(step) if is_recomputed else step, carry, goals)
        return jnp.sum((positions - goals) ** 2)

    many = jax.vmap(rollout, (None, 0, 0))
    return jax.jit(jax.grad(lambda p, initial, goals: many(p, initial, goals).mean()))


def theirs(inputs, rollouts):
    """MJX's simulated steps per second in both forms; None where it cannot be had."""
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    try:
        import jax
        import mujoco
        from mujoco import mjx
    except ImportError:
        print("skipped: neural_training_peer: MJX (pip install jax mujoco-mjx)")
        return None
    model, network, rates = damped_arm(mujoco, mjx), Network(jax, inputs), {}
    for form in ["streaming", "published"]:
        for arms in rollouts:
            initial = 0.3 * jax.random.uniform(jax.random.PRNGKey(2), (arms, 2 * MOTORS))
            goals = 0.3 * jax.random.uniform(jax.random.PRNGKey(3), (arms, HORIZON, MOTORS))
            for is_recomputed in [False, True]:
                run = gradient(jax, mjx, model, network, form, inputs, is_recomputed)
                jax.block_until_ready(run(network.parameters, initial, goals))
                best = float("inf")
                for _ in range(ROUNDS):
                    begin = time.process_time()
                    jax.block_until_ready(run(network.parameters, initial, goals))
                    best = min(best, time.process_time() - begin)
                rate = arms * HORIZON / best
                way = "recomputed" if is_recomputed else "kept"
                print(f"MJX, {form}, {arms} arms, {way}: {rate:.0f} simulated steps a second", flush=True)
                rates[form] = max(rates.get(form, 0.0), rate)
    return rates


def main():
    options = arguments()
    os.sched_setaffinity(0, {0})
    environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
    done = subprocess.run([options.example], check=True, stdout=subprocess.PIPE, env=environment)
    ours = json.loads(done.stdout)
    peer = theirs(ours["inputs"], [int(n) for n in options.rollouts.split(",")])
    for form in ["streaming", "published"]:
        beside = f", MJX {peer[form]:.0f} ({ours[form] / peer[form]:.1f} times)" if peer else ""
        print(f"{form}: {ours[form]:.0f} simulated steps a second{beside}")
    if peer:
        print(f"streaming form beside MJX with the published one: {ours['streaming'] / peer['published']:.1f} times")


if __name__ == "__main__":
    main()
