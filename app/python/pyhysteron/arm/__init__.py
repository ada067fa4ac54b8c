# Made by `cargo run --release -p hysteron-python --example generate_sources`; do not edit.
"""Rigid-body arms: robot files, dynamics, identification, learning."""

# ruff: noqa
from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from . import fit, identify
from .. import outcomes
from .._verb import PathLike, flag, option, options, positional, positionals, run_verb

__all__ = [
    "adapt",
    "check",
    "dynamics",
    "emulate",
    "estimate",
    "evaluate",
    "excite",
    "export",
    "fit",
    "generate",
    "identify",
    "info",
    "record",
    "simulate",
]


def adapt(
    actuator: PathLike,
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    updates: int | None = None,
    robot: str | None = None,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmAdaptOutcome:
    """Adapt a neural actuator to an arm whose friction or drives have changed.

    As `hysteron arm adapt`.

    Args:
        actuator: Actuator by hysteron arm fit neural --prior servo.
        recordings: Recordings of the changed arm: one to three are enough.
        out: Actuator to write, .safetensors.
        updates: Updates of its network. Default: 100.
        robot: The arm: a file of URDF or MJCF, or a built-in name. Default: open-manipulator-x.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "adapt",
        *positional(actuator),
        *positionals(recordings),
        *option("--out", out),
        *option("--updates", updates),
        *option("--robot", robot),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
    ]
    outcome: outcomes.ArmAdaptOutcome = run_verb(
        outcomes.ArmAdaptOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def info(
    model: str,
    *,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmInfoOutcome:
    """Print the joints of a robot: tree, masses, ranges, reach.

    As `hysteron arm info`.

    Args:
        model: File of URDF or MJCF, or name of a built-in robot.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "info",
        *positional(model),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
    ]
    outcome: outcomes.ArmInfoOutcome = run_verb(
        outcomes.ArmInfoOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def check(
    model: str,
    *,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmCheckOutcome:
    """As info; fails where values are suspicious.

    Suspicious are masses and inertias that no physical body has, and lengths, masses and inertias that look
    like mm or g. Exit code 2 where something is.

    As `hysteron arm check`.

    Args:
        model: File of URDF or MJCF, or name of a built-in robot.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "check",
        *positional(model),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
    ]
    outcome: outcomes.ArmCheckOutcome = run_verb(
        outcomes.ArmCheckOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def dynamics(
    model: str,
    *,
    states: PathLike,
    out: PathLike,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    frame: str | None = None,
    derivatives: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmDynamicsOutcome:
    """Compute the dynamics of every row of states.

    As `hysteron arm dynamics`.

    Args:
        model: File of URDF or MJCF, name of a built-in robot, or model by hysteron arm fit delan.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        states: States, .csv or .parquet.
        out: Where the results go, .csv or .parquet.
        frame: Frame whose position and Jacobian are written [default: the last of the robot].
        derivatives: All derivatives too.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "dynamics",
        *positional(model),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *option("--states", states),
        *option("--out", out),
        *option("--frame", frame),
        *flag("--derivatives", derivatives),
    ]
    outcome: outcomes.ArmDynamicsOutcome = run_verb(
        outcomes.ArmDynamicsOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def emulate(
    *,
    dir: PathLike | None = None,
    arm: str | None = None,
    seed: int | None = None,
    trajectory: str | None = None,
    begins_s: float | None = None,
    faults: PathLike | None = None,
    relaxed: bool = False,
    for_s: float | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmEmulateOutcome:
    """Emulate a follower and the leader that a hand moves, on two ports.

    Needs nothing; makes two serial ports that behave like the servos of both arms, in real time, and writes
    the file of both arms.

    As `hysteron arm emulate`.

    Args:
        dir: Folder for the ports, the file of both arms and the log of torques. Default: out/arms.
        arm: Virtual arm: a file of TOML or a built-in name. Default: open-manipulator-x.
        seed: Seed of the individual arm, the hand's motion and all noise. Default: 0.
        trajectory: Motion of the hand and the obstacles in its way: a trajectory of `hysteron arm generate`.
            Default: force_unlabeled/backward_forward/test/001.
        begins_s: Time until the hand begins to move. Default: 10.
        faults: Faults of the follower to inject (.toml).
        relaxed: Sleep instead of polling: answers come some 0.1 ms late, and the processor stays free.
        for_s: End after that many seconds [default: at Ctrl-C].
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "emulate",
        *option("--dir", dir),
        *option("--arm", arm),
        *option("--seed", seed),
        *option("--trajectory", trajectory),
        *option("--begins-s", begins_s),
        *option("--faults", faults),
        *flag("--relaxed", relaxed),
        *option("--for-s", for_s),
    ]
    outcome: outcomes.ArmEmulateOutcome = run_verb(
        outcomes.ArmEmulateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def estimate(
    actuator: PathLike,
    recording: PathLike | None = None,
    *,
    out: PathLike,
    live: PathLike | None = None,
    seconds: float | None = None,
    robot: str | None = None,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    gain: float | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmEstimateOutcome:
    """Estimate torques, force, contact and motor condition from servo telemetry, along a recording or live on a bus; or external torques along a recording with learned dynamics.

    As `hysteron arm estimate`.

    Args:
        actuator: Actuator by hysteron arm fit neural --sensing observer, or model by hysteron arm fit delan.
        recording: Recording of the arm.
        live: Estimate while a follower follows its leader, as `hysteron arm record` does: file of both arms
            (.toml).
        seconds: Live: end after that many seconds [default: at Ctrl-C].
        out: Recording to write, .csv or .parquet.
        robot: The arm: a file of URDF or MJCF, or a built-in name. Default: open-manipulator-x.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        gain: Gain of the momentum observer [1/s], with a model by hysteron arm fit delan. Default: 25.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "estimate",
        *positional(actuator),
        *positional(recording),
        *option("--live", live),
        *option("--seconds", seconds),
        *option("--out", out),
        *option("--robot", robot),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *option("--gain", gain),
    ]
    outcome: outcomes.ArmEstimateOutcome = run_verb(
        outcomes.ArmEstimateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def evaluate(
    model: PathLike,
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike | None = None,
    figures: PathLike | None = None,
    robot: str | None = None,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    leave_out: str | Sequence[str] | None = None,
    free: str | Sequence[str] | None = None,
    detectors: PathLike | Sequence[PathLike] | None = None,
    cutoff: float | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmEvaluateOutcome:
    """Compare the predictions of a learned model with recordings.

    As `hysteron arm evaluate`.

    Args:
        model: Model by hysteron arm fit.
        recordings: Recordings to compare with: one for a model of inverse dynamics; for a neural actuator any
            number, or folders, without those called train or validation.
        out: Where the parts of the torque go, .csv or .parquet; of a neural actuator, every number as JSON.
        figures: Folder for report.html and metrics.json, of a neural actuator.
        robot: The arm of a neural actuator: a file of URDF or MJCF, or a built-in name. Default:
            open-manipulator-x.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        leave_out: Without recordings whose path contains this; may be repeated.
        free: Recordings whose path contains this move freely: a sample without label of force is one of no
            force; may be repeated. Default: force_unlabeled.
        detectors: Recordings or folders to which detectors of a degraded motor are fitted, as baselines of
            the network.
        cutoff: Velocities above this are noise, where accelerations are differences of them. Default: 10.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "evaluate",
        *positional(model),
        *positionals(recordings),
        *option("--out", out),
        *option("--figures", figures),
        *option("--robot", robot),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *options("--leave-out", leave_out, None),
        *options("--free", free, None),
        *options("--detectors", detectors, None),
        *option("--cutoff", cutoff),
    ]
    outcome: outcomes.ArmEvaluateOutcome = run_verb(
        outcomes.ArmEvaluateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def excite(
    model: str,
    *,
    out: PathLike,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    shape: Literal["fourier", "quintic", "cycloid"] | None = None,
    duration_s: float | None = None,
    harmonics: int | None = None,
    generations: int | None = None,
    seed: int | None = None,
    from_: float | Sequence[float] | None = None,
    to: float | Sequence[float] | None = None,
    limits: float | None = None,
    speed_limit: float | None = None,
    acceleration_limit: float | None = None,
    rate: float | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmExciteOutcome:
    """Design a motion that excites the parameters of an arm.

    As `hysteron arm excite`.

    Args:
        model: File of URDF or MJCF, or name of a built-in robot.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        out: Where the motion goes, .csv or .parquet.
        shape: Shape of the motion. Default: fourier.
        duration_s: Duration [default: 10 of a Fourier series, else as fast as limits allow].
        harmonics: Harmonics of the series. Default: 5.
        generations: Most generations of the search. Default: 150.
        seed: Seed of the search. Default: 1.
        from_: Coordinates at the start, in rad or m.
        to: Coordinates at the end, in rad or m.
        limits: Part of every limit that is used. Default: 0.9.
        speed_limit: Greatest speed of joints whose file has none, in rad/s or m/s.
        acceleration_limit: Greatest acceleration of all joints, in rad/s^2 or m/s^2.
        rate: Rate of the rows. Default: 100.
        figures: Folder for figures, report.html and metrics.json.
        png: Write each figure as .png too.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "excite",
        *positional(model),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *option("--out", out),
        *option("--shape", shape),
        *option("--duration-s", duration_s),
        *option("--harmonics", harmonics),
        *option("--generations", generations),
        *option("--seed", seed),
        *options("--from", from_, ","),
        *options("--to", to, ","),
        *option("--limits", limits),
        *option("--speed-limit", speed_limit),
        *option("--acceleration-limit", acceleration_limit),
        *option("--rate", rate),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.ArmExciteOutcome = run_verb(
        outcomes.ArmExciteOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def export(
    model: str,
    *,
    out: PathLike,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    parameters: PathLike | None = None,
    joints: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmExportOutcome:
    """Write a robot as URDF, MJCF or a table of parameters.

    As `hysteron arm export`.

    Args:
        model: File of URDF or MJCF, or name of a built-in robot.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        out: Where it goes: .urdf, .xml or .csv.
        parameters: Table with a row for each joint, whose parameters replace those of the robot.
        joints: The joints of an MJCF alone.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "export",
        *positional(model),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *option("--out", out),
        *option("--parameters", parameters),
        *flag("--joints", joints),
    ]
    outcome: outcomes.ArmExportOutcome = run_verb(
        outcomes.ArmExportOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def generate(
    *,
    out: PathLike,
    arm: str | None = None,
    seed: int | None = None,
    subsets: str | Sequence[str] | None = None,
    tasks: str | Sequence[str] | None = None,
    splits: str | Sequence[str] | None = None,
    payloads_g: int | Sequence[int] | None = None,
    trajectories: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmGenerateOutcome:
    """Record trajectories like those of the data set NAD with the virtual arm.

    As `hysteron arm generate`.

    Args:
        out: Folder to write to: SUBSET/TASK/SPLIT/NUMBER.parquet, as in NAD.
        arm: Virtual arm: a file of TOML or a built-in name. Default: open-manipulator-x.
        seed: Seed of the individual arm, its motions and its noise. Default: 0.
        subsets: Only these subsets: `force_unlabeled`, `force_sensor`, `weight`, `motor_condition`; and
            `motor_faults`, which NAD does not have.
        tasks: Only tasks whose names contain one of these, as in `sweep,pick_place`.
        splits: Only these splits: train, validation, test.
        payloads_g: Only trajectories with these payloads, 0 for none.
        trajectories: At most this many trajectories of a task and split.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "generate",
        *option("--out", out),
        *option("--arm", arm),
        *option("--seed", seed),
        *options("--subsets", subsets, ","),
        *options("--tasks", tasks, ","),
        *options("--splits", splits, ","),
        *options("--payloads-g", payloads_g, ","),
        *option("--trajectories", trajectories),
    ]
    outcome: outcomes.ArmGenerateOutcome = run_verb(
        outcomes.ArmGenerateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def record(
    *,
    arms: PathLike,
    out: PathLike,
    seconds: float | None = None,
    payload_g: float | None = None,
    degraded: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmRecordOutcome:
    """Record a follower that follows the leader in your hand.

    As `hysteron arm record`.

    Args:
        arms: File of both arms (.toml).
        out: Recording to write, .parquet or .csv.
        seconds: End after that many seconds [default: at Ctrl-C].
        payload_g: Payload of the follower; the recording names it. Default: 0.
        degraded: A motor of the follower is degraded; the recording is marked.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "record",
        *option("--arms", arms),
        *option("--out", out),
        *option("--seconds", seconds),
        *option("--payload-g", payload_g),
        *flag("--degraded", degraded),
    ]
    outcome: outcomes.ArmRecordOutcome = run_verb(
        outcomes.ArmRecordOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def simulate(
    model: str,
    *,
    torques: PathLike,
    out: PathLike,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    start: float | Sequence[float] | None = None,
    substeps: int | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmSimulateOutcome:
    """Simulate the motion of an arm under recorded torques.

    As `hysteron arm simulate`.

    Args:
        model: File of URDF or MJCF, or name of a built-in robot.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        torques: Torques, .csv or .parquet.
        out: Where the motion goes, .csv or .parquet.
        start: Coordinates at the start, in rad or m [default: those of the first row of REC, where it has
            them, else zero].
        substeps: Equal parts of the time between two rows. Default: 4.
        figures: Folder for figures, report.html and metrics.json.
        png: Write each figure as .png too.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "arm", "simulate",
        *positional(model),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *option("--torques", torques),
        *option("--out", out),
        *options("--start", start, ","),
        *option("--substeps", substeps),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.ArmSimulateOutcome = run_verb(
        outcomes.ArmSimulateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome
