# Made by `cargo run --release -p hysteron-python --example generate_sources`; do not edit.
"""Identify an arm from recordings of it."""

# ruff: noqa
from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from .. import outcomes
from .._verb import PathLike, flag, option, options, positional, positionals, run_verb

__all__ = [
    "friction",
    "inertia",
    "payload",
    "servo",
]


def inertia(
    model: str,
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    test: PathLike | None = None,
    hold_out: float | None = None,
    prior: float | None = None,
    response: bool = False,
    robot: PathLike | None = None,
    cutoff: float | None = None,
    torque_constants: float | Sequence[float] | None = None,
    width: float | None = None,
    lock: str | Sequence[str] | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmIdentifyInertiaOutcome:
    """Bodies, rotors and friction of all joints.

    As `hysteron arm identify inertia`.

    Args:
        model: File of URDF or MJCF, or name of a built-in robot.
        recordings: Recordings to fit.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        test: Recording that is not fitted, to test on.
        hold_out: Last part of the recordings that is not fitted, to test on. Default: 0.
        prior: Weight of the bodies in the robot's file, in samples. Default: 1.
        response: Identify the lead or lag of measured torques, and their frequency response.
        robot: File for the robot as identified: .urdf, .xml (MJCF) or .csv (parameters).
        cutoff: Highest frequency of the motion; above it, signals count as noise. Default: 8.
        torque_constants: Torque for a current in every joint, where the recordings have currents.
        width: Speed within which Coulomb friction changes its sign. Default: 0.05.
        lock: Joint of the robot without channels in the recordings, at zero or at a coordinate.
        out: File of JSON to write.
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
        "arm", "identify", "inertia",
        *positional(model),
        *positionals(recordings),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *option("--test", test),
        *option("--hold-out", hold_out),
        *option("--prior", prior),
        *flag("--response", response),
        *option("--robot", robot),
        *option("--cutoff", cutoff),
        *options("--torque-constants", torque_constants, ","),
        *option("--width", width),
        *options("--lock", lock, None),
        *option("--out", out),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.ArmIdentifyInertiaOutcome = run_verb(
        outcomes.ArmIdentifyInertiaOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def friction(
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    joint: int | None = None,
    law: str | None = None,
    method: str | None = None,
    folds: int | None = None,
    huber: float | None = None,
    seed: int | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmIdentifyFrictionOutcome:
    """A law of friction of one joint.

    As `hysteron arm identify friction`.

    Args:
        recordings: Recordings to fit.
        joint: Number of the joint, from 1. Default: 1.
        law: coulomb-viscous, stribeck, directed-stribeck, learned-map: a curve of any shape, or rising-map: a
            monotone curve. Default: stribeck.
        method: least-squares, pso, de, anfis or fnn. Default: least-squares.
        folds: Folds of cross-validation.
        huber: Error from which on a sample counts linearly rather than squared.
        seed: Seed of populations. Default: 1.
        out: File of JSON to write.
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
        "arm", "identify", "friction",
        *positionals(recordings),
        *option("--joint", joint),
        *option("--law", law),
        *option("--method", method),
        *option("--folds", folds),
        *option("--huber", huber),
        *option("--seed", seed),
        *option("--out", out),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.ArmIdentifyFrictionOutcome = run_verb(
        outcomes.ArmIdentifyFrictionOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def servo(
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    test: PathLike | Sequence[PathLike] | None = None,
    drive: str | None = None,
    law: str | None = None,
    mass_kg: float | None = None,
    length_m: float | None = None,
    gain: float | None = None,
    step: float | None = None,
    drive_out: PathLike | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmIdentifyServoOutcome:
    """Motor, supply, heat and friction of a servo that swings a weight.

    As `hysteron arm identify servo`.

    Args:
        recordings: Recordings to fit.
        test: Recordings that are not fitted, to test on.
        drive: Name of a drive, or a file of TOML. Default: xl330-m288.
        law: Law of friction: coulomb-viscous, stribeck, directed-stribeck, m1 to m6 [default: the drive's].
        mass_kg: Mass of the weight [default: from the recordings].
        length_m: Distance of the weight from the axis [default: from the recordings].
        gain: Proportional gain as the register has it [default: from the recordings].
        step: Longest step of the simulation. Default: 0.001.
        drive_out: The drive with what was found, a file for --drive of this and other verbs.
        out: File of JSON to write.
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
        "arm", "identify", "servo",
        *positionals(recordings),
        *options("--test", test, None),
        *option("--drive", drive),
        *option("--law", law),
        *option("--mass-kg", mass_kg),
        *option("--length-m", length_m),
        *option("--gain", gain),
        *option("--step", step),
        *option("--drive-out", drive_out),
        *option("--out", out),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.ArmIdentifyServoOutcome = run_verb(
        outcomes.ArmIdentifyServoOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def payload(
    model: str,
    recordings: PathLike | Sequence[PathLike],
    *,
    bare: PathLike | Sequence[PathLike],
    out: PathLike,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    frame: str | None = None,
    robot: PathLike | None = None,
    cutoff: float | None = None,
    torque_constants: float | Sequence[float] | None = None,
    width: float | None = None,
    lock: str | Sequence[str] | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ArmIdentifyPayloadOutcome:
    """Payload of an arm.

    As `hysteron arm identify payload`.

    Args:
        model: File of URDF or MJCF, or name of a built-in robot.
        recordings: Recordings with the payload.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        bare: Recordings without.
        frame: Frame that holds the payload [default: the robot's last].
        robot: File for the robot as identified: .urdf, .xml (MJCF) or .csv (parameters).
        cutoff: Highest frequency of the motion; above it, signals count as noise. Default: 8.
        torque_constants: Torque for a current in every joint, where the recordings have currents.
        width: Speed within which Coulomb friction changes its sign. Default: 0.05.
        lock: Joint of the robot without channels in the recordings, at zero or at a coordinate.
        out: File of JSON to write.
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
        "arm", "identify", "payload",
        *positional(model),
        *positionals(recordings),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *options("--bare", bare, None),
        *option("--frame", frame),
        *option("--robot", robot),
        *option("--cutoff", cutoff),
        *options("--torque-constants", torque_constants, ","),
        *option("--width", width),
        *options("--lock", lock, None),
        *option("--out", out),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.ArmIdentifyPayloadOutcome = run_verb(
        outcomes.ArmIdentifyPayloadOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome
