"""A step of training beside PyTorch's nn.LSTM: same shapes, same data, same threads, in turns.

    cargo build --release -p hysteron-bench --examples
    python3 bench/peers/lstm_training_peer.py [--threads N] [--steps N] [--repetitions N] [--outputs all|last]
                                              [--flush] [--example FILE]

2 x 512 units, 2 inputs, 4 outputs, 64 sequences: forward, mean squared error, back through time, Adam. Prints the shortest
step of each and their ratio. With `--outputs last` the loss is of the last sample alone, as where a network is trained on
windows: derivatives then die away on the way back, below 1e-38 too, where many processors are slow; with `--flush` PyTorch
takes such numbers for zero. Says "skipped" where torch is missing.
"""

import argparse
import json
import os
import pathlib
import subprocess
import time

ROWS = 64


def arguments():
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target"))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--outputs", choices=["all", "last"], default="all")
    parser.add_argument("--flush", action="store_true")
    parser.add_argument("--example", type=pathlib.Path, default=target / "release/examples/lstm_training_step")
    return parser.parse_args()


def ours(options):
    """Shortest of two steps [s], and the loss at the end."""
    environment = {**os.environ, "RAYON_NUM_THREADS": str(options.threads)}
    command = [options.example, str(options.steps), "2", options.outputs]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, env=environment)
    report = json.loads(done.stdout)
    return report["seconds"], report["losses"][-1]


class Theirs:
    def __init__(self, torch, options):
        self.torch = torch
        torch.manual_seed(1)
        torch.set_num_threads(options.threads)
        torch.set_flush_denormal(options.flush)
        self.lstm = torch.nn.LSTM(2, 512, 2)
        self.head = torch.nn.Linear(512, 4)
        self.adam = torch.optim.Adam([*self.lstm.parameters(), *self.head.parameters()])
        k = torch.arange(options.steps * ROWS * 2)
        wave = torch.sin(0.1 * (k // (2 * ROWS)) + 0.37 * (k % (2 * ROWS)))
        self.inputs = wave.reshape(options.steps, ROWS, 2).float()
        self.first = 0 if options.outputs == "all" else options.steps - 1
        self.targets = 0.5 * self.inputs[self.first :].sum(dim=2, keepdim=True)

    def step(self):
        """Time of one step [s], and the loss before it."""
        start = time.perf_counter()
        self.adam.zero_grad()
        outputs, _ = self.lstm(self.inputs)
        loss = ((self.head(outputs[self.first :]) - self.targets) ** 2).mean()
        loss.backward()
        self.adam.step()
        return time.perf_counter() - start, loss.item()


def main():
    options = arguments()
    try:
        import torch
    except ImportError:
        print("skipped: lstm_training_peer: torch is missing")
        return
    theirs = Theirs(torch, options)
    theirs.step()
    fastest = [float("inf"), float("inf")]
    losses = [None, None]
    for _ in range(options.repetitions):
        for k, step in enumerate([lambda: ours(options), theirs.step]):
            seconds, losses[k] = step()
            fastest[k] = min(fastest[k], seconds)
    size = f"2 x 512, {ROWS} x {options.steps}, loss of {options.outputs}, {options.threads} threads"
    print(f"{size}, torch {torch.__version__}{', flushing' if options.flush else ''}")
    print(f"ours {fastest[0]:.3f} s (loss {losses[0]:.4f}), torch {fastest[1]:.3f} s (loss {losses[1]:.4f})")
    print(f"torch's time over ours: {fastest[1] / fastest[0]:.2f}")


if __name__ == "__main__":
    main()
