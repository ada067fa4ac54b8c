# Made by `cargo run --release -p hysteron-python --example generate_sources`; do not edit.
"""Servos and tracker, real or emulated."""

# ruff: noqa
from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from . import outcomes
from ._verb import PathLike, flag, option, options, positional, positionals, run_verb

__all__ = [
    "calibrate",
    "check",
    "emulate",
    "recover",
]


def check(
    *,
    rig: PathLike | None = None,
    calibration: PathLike | None = None,
    reboot: bool = False,
    release: bool = False,
    restore: bool = False,
    yes: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.RigCheckOutcome:
    """List serial ports; check servos, their registers and the tracker of a rig, or both arms.

    As `hysteron rig check`.

    Args:
        rig: Rig file, or file of two arms.
        calibration: Calibration whose registers are expected [default: the file that the rig file names].
        reboot: Restart every servo first: clears hardware errors whose cause is gone.
        release: Switch the torque of every servo off, for example where a lost cable has left it on.
        restore: Write back the registers that differ from what is expected, after asking; switches the torque
            off first.
        yes: Write back without asking.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "rig", "check",
        *option("--rig", rig),
        *option("--calibration", calibration),
        *flag("--reboot", reboot),
        *flag("--release", release),
        *flag("--restore", restore),
        *flag("--yes", yes),
    ]
    outcome: outcomes.RigCheckOutcome = run_verb(
        outcomes.RigCheckOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def calibrate(
    *,
    rig: PathLike,
    out: PathLike | None = None,
    keep_registers: bool = False,
    seed: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.RigCalibrateOutcome:
    """Find zero, slack and pretension of every tendon, and the tracker's frame.

    As `hysteron rig calibrate`.

    Args:
        rig: Rig file, or virtual:PRESET.
        out: Calibration to write [default: the file that the rig file names].
        keep_registers: Store the present registers of the servos in the calibration, also where they differ
            from the one before or from the factory.
        seed: Seed of a virtual rig. Default: 1.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "rig", "calibrate",
        *option("--rig", rig),
        *option("--out", out),
        *flag("--keep-registers", keep_registers),
        *option("--seed", seed),
    ]
    outcome: outcomes.RigCalibrateOutcome = run_verb(
        outcomes.RigCalibrateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def emulate(
    *,
    preset: Literal["mild", "typical", "harsh", "wide"] | None = None,
    robot: PathLike | None = None,
    seed: int | None = None,
    dir: PathLike | None = None,
    baud: int | None = None,
    return_delay_us: float | None = None,
    faults: PathLike | None = None,
    draw_faults: int | None = None,
    relaxed: bool = False,
    port_tracker: int | None = None,
    for_s: float | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.RigEmulateOutcome:
    """Emulate servos and tracker of a rig on their ports.

    Needs nothing; makes a serial port and a TCP port that behave like the real servos and the real tracker,
    in real time, and writes the rig file to go with them.

    As `hysteron rig emulate`.

    Args:
        preset: Amount of friction, backlash and noise of the virtual rig. Default: typical.
        robot: Virtual robot to emulate, instead of a preset.
        seed: Seed of noise and of drawn faults. Default: 1.
        dir: Folder for the port, the rig file and the logs. Default: out/rig.
        baud: Baud of the servos. Default: 1000000.
        return_delay_us: Delay before a servo answers. Default: 500.
        faults: Faults to inject (.toml).
        draw_faults: Draw that many faults, spread over the time of --for-s. Default: 0.
        relaxed: Sleep instead of polling: answers come some 0.1 ms late, and the processor stays free.
        port_tracker: TCP port on which the tracker serves its poses, by OpenIGTLink; 0 for any that is free.
            Default: 18944.
        for_s: End after that many seconds [default: at Ctrl-C].
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "rig", "emulate",
        *option("--preset", preset),
        *option("--robot", robot),
        *option("--seed", seed),
        *option("--dir", dir),
        *option("--baud", baud),
        *option("--return-delay-us", return_delay_us),
        *option("--faults", faults),
        *option("--draw-faults", draw_faults),
        *flag("--relaxed", relaxed),
        *option("--port-tracker", port_tracker),
        *option("--for-s", for_s),
    ]
    outcome: outcomes.RigEmulateOutcome = run_verb(
        outcomes.RigEmulateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def recover(
    journal: PathLike,
    *,
    out: PathLike,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.RigRecoverOutcome:
    """Open the journal of a run that crashed.

    As `hysteron rig recover`.

    Args:
        journal: Journal of the run.
        out: Recording to write, .parquet or .csv.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "rig", "recover",
        *positional(journal),
        *option("--out", out),
    ]
    outcome: outcomes.RigRecoverOutcome = run_verb(
        outcomes.RigRecoverOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome
