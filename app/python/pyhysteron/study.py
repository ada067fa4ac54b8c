# Made by `cargo run --release -p hysteron-python --example generate_sources`; do not edit.
"""Studies: published results, measured again; and the chain of stages of a study file."""

# ruff: noqa
from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from . import outcomes
from ._verb import PathLike, flag, option, options, positional, positionals, run_verb

__all__ = [
    "ablation",
    "adaptation",
    "baxter_circle",
    "baxter_helical",
    "characters",
    "cloning",
    "convergence",
    "coreact",
    "edic",
    "force",
    "ftdcr",
    "identification",
    "inverse",
    "kuka",
    "layouts",
    "neural",
    "neural_networks",
    "panda",
    "population",
    "recorded",
    "robots",
    "run",
    "scara",
    "sensing",
    "simulated",
    "sofa",
    "sorosim",
    "tentacle",
    "wrist",
]


def run(
    study: PathLike,
    *,
    out: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyRunOutcome:
    """Run a study: record, calibrate, identify, learn, track, evaluate; ends in one report.

    As `hysteron study run`.

    Args:
        study: Study file, .toml.
        out: Folder to write to [default: out/NAME].
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "run",
        *positional(study),
        *option("--out", out),
    ]
    outcome: outcomes.StudyRunOutcome = run_verb(
        outcomes.StudyRunOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def sofa(
    *,
    out: PathLike,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudySofaOutcome:
    """Tip and tension compared with SOFA on the same mesh; a minute.

    As `hysteron study sofa`.

    Args:
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "sofa",
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudySofaOutcome = run_verb(
        outcomes.StudySofaOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def convergence(
    *,
    out: PathLike,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyConvergenceOutcome:
    """Linear and quadratic tetrahedra, finer and finer; minutes.

    As `hysteron study convergence`.

    Args:
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "convergence",
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyConvergenceOutcome = run_verb(
        outcomes.StudyConvergenceOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def sorosim(
    *,
    out: PathLike,
    data: PathLike | None = None,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudySorosimOutcome:
    """500 static shapes of a rod compared with SoRoSim; half an hour.

    As `hysteron study sorosim`.

    Args:
        data: Folder of the recordings [default: HYSTERON_DATA, or ../shared/data].
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "sorosim",
        *option("--data", data),
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudySorosimOutcome = run_verb(
        outcomes.StudySorosimOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def tentacle(
    *,
    out: PathLike,
    data: PathLike | None = None,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyTentacleOutcome:
    """14 holds of a recorded silicone tentacle, nominal and fitted parameters, residual tensions; minutes.

    As `hysteron study tentacle`.

    Args:
        data: Folder of the recordings [default: HYSTERON_DATA, or ../shared/data].
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "tentacle",
        *option("--data", data),
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyTentacleOutcome = run_verb(
        outcomes.StudyTentacleOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def ftdcr(
    *,
    out: PathLike,
    data: PathLike | None = None,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyFtdcrOutcome:
    """A recorded three-segment robot, tip on patterns that were not fitted, by fourteen methods; minutes.

    As `hysteron study ftdcr`.

    Args:
        data: Folder of the recordings [default: HYSTERON_DATA, or ../shared/data].
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "ftdcr",
        *option("--data", data),
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyFtdcrOutcome = run_verb(
        outcomes.StudyFtdcrOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def inverse(
    *,
    out: PathLike,
    data: PathLike | None = None,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyInverseOutcome:
    """Strokes of two recorded robots from their tips: regressions, a kernel, networks; an hour.

    As `hysteron study inverse`.

    Args:
        data: Folder of the recordings [default: HYSTERON_DATA, or ../shared/data].
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "inverse",
        *option("--data", data),
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyInverseOutcome = run_verb(
        outcomes.StudyInverseOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def coreact(
    *,
    out: PathLike,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyCoreactOutcome:
    """Record, identify, train and roll out on the virtual rig: five twins on test trajectories; hours.

    As `hysteron study coreact`.

    Args:
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "coreact",
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyCoreactOutcome = run_verb(
        outcomes.StudyCoreactOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def robots(
    *,
    out: PathLike,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyRobotsOutcome:
    """The twins of coreact on two other presets and ten robots of a population; an hour.

    As `hysteron study robots`.

    Args:
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "robots",
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyRobotsOutcome = run_verb(
        outcomes.StudyRobotsOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def ablation(
    *,
    out: PathLike,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyAblationOutcome:
    """The effect of each part of the chain, on three presets and ten robots of a population; half an hour or more.

    As `hysteron study ablation`.

    Args:
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "ablation",
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyAblationOutcome = run_verb(
        outcomes.StudyAblationOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def population(
    *,
    out: PathLike,
    robots: int | None = None,
    first: int | None = None,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyPopulationOutcome:
    """The whole chain on robots of a wide population, known from their recordings alone; hours.

    As `hysteron study population`.

    Args:
        robots: How many robots of the population [default: all that are left].
        first: The first robot of the population: machines can share it. Default: 1.
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "population",
        *option("--robots", robots),
        *option("--first", first),
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyPopulationOutcome = run_verb(
        outcomes.StudyPopulationOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def layouts(
    *,
    out: PathLike,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyLayoutsOutcome:
    """Fewer auxiliary tendons than the paper's 36; half an hour.

    As `hysteron study layouts`.

    Args:
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "layouts",
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyLayoutsOutcome = run_verb(
        outcomes.StudyLayoutsOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def adaptation(
    *,
    out: PathLike,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyAdaptationOutcome:
    """A robot that changes, before and after a minute of new data; half an hour.

    As `hysteron study adaptation`.

    Args:
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "adaptation",
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyAdaptationOutcome = run_verb(
        outcomes.StudyAdaptationOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def sensing(
    *,
    out: PathLike,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudySensingOutcome:
    """Tensions and pushes estimated without force sensors on two virtual robots; two hours.

    As `hysteron study sensing`.

    Args:
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "sensing",
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudySensingOutcome = run_verb(
        outcomes.StudySensingOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def edic(
    *,
    out: PathLike,
    quick: bool = False,
    repository: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyEdicOutcome:
    """Ideal paths, open loop on the virtual rig: five methods for strokes; hours.

    As `hysteron study edic`.

    Args:
        out: Folder to write to; studies of the virtual robot typical share their recordings in the folder
            typical next to it.
        quick: A small, fast version, to check that it runs.
        repository: Root of a checkout of the project, whose meshes and reference curves are read. Default: ..
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "edic",
        *option("--out", out),
        *flag("--quick", quick),
        *option("--repository", repository),
    ]
    outcome: outcomes.StudyEdicOutcome = run_verb(
        outcomes.StudyEdicOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def simulated(
    *,
    out: PathLike,
    first_seed: int | None = None,
    trajectories: int | Sequence[int] | None = None,
    products: int | None = None,
    squares: int | None = None,
    variants: str | Sequence[str] | None = None,
    seeds: int | None = None,
    hidden: int | None = None,
    activation: Literal["relu", "tanh", "softplus"] | None = None,
    epochs: int | None = None,
    polish_by: Literal["lbfgs", "levenberg-marquardt"] | None = None,
    polish: int | None = None,
    learning_rate: float | None = None,
    penalty: float | None = None,
    published: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudySimulatedOutcome:
    """Learned inverse dynamics of the simulated three-link arm, part by part of its torques (DeLaN, table 5); an hour.

    As `hysteron study simulated`.

    Args:
        out: Folder for cells, report.html and metrics.json.
        first_seed: The first seed, so that machines can share the study: put their cells into one DIR/cells.
            Default: 0.
        trajectories: Trajectories of the simulated arm to learn from, one table for each. Default: 200.
        products: Inputs are products of the sines and cosines of up to so many joints, with a linear path
            past the hidden layers; 0 for sines and cosines alone [default: 0; simulated: 3].
        squares: Squares in the kinetic energy beyond one for each joint [default: 0; simulated: 6].
        variants: Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented].
        seeds: Seeds of a row; of recorded arms, networks whose mean is taken. Default: 5.
        hidden: Units of each of the two hidden layers [default: 64; simulated: 4 with squares, else 16, 24 of
            a black-box Hamiltonian].
        activation: Activation between the layers [default: softplus; simulated: tanh].
        epochs: Epochs of Adam at most [default: 300; simulated: 3].
        polish_by: Optimiser after Adam, in double precision [default: lbfgs; simulated: levenberg-marquardt].
        polish: Steps of it at most; 0 for none [default: 300; simulated: 150].
        learning_rate: Step size of Adam at the start [default: 0.005; published: 0.0001].
        penalty: Weight of the torque beyond that of a rigid body, in (10). Default: 0.1.
        published: As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "simulated",
        *option("--out", out),
        *option("--first-seed", first_seed),
        *options("--trajectories", trajectories, ","),
        *option("--products", products),
        *option("--squares", squares),
        *options("--variants", variants, ","),
        *option("--seeds", seeds),
        *option("--hidden", hidden),
        *option("--activation", activation),
        *option("--epochs", epochs),
        *option("--polish-by", polish_by),
        *option("--polish", polish),
        *option("--learning-rate", learning_rate),
        *option("--penalty", penalty),
        *flag("--published", published),
    ]
    outcome: outcomes.StudySimulatedOutcome = run_verb(
        outcomes.StudySimulatedOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def characters(
    *,
    data: PathLike,
    out: PathLike,
    first_seed: int | None = None,
    trajectories: int | Sequence[int] | None = None,
    products: int | None = None,
    squares: int | None = None,
    variants: str | Sequence[str] | None = None,
    seeds: int | None = None,
    hidden: int | None = None,
    activation: Literal["relu", "tanh", "softplus"] | None = None,
    epochs: int | None = None,
    polish_by: Literal["lbfgs", "levenberg-marquardt"] | None = None,
    polish: int | None = None,
    learning_rate: float | None = None,
    penalty: float | None = None,
    published: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyCharactersOutcome:
    """Learned inverse dynamics of a simulated arm that writes characters.

    As `hysteron study characters`.

    Args:
        data: Folder of public recordings, with delan-characters/.
        out: Folder for cells, report.html and metrics.json.
        first_seed: The first seed, so that machines can share the study: put their cells into one DIR/cells.
            Default: 0.
        trajectories: Trajectories of the simulated arm to learn from, one table for each. Default: 200.
        products: Inputs are products of the sines and cosines of up to so many joints, with a linear path
            past the hidden layers; 0 for sines and cosines alone [default: 0; simulated: 3].
        squares: Squares in the kinetic energy beyond one for each joint [default: 0; simulated: 6].
        variants: Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented].
        seeds: Seeds of a row; of recorded arms, networks whose mean is taken. Default: 5.
        hidden: Units of each of the two hidden layers [default: 64; simulated: 4 with squares, else 16, 24 of
            a black-box Hamiltonian].
        activation: Activation between the layers [default: softplus; simulated: tanh].
        epochs: Epochs of Adam at most [default: 300; simulated: 3].
        polish_by: Optimiser after Adam, in double precision [default: lbfgs; simulated: levenberg-marquardt].
        polish: Steps of it at most; 0 for none [default: 300; simulated: 150].
        learning_rate: Step size of Adam at the start [default: 0.005; published: 0.0001].
        penalty: Weight of the torque beyond that of a rigid body, in (10). Default: 0.1.
        published: As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "characters",
        *option("--data", data),
        *option("--out", out),
        *option("--first-seed", first_seed),
        *options("--trajectories", trajectories, ","),
        *option("--products", products),
        *option("--squares", squares),
        *options("--variants", variants, ","),
        *option("--seeds", seeds),
        *option("--hidden", hidden),
        *option("--activation", activation),
        *option("--epochs", epochs),
        *option("--polish-by", polish_by),
        *option("--polish", polish),
        *option("--learning-rate", learning_rate),
        *option("--penalty", penalty),
        *flag("--published", published),
    ]
    outcome: outcomes.StudyCharactersOutcome = run_verb(
        outcomes.StudyCharactersOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def baxter_circle(
    *,
    data: PathLike,
    out: PathLike,
    stride: int | None = None,
    features: int | None = None,
    variants: str | Sequence[str] | None = None,
    seeds: int | None = None,
    hidden: int | None = None,
    activation: Literal["relu", "tanh", "softplus"] | None = None,
    epochs: int | None = None,
    polish_by: Literal["lbfgs", "levenberg-marquardt"] | None = None,
    polish: int | None = None,
    learning_rate: float | None = None,
    penalty: float | None = None,
    published: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyBaxterCircleOutcome:
    """Learned inverse dynamics of recorded arms: Baxter draws circles; a quarter of an hour.

    As `hysteron study baxter-circle`.

    Args:
        data: Folder of public recordings, with baxter/, kuka-lwr4/, panda-gaz/.
        out: Folder for cells, report.html and metrics.json.
        stride: Every so many samples of a recorded arm are used. Default: 2.
        features: Fourier features of the simple models. Default: 1000.
        variants: Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented].
        seeds: Seeds of a row; of recorded arms, networks whose mean is taken. Default: 5.
        hidden: Units of each of the two hidden layers [default: 64; simulated: 4 with squares, else 16, 24 of
            a black-box Hamiltonian].
        activation: Activation between the layers [default: softplus; simulated: tanh].
        epochs: Epochs of Adam at most [default: 300; simulated: 3].
        polish_by: Optimiser after Adam, in double precision [default: lbfgs; simulated: levenberg-marquardt].
        polish: Steps of it at most; 0 for none [default: 300; simulated: 150].
        learning_rate: Step size of Adam at the start [default: 0.005; published: 0.0001].
        penalty: Weight of the torque beyond that of a rigid body, in (10). Default: 0.1.
        published: As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "baxter-circle",
        *option("--data", data),
        *option("--out", out),
        *option("--stride", stride),
        *option("--features", features),
        *options("--variants", variants, ","),
        *option("--seeds", seeds),
        *option("--hidden", hidden),
        *option("--activation", activation),
        *option("--epochs", epochs),
        *option("--polish-by", polish_by),
        *option("--polish", polish),
        *option("--learning-rate", learning_rate),
        *option("--penalty", penalty),
        *flag("--published", published),
    ]
    outcome: outcomes.StudyBaxterCircleOutcome = run_verb(
        outcomes.StudyBaxterCircleOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def baxter_helical(
    *,
    data: PathLike,
    out: PathLike,
    stride: int | None = None,
    features: int | None = None,
    variants: str | Sequence[str] | None = None,
    seeds: int | None = None,
    hidden: int | None = None,
    activation: Literal["relu", "tanh", "softplus"] | None = None,
    epochs: int | None = None,
    polish_by: Literal["lbfgs", "levenberg-marquardt"] | None = None,
    polish: int | None = None,
    learning_rate: float | None = None,
    penalty: float | None = None,
    published: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyBaxterHelicalOutcome:
    """Learned inverse dynamics of recorded arms: Baxter draws helices; a quarter of an hour.

    As `hysteron study baxter-helical`.

    Args:
        data: Folder of public recordings, with baxter/, kuka-lwr4/, panda-gaz/.
        out: Folder for cells, report.html and metrics.json.
        stride: Every so many samples of a recorded arm are used. Default: 2.
        features: Fourier features of the simple models. Default: 1000.
        variants: Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented].
        seeds: Seeds of a row; of recorded arms, networks whose mean is taken. Default: 5.
        hidden: Units of each of the two hidden layers [default: 64; simulated: 4 with squares, else 16, 24 of
            a black-box Hamiltonian].
        activation: Activation between the layers [default: softplus; simulated: tanh].
        epochs: Epochs of Adam at most [default: 300; simulated: 3].
        polish_by: Optimiser after Adam, in double precision [default: lbfgs; simulated: levenberg-marquardt].
        polish: Steps of it at most; 0 for none [default: 300; simulated: 150].
        learning_rate: Step size of Adam at the start [default: 0.005; published: 0.0001].
        penalty: Weight of the torque beyond that of a rigid body, in (10). Default: 0.1.
        published: As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "baxter-helical",
        *option("--data", data),
        *option("--out", out),
        *option("--stride", stride),
        *option("--features", features),
        *options("--variants", variants, ","),
        *option("--seeds", seeds),
        *option("--hidden", hidden),
        *option("--activation", activation),
        *option("--epochs", epochs),
        *option("--polish-by", polish_by),
        *option("--polish", polish),
        *option("--learning-rate", learning_rate),
        *option("--penalty", penalty),
        *flag("--published", published),
    ]
    outcome: outcomes.StudyBaxterHelicalOutcome = run_verb(
        outcomes.StudyBaxterHelicalOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def kuka(
    *,
    data: PathLike,
    out: PathLike,
    stride: int | None = None,
    features: int | None = None,
    variants: str | Sequence[str] | None = None,
    seeds: int | None = None,
    hidden: int | None = None,
    activation: Literal["relu", "tanh", "softplus"] | None = None,
    epochs: int | None = None,
    polish_by: Literal["lbfgs", "levenberg-marquardt"] | None = None,
    polish: int | None = None,
    learning_rate: float | None = None,
    penalty: float | None = None,
    published: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyKukaOutcome:
    """Learned inverse dynamics of recorded arms: KUKA LWR4+; a quarter of an hour.

    As `hysteron study kuka`.

    Args:
        data: Folder of public recordings, with baxter/, kuka-lwr4/, panda-gaz/.
        out: Folder for cells, report.html and metrics.json.
        stride: Every so many samples of a recorded arm are used. Default: 2.
        features: Fourier features of the simple models. Default: 1000.
        variants: Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented].
        seeds: Seeds of a row; of recorded arms, networks whose mean is taken. Default: 5.
        hidden: Units of each of the two hidden layers [default: 64; simulated: 4 with squares, else 16, 24 of
            a black-box Hamiltonian].
        activation: Activation between the layers [default: softplus; simulated: tanh].
        epochs: Epochs of Adam at most [default: 300; simulated: 3].
        polish_by: Optimiser after Adam, in double precision [default: lbfgs; simulated: levenberg-marquardt].
        polish: Steps of it at most; 0 for none [default: 300; simulated: 150].
        learning_rate: Step size of Adam at the start [default: 0.005; published: 0.0001].
        penalty: Weight of the torque beyond that of a rigid body, in (10). Default: 0.1.
        published: As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "kuka",
        *option("--data", data),
        *option("--out", out),
        *option("--stride", stride),
        *option("--features", features),
        *options("--variants", variants, ","),
        *option("--seeds", seeds),
        *option("--hidden", hidden),
        *option("--activation", activation),
        *option("--epochs", epochs),
        *option("--polish-by", polish_by),
        *option("--polish", polish),
        *option("--learning-rate", learning_rate),
        *option("--penalty", penalty),
        *flag("--published", published),
    ]
    outcome: outcomes.StudyKukaOutcome = run_verb(
        outcomes.StudyKukaOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def panda(
    *,
    data: PathLike,
    out: PathLike,
    stride: int | None = None,
    features: int | None = None,
    variants: str | Sequence[str] | None = None,
    seeds: int | None = None,
    hidden: int | None = None,
    activation: Literal["relu", "tanh", "softplus"] | None = None,
    epochs: int | None = None,
    polish_by: Literal["lbfgs", "levenberg-marquardt"] | None = None,
    polish: int | None = None,
    learning_rate: float | None = None,
    penalty: float | None = None,
    published: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyPandaOutcome:
    """Learned inverse dynamics of recorded arms: Panda; a quarter of an hour.

    As `hysteron study panda`.

    Args:
        data: Folder of public recordings, with baxter/, kuka-lwr4/, panda-gaz/.
        out: Folder for cells, report.html and metrics.json.
        stride: Every so many samples of a recorded arm are used. Default: 2.
        features: Fourier features of the simple models. Default: 1000.
        variants: Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented].
        seeds: Seeds of a row; of recorded arms, networks whose mean is taken. Default: 5.
        hidden: Units of each of the two hidden layers [default: 64; simulated: 4 with squares, else 16, 24 of
            a black-box Hamiltonian].
        activation: Activation between the layers [default: softplus; simulated: tanh].
        epochs: Epochs of Adam at most [default: 300; simulated: 3].
        polish_by: Optimiser after Adam, in double precision [default: lbfgs; simulated: levenberg-marquardt].
        polish: Steps of it at most; 0 for none [default: 300; simulated: 150].
        learning_rate: Step size of Adam at the start [default: 0.005; published: 0.0001].
        penalty: Weight of the torque beyond that of a rigid body, in (10). Default: 0.1.
        published: As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "panda",
        *option("--data", data),
        *option("--out", out),
        *option("--stride", stride),
        *option("--features", features),
        *options("--variants", variants, ","),
        *option("--seeds", seeds),
        *option("--hidden", hidden),
        *option("--activation", activation),
        *option("--epochs", epochs),
        *option("--polish-by", polish_by),
        *option("--polish", polish),
        *option("--learning-rate", learning_rate),
        *option("--penalty", penalty),
        *flag("--published", published),
    ]
    outcome: outcomes.StudyPandaOutcome = run_verb(
        outcomes.StudyPandaOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def recorded(
    *,
    data: PathLike,
    out: PathLike,
    stride: int | None = None,
    features: int | None = None,
    variants: str | Sequence[str] | None = None,
    seeds: int | None = None,
    hidden: int | None = None,
    activation: Literal["relu", "tanh", "softplus"] | None = None,
    epochs: int | None = None,
    polish_by: Literal["lbfgs", "levenberg-marquardt"] | None = None,
    polish: int | None = None,
    learning_rate: float | None = None,
    penalty: float | None = None,
    published: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyRecordedOutcome:
    """Learned inverse dynamics of every recorded arm that is below --data, each with its table; an hour.

    As `hysteron study recorded`.

    Args:
        data: Folder of public recordings, with baxter/, kuka-lwr4/, panda-gaz/.
        out: Folder for cells, report.html and metrics.json.
        stride: Every so many samples of a recorded arm are used. Default: 2.
        features: Fourier features of the simple models. Default: 1000.
        variants: Models to learn [default: all of them; of recorded arms feed-forward, friction, augmented].
        seeds: Seeds of a row; of recorded arms, networks whose mean is taken. Default: 5.
        hidden: Units of each of the two hidden layers [default: 64; simulated: 4 with squares, else 16, 24 of
            a black-box Hamiltonian].
        activation: Activation between the layers [default: softplus; simulated: tanh].
        epochs: Epochs of Adam at most [default: 300; simulated: 3].
        polish_by: Optimiser after Adam, in double precision [default: lbfgs; simulated: levenberg-marquardt].
        polish: Steps of it at most; 0 for none [default: 300; simulated: 150].
        learning_rate: Step size of Adam at the start [default: 0.005; published: 0.0001].
        penalty: Weight of the torque beyond that of a rigid body, in (10). Default: 0.1.
        published: As published: SI units, the plain error, 512 samples a step at a constant rate of 1e-4.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "recorded",
        *option("--data", data),
        *option("--out", out),
        *option("--stride", stride),
        *option("--features", features),
        *options("--variants", variants, ","),
        *option("--seeds", seeds),
        *option("--hidden", hidden),
        *option("--activation", activation),
        *option("--epochs", epochs),
        *option("--polish-by", polish_by),
        *option("--polish", polish),
        *option("--learning-rate", learning_rate),
        *option("--penalty", penalty),
        *flag("--published", published),
    ]
    outcome: outcomes.StudyRecordedOutcome = run_verb(
        outcomes.StudyRecordedOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def scara(
    *,
    out: PathLike,
    seeds: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyScaraOutcome:
    """External torques of a simulated SCARA: friction, momentum observers, collisions (Wan et al. 2026); a quarter of an hour.

    As `hysteron study scara`.

    Args:
        out: Folder for cells, report.html and metrics.json.
        seeds: Trials, each with 48 s of contact and 15 min of collisions. Default: 5.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "scara",
        *option("--out", out),
        *option("--seeds", seeds),
    ]
    outcome: outcomes.StudyScaraOutcome = run_verb(
        outcomes.StudyScaraOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def wrist(
    *,
    out: PathLike,
    seeds: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyWristOutcome:
    """Interaction torques of a simulated wrist exoskeleton, by nine methods (Saadatzi et al. 2019); a quarter of an hour.

    As `hysteron study wrist`.

    Args:
        out: Folder for cells, report.html and metrics.json.
        seeds: Noise seeds of every cell. Default: 5.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "wrist",
        *option("--out", out),
        *option("--seeds", seeds),
    ]
    outcome: outcomes.StudyWristOutcome = run_verb(
        outcomes.StudyWristOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def identification(
    *,
    out: PathLike,
    data: PathLike | None = None,
    seeds: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyIdentificationOutcome:
    """Friction and bodies of arms by every method of identification; minutes.

    As `hysteron study identification`.

    Args:
        data: Folder of public recordings, with friction-franka/ [default: simulated arms alone].
        out: Folder for cells, report.html and metrics.json.
        seeds: Noise seeds. Default: 5.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "identification",
        *option("--data", data),
        *option("--out", out),
        *option("--seeds", seeds),
    ]
    outcome: outcomes.StudyIdentificationOutcome = run_verb(
        outcomes.StudyIdentificationOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def force(
    *,
    out: PathLike,
    data: PathLike | None = None,
    seeds: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyForceOutcome:
    """Force at the tip of an arm without a sensor, by the classical methods (Dou et al., table VI); a quarter of an hour.

    As `hysteron study force`.

    Args:
        data: Folder of NAD (CSV), or of recordings by `hysteron arm generate` [default: the virtual arm].
        out: Folder for cells, report.html and metrics.json.
        seeds: Individual virtual arms. Default: 5.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "force",
        *option("--data", data),
        *option("--out", out),
        *option("--seeds", seeds),
    ]
    outcome: outcomes.StudyForceOutcome = run_verb(
        outcomes.StudyForceOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def neural(
    *,
    out: PathLike,
    data: PathLike | None = None,
    seeds: int | None = None,
    first_seed: int | None = None,
    quick: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyNeuralOutcome:
    """Actuators learned from telemetry, compared with published tables and simple baselines (NeuralActuator); hours.

    As `hysteron study neural`.

    Args:
        data: Folder of NAD (CSV), or of recordings by `hysteron arm generate` [default: the virtual arm].
        out: Folder for cells, report.html and metrics.json.
        seeds: Seeds of networks. Default: 5.
        first_seed: The first seed, so that machines can share the study: put their cells into one DIR/cells.
            Default: 0.
        quick: One seed of small networks, minutes for all cells.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "neural",
        *option("--data", data),
        *option("--out", out),
        *option("--seeds", seeds),
        *option("--first-seed", first_seed),
        *flag("--quick", quick),
    ]
    outcome: outcomes.StudyNeuralOutcome = run_verb(
        outcomes.StudyNeuralOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def neural_networks(
    *,
    out: PathLike,
    data: PathLike | None = None,
    seeds: int | None = None,
    first_seed: int | None = None,
    quick: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyNeuralNetworksOutcome:
    """Networks in the loop alone, of equal size: the ablation of the study neural (table X); hours.

    As `hysteron study neural-networks`.

    Args:
        data: Folder of NAD (CSV), or of recordings by `hysteron arm generate` [default: the virtual arm].
        out: Folder for cells, report.html and metrics.json.
        seeds: Seeds of networks. Default: 5.
        first_seed: The first seed, so that machines can share the study: put their cells into one DIR/cells.
            Default: 0.
        quick: One seed of small networks, minutes for all cells.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "neural-networks",
        *option("--data", data),
        *option("--out", out),
        *option("--seeds", seeds),
        *option("--first-seed", first_seed),
        *flag("--quick", quick),
    ]
    outcome: outcomes.StudyNeuralNetworksOutcome = run_verb(
        outcomes.StudyNeuralNetworksOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def cloning(
    *,
    out: PathLike,
    seeds: int | None = None,
    actuator: PathLike | None = None,
    quick: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.StudyCloningOutcome:
    """Policies that handle an object of unknown mass on the virtual arm, cloned with and without a force; minutes.

    As `hysteron study cloning`.

    Args:
        out: Folder for report.html and metrics.json.
        seeds: Policies of a row. Default: 5.
        actuator: Actuator by hysteron arm fit neural --sensing observer that estimates the force; without one
            that row is skipped.
        quick: One policy of a row and twelve trials.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "study", "cloning",
        *option("--out", out),
        *option("--seeds", seeds),
        *option("--actuator", actuator),
        *flag("--quick", quick),
    ]
    outcome: outcomes.StudyCloningOutcome = run_verb(
        outcomes.StudyCloningOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome
