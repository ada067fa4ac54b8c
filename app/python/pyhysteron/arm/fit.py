# Made by `cargo run --release -p hysteron-python --example generate_sources`; do not edit.
"""Learn a model from recordings."""

# ruff: noqa
from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from .. import outcomes
from .._verb import PathLike, flag, option, options, positional, positionals, run_verb

__all__ = [
    "delan",
    "neural",
]


def delan(
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    variant: str | None = None,
    hidden: int | None = None,
    products: int | None = None,
    squares: int | None = None,
    epochs: int | None = None,
    polish: int | None = None,
    cutoff: float | None = None,
    seed: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmFitDelanOutcome:
    """Learn inverse dynamics with a model of the DeLaN family.

    As `hysteron arm fit delan`.

    Args:
        recordings: Recordings to learn from.
        out: Model to write, .safetensors.
        variant: structured-lagrangian, black-box-lagrangian, feed-forward, friction or augmented. Default:
            augmented.
        hidden: Units of each of the two hidden layers. Default: 64.
        products: Inputs are products of the sines and cosines of up to so many joints, with a linear path
            past its hidden layers; 0 for sines and cosines alone. Default: 0.
        squares: Squares in the kinetic energy beyond one for each joint; of a chain of turning joints two for
            each in a plane, or six, hold it exactly, with --products; up to 32. Default: 0.
        epochs: Epochs of Adam at most. Default: 200.
        polish: Steps of Levenberg and Marquardt's method after Adam at most, in double precision; for up to
            8000 parameters. Default: 0.
        cutoff: Velocities above this are noise, where accelerations are differences of them. Default: 10.
        seed: Of initial parameters and of minibatches. Default: 0.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "fit", "delan",
        *positionals(recordings),
        *option("--out", out),
        *option("--variant", variant),
        *option("--hidden", hidden),
        *option("--products", products),
        *option("--squares", squares),
        *option("--epochs", epochs),
        *option("--polish", polish),
        *option("--cutoff", cutoff),
        *option("--seed", seed),
    ]
    outcome: outcomes.ArmFitDelanOutcome = run_verb(
        outcomes.ArmFitDelanOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def neural(
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    model: str | None = None,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    leave_out: str | Sequence[str] | None = None,
    free: str | Sequence[str] | None = None,
    form: str | None = None,
    block: str | None = None,
    width: int | None = None,
    layers: int | None = None,
    prior: str | None = None,
    drive: str | None = None,
    warm_start: int | None = None,
    updates: int | None = None,
    horizons: int | Sequence[int] | None = None,
    rollouts: int | None = None,
    sensing: str | None = None,
    sensing_updates: int | None = None,
    pure: float | None = None,
    learning_rate: float | None = None,
    ema: float | None = None,
    start_noise: float | None = None,
    contact_n: float | None = None,
    period_s: float | None = None,
    armature_kg_m2: float | None = None,
    damping_n_m_s_per_rad: float | None = None,
    torque_limit_n_m: float | None = None,
    load_friction: bool = False,
    seed: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmFitNeuralOutcome:
    """Learn the torques of an arm's motors from their telemetry, without measured torques.

    As `hysteron arm fit neural`.

    Args:
        recordings: Recordings to learn from, or folders of them.
        out: Actuator to write, .safetensors.
        model: The arm: a file of URDF or MJCF, or a built-in name. Default: open-manipulator-x.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        leave_out: Do not learn from recordings whose path contains this, as in
            `weight/pick_place_object_500g`; may be repeated.
        free: Recordings whose path contains this move freely: a sample without label of force is one of no
            force; may be repeated. Default: force_unlabeled.
        form: streaming (one token a step), or window (all tokens every step, as published). Default:
            streaming.
        block: released (normalisation first, gated attention, GELU), printed (equations 4 and 5 of the
            paper), or gru or lstm in their place (with as many parameters). Default: released.
        width: Numbers of a token within the network; the feed-forward networks have twice as many, the heads
            half. Default: 192.
        layers: Layers of the network. Default: 4.
        prior: Model that moves the simulated motors next to the network: none (as published), servo
            (stiffness, friction and damping identified by rollout, to whose torque the network's is added),
            or drive (that of --drive, likewise). Default: none.
        drive: Drive of every motor for --prior drive, with its thermal model and its limits of voltage and
            current: a name, or a file of arm identify servo --drive-out; recordings need their position_gain.
        warm_start: Updates on torques by inverse dynamics, before the closed loop. Default: 2000.
        updates: Updates in the closed loop. Default: 10000.
        horizons: Steps of a rollout: these, one after the other, each for an equal part of the updates.
            Default: 64, 128, 256, 320, 500.
        rollouts: Rollouts of an update. Default: 16.
        sensing: Where force, contact and condition come from: loop (the network in the loop, as published),
            or observer (a second network, whose inputs are recorded telemetry with PWM and whose output is
            added to the force of a momentum observer). Default: loop.
        sensing_updates: Updates of that second network. Default: 12000.
        pure: Part of the rollouts, and of the error in validation, in pure simulation: currents by the model
            of the drives. Default: 0.
        learning_rate: Full step size. Default: 0.0001.
        ema: Part of the moving average of the weights that each update replaces. Default: 0.001.
        start_noise: Initial positions of a rollout are off by up to this [rad]. Default: 0.15.
        contact_n: A force longer than this is a contact [N]; above the noise of the sensor that labels it.
            Default: 0.01.
        period_s: Step of the simulation [s]. Default: 0.017.
        armature_kg_m2: Rotor and gears of every joint's motor, at the output [default: 0.1 as published; 0.02
            with --prior servo; the drive's].
        damping_n_m_s_per_rad: Damping of every joint's motor [default: 1 as published; with --prior servo it
            is identified; the drive's].
        torque_limit_n_m: Largest torque of a joint's motor [default: 5 as published; what the drive stalls
            at].
        load_friction: Friction of the servo of --prior servo grows with the torque through the gear, by a
            share that is identified with it.
        seed: Of initial weights, batches and noise. Default: 0.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "fit", "neural",
        *positionals(recordings),
        *option("--out", out),
        *option("--model", model),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *options("--leave-out", leave_out, None),
        *options("--free", free, None),
        *option("--form", form),
        *option("--block", block),
        *option("--width", width),
        *option("--layers", layers),
        *option("--prior", prior),
        *option("--drive", drive),
        *option("--warm-start", warm_start),
        *option("--updates", updates),
        *options("--horizons", horizons, ","),
        *option("--rollouts", rollouts),
        *option("--sensing", sensing),
        *option("--sensing-updates", sensing_updates),
        *option("--pure", pure),
        *option("--learning-rate", learning_rate),
        *option("--ema", ema),
        *option("--start-noise", start_noise),
        *option("--contact-n", contact_n),
        *option("--period-s", period_s),
        *option("--armature-kg-m2", armature_kg_m2),
        *option("--damping-n-m-s-per-rad", damping_n_m_s_per_rad),
        *option("--torque-limit-n-m", torque_limit_n_m),
        *flag("--load-friction", load_friction),
        *option("--seed", seed),
    ]
    outcome: outcomes.ArmFitNeuralOutcome = run_verb(
        outcomes.ArmFitNeuralOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome
