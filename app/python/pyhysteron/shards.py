# Made by `cargo run --release -p hysteron-python --example generate_sources`; do not edit.
"""Synthetic data made by many machines, in a folder or an object store."""

# ruff: noqa
from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from . import outcomes
from ._verb import PathLike, flag, option, options, positional, positionals, run_verb

__all__ = [
    "merge",
    "plan",
    "status",
    "work",
]


def plan(
    scene: PathLike,
    *,
    to: str,
    reduced: PathLike | None = None,
    residual: PathLike | None = None,
    plan: str | None = None,
    shards: int | None = None,
    rows_per_shard: int | None = None,
    measure: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ShardsPlanOutcome:
    """Plan a set of synthetic data that many machines make.

    As `hysteron shards plan`.

    Args:
        scene: Scene file of the robot (scene.toml).
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        residual: Checkpoint by hysteron fit-residual.
        plan: Plan file (.toml), of any number of trajectories, or the name of a built-in plan [default: that
            of generate].
        to: Place of the set: a folder that all machines see, or s3://, gs:// or az://.
        shards: Number of shards.
        rows_per_shard: Samples of a shard, about [default: 100000].
        measure: Trajectories to simulate for the estimate of time and size; 0 makes none. Default: 2.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "shards", "plan",
        *positional(scene),
        *option("--reduced", reduced),
        *option("--residual", residual),
        *option("--plan", plan),
        *option("--to", to),
        *option("--shards", shards),
        *option("--rows-per-shard", rows_per_shard),
        *option("--measure", measure),
    ]
    outcome: outcomes.ShardsPlanOutcome = run_verb(
        outcomes.ShardsPlanOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def work(
    url: str,
    *,
    worker: str | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ShardsWorkOutcome:
    """Make shards of a planned set until none is missing.

    As `hysteron shards work`.

    Args:
        url: Place of the set, as given to hysteron shards plan.
        worker: Only every N-th shard, from the I-th on [default: any that is missing].
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "shards", "work",
        *positional(url),
        *option("--worker", worker),
    ]
    outcome: outcomes.ShardsWorkOutcome = run_verb(
        outcomes.ShardsWorkOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def status(
    url: str,
    *,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ShardsStatusOutcome:
    """Show how far a planned set is.

    As `hysteron shards status`.

    Args:
        url: Place of the set, as given to hysteron shards plan.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "shards", "status",
        *positional(url),
    ]
    outcome: outcomes.ShardsStatusOutcome = run_verb(
        outcomes.ShardsStatusOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def merge(
    url: str,
    *,
    out: PathLike,
    partial: bool = False,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ShardsMergeOutcome:
    """Write the card of a set made in shards.

    As `hysteron shards merge`.

    Args:
        url: Place of the set, as given to hysteron shards plan.
        out: Folder of the card.
        partial: Write the card of the shards that are there, even if some are missing.
        png: Write the figure as .png too.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "shards", "merge",
        *positional(url),
        *option("--out", out),
        *flag("--partial", partial),
        *flag("--png", png),
    ]
    outcome: outcomes.ShardsMergeOutcome = run_verb(
        outcomes.ShardsMergeOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome
