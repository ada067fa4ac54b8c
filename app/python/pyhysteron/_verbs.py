# Made by `cargo run --release -p hysteron-python --example generate_sources`; do not edit.
"""Verbs of the program."""

# ruff: noqa
from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from . import outcomes
from ._verb import PathLike, flag, option, options, positional, positionals, run_verb

__all__ = [
    "adapt",
    "check",
    "command",
    "demo",
    "evaluate",
    "fit_material",
    "fit_residual",
    "fit_sensor",
    "generate",
    "identify",
    "identify_servo",
    "import_",
    "mesh",
    "reach",
    "record",
    "reduce",
    "sense",
    "simulate",
    "target",
    "track",
    "train",
]


def simulate(
    scene: PathLike,
    *,
    strokes: PathLike,
    out: PathLike,
    residual: PathLike | None = None,
    reduced: PathLike | None = None,
    exact_every: int | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    vtu: PathLike | None = None,
    vtu_every: int | None = None,
    from_: PathLike | None = None,
    resume: bool = False,
    save_state: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.SimulateOutcome:
    """Simulate a robot that follows recorded strokes.

    Every sample of the recording is one quasi-static step: the shape in which body, tendons and loads are in
    balance under the commanded strokes, found from the shape before.

    As `hysteron simulate`.

    Args:
        scene: Scene file of the robot (scene.toml).
        strokes: Recording with the strokes to follow, .parquet or .csv.
        residual: Checkpoint by hysteron fit-residual: its network drives the auxiliary tendons, from the
            strokes and the twin's tip. Where recordings were left out in its training, how far the robot's
            tip may be off the twin's is told, drawn and written too, as tip_band_m.
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        exact_every: With a chain: make every N-th step by the finite elements too, and say how far the chain
            is off.
        out: Recording to write, .parquet or .csv.
        figures: Folder for figures, report.html and metrics.json.
        png: Write each figure as .png too.
        vtu: Folder for a ParaView series (open robot.pvd): body and tendons.
        vtu_every: Every how many samples the series has a picture [default: 200 pictures in all].
        from_: Start from this state of the same scene instead of from rest.
        resume: Resume the run of this OUT that failed or was interrupted.
        save_state: Save the last state here, for --from.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "simulate",
        *positional(scene),
        *option("--strokes", strokes),
        *option("--residual", residual),
        *option("--reduced", reduced),
        *option("--exact-every", exact_every),
        *option("--out", out),
        *option("--figures", figures),
        *flag("--png", png),
        *option("--vtu", vtu),
        *option("--vtu-every", vtu_every),
        *option("--from", from_),
        *flag("--resume", resume),
        *option("--save-state", save_state),
    ]
    outcome: outcomes.SimulateOutcome = run_verb(
        outcomes.SimulateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def reach(
    scene: PathLike,
    *,
    goals: PathLike,
    out: PathLike,
    tolerance_mm: float | None = None,
    reduced: PathLike | None = None,
    exact_every: int | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    vtu: PathLike | None = None,
    vtu_every: int | None = None,
    from_: PathLike | None = None,
    resume: bool = False,
    save_state: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ReachOutcome:
    """Find the strokes that bring the tip to recorded goals.

    The inverse of `simulate`: for every sample, the strokes whose equilibrium has the tip at the goal, found
    from the shape before.

    As `hysteron reach`.

    Args:
        scene: Scene file of the robot (scene.toml).
        goals: Recording with the tip positions to reach, .parquet or .csv.
        tolerance_mm: Distance that counts as reached. Default: 0.01.
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        exact_every: With a chain: make every N-th step by the finite elements too, and say how far the chain
            is off.
        out: Recording to write, .parquet or .csv.
        figures: Folder for figures, report.html and metrics.json.
        png: Write each figure as .png too.
        vtu: Folder for a ParaView series (open robot.pvd): body and tendons.
        vtu_every: Every how many samples the series has a picture [default: 200 pictures in all].
        from_: Start from this state of the same scene instead of from rest.
        resume: Resume the run of this OUT that failed or was interrupted.
        save_state: Save the last state here, for --from.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "reach",
        *positional(scene),
        *option("--goals", goals),
        *option("--tolerance-mm", tolerance_mm),
        *option("--reduced", reduced),
        *option("--exact-every", exact_every),
        *option("--out", out),
        *option("--figures", figures),
        *flag("--png", png),
        *option("--vtu", vtu),
        *option("--vtu-every", vtu_every),
        *option("--from", from_),
        *flag("--resume", resume),
        *option("--save-state", save_state),
    ]
    outcome: outcomes.ReachOutcome = run_verb(
        outcomes.ReachOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def mesh(
    *,
    out: PathLike,
    length_mm: float | None = None,
    outer_diameter_mm: float | None = None,
    tip_diameter_mm: float | None = None,
    profile: str | Sequence[str] | None = None,
    bore_diameter_mm: float | None = None,
    channels: int | None = None,
    channel_diameter_mm: float | None = None,
    channel_radius_mm: float | None = None,
    edge_mm: float | None = None,
    layers: int | None = None,
    end_edge_mm: float | None = None,
    circle_areas: bool = False,
    outer_sides: int | None = None,
    bore_sides: int | None = None,
    channel_sides: int | None = None,
    quadratic: bool = False,
    binary: bool = False,
    vtu: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.MeshOutcome:
    """Mesh a tube or a tapered body with tendon channels.

    Needs its measures; writes a Gmsh file (MSH 4.1, millimetres) of tetrahedra.

    As `hysteron mesh`.

    Args:
        length_mm: Length of the body.
        outer_diameter_mm: Outer diameter at the base.
        tip_diameter_mm: Outer diameter at the tip [default: as at the base].
        profile: Several links: height and outer diameter of every corner in mm, from the base up, as
            Z:D,Z:D,...
        bore_diameter_mm: Diameter of the central bore at the base; 0 for a solid body. Default: 0.
        channels: Number of tendon channels, evenly spaced, the first on the x axis. Default: 0.
        channel_diameter_mm: Diameter of every channel at the base.
        channel_radius_mm: Distance of the channels from the axis at the base.
        edge_mm: Length of an edge, roughly: sets layers and sides that are not given.
        layers: Number of layers along the body.
        end_edge_mm: Height of the layers where a link of the profile ends, which then grow away from there: a
            third of the radius of the anchor of the tendons that end there [default: as the other layers].
        circle_areas: Give every polygon the area of its circle: the corners then lie outside the circle, the
            middles of the sides inside.
        outer_sides: Sides of the outer polygon [default: by edge length, else 16].
        bore_sides: Sides of the bore [default: by edge length, else 8].
        channel_sides: Sides of every channel [default: by edge length, else 4].
        quadratic: Ten-node tetrahedra.
        binary: Write the numbers as bytes instead of text.
        out: Mesh file to write (.msh).
        vtu: Write the mesh for ParaView too (.vtu).
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "mesh",
        *option("--length-mm", length_mm),
        *option("--outer-diameter-mm", outer_diameter_mm),
        *option("--tip-diameter-mm", tip_diameter_mm),
        *options("--profile", profile, ","),
        *option("--bore-diameter-mm", bore_diameter_mm),
        *option("--channels", channels),
        *option("--channel-diameter-mm", channel_diameter_mm),
        *option("--channel-radius-mm", channel_radius_mm),
        *option("--edge-mm", edge_mm),
        *option("--layers", layers),
        *option("--end-edge-mm", end_edge_mm),
        *flag("--circle-areas", circle_areas),
        *option("--outer-sides", outer_sides),
        *option("--bore-sides", bore_sides),
        *option("--channel-sides", channel_sides),
        *flag("--quadratic", quadratic),
        *flag("--binary", binary),
        *option("--out", out),
        *option("--vtu", vtu),
    ]
    outcome: outcomes.MeshOutcome = run_verb(
        outcomes.MeshOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def reduce(
    scene: PathLike,
    *,
    out: PathLike,
    count: int | None = None,
    stroke_mm: float | None = None,
    tension_n: float | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ReduceOutcome:
    """Reduce the body of a robot to a chain of condensed sections.

    The body is cut across its axis into sections of some 0.4 diameters; each becomes a quadratic and cubic
    energy of its strain, condensed from the finite elements without any training. The chain is then compared
    with the finite elements under random strokes; the errors are printed and stored in the file.

    As `hysteron reduce`.

    Args:
        scene: Scene file of the robot (scene.toml).
        count: Equilibria of the mesh that the chain is compared with. Default: 20.
        stroke_mm: Largest stroke of the comparison, either way, within the bounds of the scene [default: 7.5
            % of the longest tendon].
        tension_n: Largest tension of auxiliary tendons in the comparison, either way, within the bounds of
            the scene. Default: 10.
        out: Chain to write, .json; for --reduced, or [reduced] of the scene.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "reduce",
        *positional(scene),
        *option("--count", count),
        *option("--stroke-mm", stroke_mm),
        *option("--tension-n", tension_n),
        *option("--out", out),
    ]
    outcome: outcomes.ReduceOutcome = run_verb(
        outcomes.ReduceOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def check(
    files: PathLike | Sequence[PathLike],
    *,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.CheckOutcome:
    """Check a scene with its mesh, or recordings.

    Of a scene: the quality of the mesh, every tendon with its length and how far its points lie outside the
    body, and the size of the equations. Of recordings: one table of suspicious and impossible data, such as
    units, frozen or copied channels, gaps, spikes, delays and too little motion; exit code 2 for impossible
    data. Recordings next to a scene are compared with its body too.

    As `hysteron check`.

    Args:
        files: Scene file (scene.toml), recordings (.parquet, .csv, .journal) or folders of them.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "check",
        *positionals(files),
    ]
    outcome: outcomes.CheckOutcome = run_verb(
        outcomes.CheckOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def record(
    *,
    rig: PathLike,
    out: PathLike,
    plan: str | None = None,
    strokes: PathLike | Sequence[PathLike] | None = None,
    only: str | Sequence[str] | None = None,
    calibration: PathLike | None = None,
    seed: int | None = None,
    feedback: bool = False,
    tip_force: PathLike | None = None,
    sensor: PathLike | None = None,
    scene: PathLike | None = None,
    residual: PathLike | None = None,
    stop_on_contact: bool = False,
    tension_max: float | None = None,
    baseline: PathLike | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.RecordOutcome:
    """Run a plan on a rig and record it.

    As `hysteron record`.

    Args:
        rig: Rig file, or virtual:PRESET.
        plan: Plan file (.toml), or the name of a built-in plan.
        strokes: Strokes to run instead of a plan: recordings with stroke_1_m, .., or folders of them.
        out: Folder for the recordings; for a single trajectory also a file, .parquet or .csv.
        only: Only these trajectories of the plan, by name.
        calibration: Calibration [default: the file that the rig file names; a virtual rig calibrates itself].
        seed: Seed of a virtual rig's noise and of the initial positions of its servos. Default: 1.
        feedback: Correct the strokes while they are run, by the tip that the tracker measures: slowly,
            towards the path that --strokes is for (hysteron track --feedback writes such strokes).
        tip_force: Force on a virtual rig's tip over time: a recording of tip_force_x_n, tip_force_y_n,
            tip_force_z_n, in the robot's frame; true tensions and force are then recorded too.
        sensor: Force sensor by hysteron fit-sensor: contacts and tensions are estimated while the robot
            moves.
        scene: Scene that the sensor was fitted with.
        residual: Residual network that the sensor was fitted with.
        stop_on_contact: End the recording at a contact: slowly back to rest.
        tension_max: End the recording, torque off, where the estimated tension of a tendon is larger.
        baseline: State of the healthy servos as a baseline: metrics.json of an earlier record or track, or
            the output of hysteron identify-servo.
        figures: Folder for figures, report.html and metrics.json [default: OUT, where it is a folder].
        png: Write each figure as .png too.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "record",
        *option("--rig", rig),
        *option("--plan", plan),
        *options("--strokes", strokes, None),
        *option("--out", out),
        *options("--only", only, ","),
        *option("--calibration", calibration),
        *option("--seed", seed),
        *flag("--feedback", feedback),
        *option("--tip-force", tip_force),
        *option("--sensor", sensor),
        *option("--scene", scene),
        *option("--residual", residual),
        *flag("--stop-on-contact", stop_on_contact),
        *option("--tension-max", tension_max),
        *option("--baseline", baseline),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.RecordOutcome = run_verb(
        outcomes.RecordOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def import_(
    sources: PathLike | Sequence[PathLike],
    *,
    out: PathLike | None = None,
    map: str | None = None,
    propose: PathLike | Literal[True] | None = None,
    episodes: str | None = None,
    rate: float | None = None,
    where: str | None = None,
    leave_out_bad_rows: bool = False,
    accept_units: bool = False,
    model: str | None = None,
    fix_base: bool = False,
    arg: str | Sequence[str] | None = None,
    drive: str | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.ImportOutcome:
    """Import recordings of a tendon robot or of an arm from files of other programs.

    As `hysteron import`.

    Args:
        sources: Table, log or folder of lists; further ones are joined to the rows of the first.
        out: Where the recording goes, .csv or .parquet; with episodes OUT-001, OUT-002, ...
        map: Meaning of the columns: a file of TOML, a built-in name, or "tip_x_mm=X; stroke_*_mm=cmd*"
            [default: by the names of the columns].
        propose: Write a map to edit, from names, units and ranges, to a file or the console, and import
            nothing.
        episodes: Column with the number of the episode: a recording for each.
        rate: Rate to resample to [default: the file's own].
        where: Only rows in which a column has this value.
        leave_out_bad_rows: Skip rows that cannot be read, up to a tenth of all, and mark the gap.
        accept_units: Accept numbers that look as if they had another unit.
        model: Arm whose joints these are: a file of URDF or MJCF, or a built-in name.
        fix_base: Hold a robot that floats: its base and all free joints stay where the file puts them.
        arg: Value of an argument of a robot file that is xacro; can be given several times.
        drive: Compute missing currents by the voltage equation of this drive, a name or a file of TOML, which
            every joint has.
        figures: Folder of the page that shows every channel.
        png: Figures as PNG too.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "import",
        *positionals(sources),
        *option("--out", out),
        *option("--map", map),
        *(flag("--propose", True) if propose is True else option("--propose", propose)),
        *option("--episodes", episodes),
        *option("--rate", rate),
        *option("--where", where),
        *flag("--leave-out-bad-rows", leave_out_bad_rows),
        *flag("--accept-units", accept_units),
        *option("--model", model),
        *flag("--fix-base", fix_base),
        *options("--arg", arg, None),
        *option("--drive", drive),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.ImportOutcome = run_verb(
        outcomes.ImportOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def fit_material(
    scene: PathLike,
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    reduced: PathLike | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    fit: str | Sequence[str] | None = None,
    fit_file: PathLike | None = None,
    role: str | None = None,
    step_mm: float | None = None,
    every_mm: float | None = None,
    steps: int | None = None,
    tension_max_n: float | None = None,
    huber_mm: float | None = None,
    frame: Literal["scene", "trust", "fit"] | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.FitMaterialOutcome:
    """Fit modulus, zero offsets and the like to recordings.

    Finds the parameters with which the twin's tip comes nearest to the measured one, with standard errors.

    As `hysteron fit-material`.

    Args:
        scene: Scene file of the robot (scene.toml).
        recordings: Recordings with commands and tip, or folders of them.
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        out: Scene file to write.
        figures: Folder for figures, report.html and metrics.json.
        png: Write each figure as .png too.
        fit: Parameters to fit, by name. Default: youngs_modulus, zero, compliance.
        fit_file: File with the parameters to fit and their bounds, in place of --fit.
        role: Take only recordings made for this: training, validation or test.
        step_mm: Step through samples between which a stroke (or, under tension, the tip) moves at most so
            far; samples where a stroke turns back are among them. Default: 0.3.
        every_mm: Compare the tip where a stroke has moved so far since it was compared last. Default: 0.2.
        steps: Most steps of an evaluation, shared evenly by the recordings: of each, the beginning. Default:
            2000.
        tension_max_n: Largest tension that the drives can make [default: tension_max_n of the scene]; what
            needs more than four fifths of it fits the worse.
        huber_mm: Error of a coordinate from which on it counts linearly rather than squared.
        frame: Frame of the measured tip: the scene's (a tip that rests elsewhere is refused), the scene's
            wherever the tip rests, or one to be found. Default: scene.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "fit-material",
        *positional(scene),
        *positionals(recordings),
        *option("--reduced", reduced),
        *option("--out", out),
        *option("--figures", figures),
        *flag("--png", png),
        *options("--fit", fit, ","),
        *option("--fit-file", fit_file),
        *option("--role", role),
        *option("--step-mm", step_mm),
        *option("--every-mm", every_mm),
        *option("--steps", steps),
        *option("--tension-max-n", tension_max_n),
        *option("--huber-mm", huber_mm),
        *option("--frame", frame),
    ]
    outcome: outcomes.FitMaterialOutcome = run_verb(
        outcomes.FitMaterialOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def identify(
    scene: PathLike,
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    reduced: PathLike | None = None,
    regularisation: float | None = None,
    orientation_mm: float | None = None,
    rounds: int | None = None,
    residual: PathLike | None = None,
    skip_bad: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.IdentifyOutcome:
    """Find the auxiliary tendons' strokes that make the twin follow measured tips (CoReAct).

    As `hysteron identify`.

    Args:
        scene: Scene file of the robot (scene.toml), with auxiliary tendons.
        recordings: Recordings, .parquet or .csv, or folders of them.
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        out: Folder to write to.
        regularisation: Weight of the squared strokes, over the mean squared effect of a stroke on the tip.
            Default: 0.0001.
        orientation_mm: Match the tip's orientation too, where recorded: a radian counts as much as this
            distance.
        rounds: Rounds of QP and simulation per sample at most. Default: 2.
        residual: Let this network choose the strokes, instead of QPs.
        skip_bad: Skip recordings that cannot be used, with a warning, instead of stopping.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "identify",
        *positional(scene),
        *positionals(recordings),
        *option("--reduced", reduced),
        *option("--out", out),
        *option("--regularisation", regularisation),
        *option("--orientation-mm", orientation_mm),
        *option("--rounds", rounds),
        *option("--residual", residual),
        *flag("--skip-bad", skip_bad),
    ]
    outcome: outcomes.IdentifyOutcome = run_verb(
        outcomes.IdentifyOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def fit_residual(
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    design: Literal["recurrent", "paper"] | None = None,
    held_out: str | Sequence[str] | None = None,
    epochs: int | None = None,
    hidden: int | None = None,
    members: int | None = None,
    feedback: bool = False,
    figures: PathLike | None = None,
    stride: int | None = None,
    batch: int | None = None,
    seed: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.FitResidualOutcome:
    """Train the residual network on identified recordings (CoReAct).

    As `hysteron fit-residual`.

    Args:
        recordings: Folders written by hysteron identify, or recordings in them.
        out: Checkpoint to write, .safetensors.
        design: Which network. Default: recurrent.
        held_out: Recordings to choose by, by name, from which nothing is learned [default: every recording is
            left out in one of as many folds as there are networks, and at least two; the networks then learn
            from all, for as many epochs as the folds took; paper: a sixth of every kind of motion and at
            least one of each that has two, drawn by the seed; a kind is the family of the plan, or is found
            from the strokes].
        epochs: Epochs at most [default: 100; paper: 30].
        hidden: Hidden units of a layer [default: 64; paper: 128].
        members: Networks whose mean is taken; the paper's design has one. Default: 3.
        feedback: Inputs of the network are the twin's tip of the sample before (eq. 11) and the strokes, not
            the strokes alone.
        figures: Folder for report.html and metrics.json [default: OUT without its ending].
        stride: Only every Nth window of the paper's design; 1 is published. Default: 1.
        batch: Windows of a step of the paper's design; 256 is published. Default: 256.
        seed: Seed of weights, order and held-out recordings. Default: 1.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "fit-residual",
        *positionals(recordings),
        *option("--out", out),
        *option("--design", design),
        *options("--held-out", held_out, ","),
        *option("--epochs", epochs),
        *option("--hidden", hidden),
        *option("--members", members),
        *flag("--feedback", feedback),
        *option("--figures", figures),
        *option("--stride", stride),
        *option("--batch", batch),
        *option("--seed", seed),
    ]
    outcome: outcomes.FitResidualOutcome = run_verb(
        outcomes.FitResidualOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def adapt(
    checkpoint: PathLike,
    recordings: PathLike | Sequence[PathLike],
    *,
    scene: PathLike,
    out: PathLike,
    reduced: PathLike | None = None,
    reference: PathLike | Sequence[PathLike] | None = None,
    figures: PathLike | None = None,
    memory_s: float | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.AdaptOutcome:
    """Adapt a calibrated twin to new recordings.

    As `hysteron adapt`.

    Args:
        checkpoint: Checkpoint by hysteron fit-residual, or by this verb.
        recordings: Recordings of the robot, .parquet or .csv, or folders of them; in the order of their
            names.
        scene: Scene file of the robot (scene.toml).
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        reference: Recordings of the robot as it was when its twin was calibrated, of the same kinds of
            motion: an error that the twin had on these too shows no change [default: the error of the
            networks in validation].
        out: Checkpoint to write, .safetensors.
        figures: Folder for metrics.json [default: OUT without its ending].
        memory_s: Time after which the weight of a sample is 1/e. Default: 600.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "adapt",
        *positional(checkpoint),
        *positionals(recordings),
        *option("--scene", scene),
        *option("--reduced", reduced),
        *options("--reference", reference, None),
        *option("--out", out),
        *option("--figures", figures),
        *option("--memory-s", memory_s),
    ]
    outcome: outcomes.AdaptOutcome = run_verb(
        outcomes.AdaptOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def generate(
    scene: PathLike,
    *,
    out: PathLike,
    reduced: PathLike | None = None,
    residual: PathLike | None = None,
    plan: str | None = None,
    shard: str | None = None,
    real: PathLike | Sequence[PathLike] | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.GenerateOutcome:
    """Run a plan on the calibrated twin: synthetic data.

    As `hysteron generate`.

    Args:
        scene: Scene file of the robot (scene.toml).
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        residual: Checkpoint by hysteron fit-residual.
        plan: Plan file (.toml), or the name of a built-in plan, run without changes [default: synthetic, made
            smaller until it stays within the strokes and rates of the recordings that the checkpoint was
            trained on, or of --real].
        out: Folder to write to.
        shard: Only the I-th of N parts of the trajectories.
        real: Recordings of the robot, or folders of them, to compare with on the card.
        png: Write the figure as .png too.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "generate",
        *positional(scene),
        *option("--reduced", reduced),
        *option("--residual", residual),
        *option("--plan", plan),
        *option("--out", out),
        *option("--shard", shard),
        *options("--real", real, None),
        *flag("--png", png),
    ]
    outcome: outcomes.GenerateOutcome = run_verb(
        outcomes.GenerateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def target(
    target: str,
    *,
    out: PathLike,
    scene: PathLike | None = None,
    tolerance_mm: float | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.TargetOutcome:
    """Sample a path for the tip, and check that a robot reaches it.

    As `hysteron target`.

    Args:
        target: Target: FAMILY:SIZE_MM, or a file (.toml, .svg, .csv, .parquet).
        out: Recording to write, .parquet or .csv.
        scene: Scene of a robot whose twin must reach it.
        tolerance_mm: Distance that counts as reached. Default: 0.1.
        figures: Folder for the figure, report.html and metrics.json.
        png: Write the figure as .png too.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "target",
        *positional(target),
        *option("--out", out),
        *option("--scene", scene),
        *option("--tolerance-mm", tolerance_mm),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.TargetOutcome = run_verb(
        outcomes.TargetOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def evaluate(
    results: str | Sequence[str],
    *,
    target: str,
    out: PathLike | None = None,
    png: bool = False,
    whole: bool = False,
    relative_to_rest: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.EvaluateOutcome:
    """Measure how closely recorded tips followed a target path.

    As `hysteron evaluate`.

    Args:
        results: Recordings, .parquet or .csv, paths without times (.csv with x_mm and y_mm), or folders of
            them: repeats of one experiment, or of each NAME.
        target: Target: a file, or FAMILY:SIZE_MM.
        out: Folder for report.html, metrics.json and figures.
        png: Write each figure as .png too.
        whole: All samples belong to the curve, at any time: scores of its geometry alone, without lag and
            RMSE at the same times. A path without times (.csv with x_mm and y_mm) has no other scores.
        relative_to_rest: Measure the tip from where it rested at the beginning.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "evaluate",
        *positionals(results),
        *option("--target", target),
        *option("--out", out),
        *flag("--png", png),
        *flag("--whole", whole),
        *flag("--relative-to-rest", relative_to_rest),
    ]
    outcome: outcomes.EvaluateOutcome = run_verb(
        outcomes.EvaluateOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def train(
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    scene: PathLike | None = None,
    residual: PathLike | None = None,
    reduced: PathLike | None = None,
    design: Literal["recurrent", "paper"] | None = None,
    spatial: bool = False,
    held_out: str | Sequence[str] | None = None,
    candidates: Literal["static-regression", "kernel-regression", "recorded-network", "network"] | Sequence[Literal["static-regression", "kernel-regression", "recorded-network", "network"]] | None = None,
    folds: int | None = None,
    epochs: int | None = None,
    hidden: int | None = None,
    co_contraction_min_mm: float | None = None,
    weights: Literal["float32", "int16"] | None = None,
    figures: PathLike | None = None,
    stride: int | None = None,
    batch: int | None = None,
    seed: int | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.TrainOutcome:
    """Train the inverse controller on recordings (EDIC).

    As `hysteron train`.

    Args:
        recordings: Recordings, or folders of them.
        out: Checkpoint to write, .safetensors.
        scene: Scene of the robot (scene.toml): its twin compares the controllers by what their strokes do to
            its tip, and where it is better itself, the checkpoint names it; without it they are compared by
            their strokes; recurrent only.
        residual: Checkpoint by hysteron fit-residual, of the same scene.
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        design: Which network. Default: recurrent.
        spatial: The path has x, y and z, for a robot of several segments; else x and y.
        held_out: A recording to validate on and stop by, by name; may be given several times [default: a
            sixth of every kind of motion and at least one of each that has two, drawn by the seed; a kind is
            the family of the plan, or is found from the strokes].
        candidates: Controllers to compare on recordings that they did not learn from: the simplest that is
            within 5 % of the best is fitted to all data and written [default: all; the network alone for the
            paper's design, and for recordings with synthetic data without --scene].
        folds: Folds of the recordings, each of which is left out in one; 1: a single split, with nothing
            fitted to all data afterwards [default: 3 where controllers are compared, else 1]; recurrent only.
        epochs: Epochs at most [default: 30, or as many as make 1000 updates of the weights; paper: 30].
        hidden: Hidden units of a layer [default: 128; paper: 512].
        co_contraction_min_mm: Pull that all tendons have in common at least, so that none goes slack;
            recurrent only.
        weights: Number type of the weights in the controller: int16 is faster where they do not fit a core's
            own cache (from a megabyte on); the change of the strokes is measured and reported; recurrent
            only. Default: float32.
        figures: Folder for report.html and metrics.json [default: OUT without its ending].
        stride: Only every Nth window of the paper's design; 1 is published. Default: 1.
        batch: Windows of a step of the paper's design; 256 is published. Default: 256.
        seed: Seed of weights, order, noise and held-out recordings. Default: 1.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "train",
        *positionals(recordings),
        *option("--out", out),
        *option("--scene", scene),
        *option("--residual", residual),
        *option("--reduced", reduced),
        *option("--design", design),
        *flag("--spatial", spatial),
        *options("--held-out", held_out, ","),
        *options("--candidates", candidates, ","),
        *option("--folds", folds),
        *option("--epochs", epochs),
        *option("--hidden", hidden),
        *option("--co-contraction-min-mm", co_contraction_min_mm),
        *option("--weights", weights),
        *option("--figures", figures),
        *option("--stride", stride),
        *option("--batch", batch),
        *option("--seed", seed),
    ]
    outcome: outcomes.TrainOutcome = run_verb(
        outcomes.TrainOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def command(
    checkpoint: PathLike | None = None,
    *,
    target: str,
    out: PathLike,
    scene: PathLike | None = None,
    nominal: bool = False,
    network: bool = False,
    stroke_min_mm: float | None = None,
    stroke_max_mm: float | None = None,
    stroke_rate_max_mm_s: float | None = None,
    figures: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.CommandOutcome:
    """Find the strokes that bring the tip along a path (EDIC).

    As `hysteron command`.

    Args:
        checkpoint: Checkpoint by hysteron train, whose network finds the strokes, or the twin that it names
            as better; with --scene, by hysteron fit-residual.
        target: Path that the tip shall follow.
        scene: Steer the twin of this scene along the path.
        nominal: Ignore the parameters of the scene that are fitted to a robot: zeros and compliance of the
            tendons, friction, backlash.
        network: Find the strokes by the network of the checkpoint, even where the checkpoint names a twin
            that leads the tip closer.
        out: Recording to write, .parquet or .csv.
        stroke_min_mm: Smallest stroke [default: that of the training; with --scene, the opposite of the
            largest].
        stroke_max_mm: Largest stroke [default: that of the training; with --scene 16].
        stroke_rate_max_mm_s: Fastest change of a stroke [default: that of the training; with --scene 12].
        figures: Folder for figures and report.html.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "command",
        *positional(checkpoint),
        *option("--target", target),
        *option("--scene", scene),
        *flag("--nominal", nominal),
        *flag("--network", network),
        *option("--out", out),
        *option("--stroke-min-mm", stroke_min_mm),
        *option("--stroke-max-mm", stroke_max_mm),
        *option("--stroke-rate-max-mm-s", stroke_rate_max_mm_s),
        *option("--figures", figures),
    ]
    outcome: outcomes.CommandOutcome = run_verb(
        outcomes.CommandOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def track(
    checkpoint: PathLike | None = None,
    *,
    target: str,
    rig: PathLike,
    out: PathLike,
    scene: PathLike | None = None,
    nominal: bool = False,
    network: bool = False,
    repeats: int | None = None,
    learn: bool = False,
    feedback: bool = False,
    calibration: PathLike | None = None,
    seed: int | None = None,
    baseline: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.TrackOutcome:
    """Follow a path open loop on a rig, and measure it.

    As `hysteron track`.

    Args:
        checkpoint: Checkpoint by hysteron train, whose network finds the strokes, or the twin that it names
            as better; with --scene, by hysteron fit-residual.
        target: Path that the tip shall follow.
        scene: Steer the twin of this scene along the path.
        nominal: Ignore the parameters of the scene that are fitted to a robot: zeros and compliance of the
            tendons, friction, backlash.
        network: Find the strokes by the network of the checkpoint, even where the checkpoint names a twin
            that leads the tip closer.
        rig: Rig file, or virtual:PRESET.
        out: Folder to write to.
        repeats: How often the strokes are run. Default: 1.
        learn: Learn from each repeat how to lead the tip in the next (iterative learning control); the
            repeats are scored one by one.
        feedback: Correct the strokes while they are run, by the tip that the tracker measures: slowly, so
            that errors of less than about half a hertz go; what was commanded is recorded.
        calibration: Calibration [default: the file that the rig file names; a virtual rig calibrates itself].
        seed: Seed of a virtual rig's noise; every repeat has the next one. Default: 1.
        baseline: State of the healthy servos as a baseline: metrics.json of an earlier record or track, or
            the output of hysteron identify-servo.
        png: Write each figure as .png too.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "track",
        *positional(checkpoint),
        *option("--target", target),
        *option("--scene", scene),
        *flag("--nominal", nominal),
        *flag("--network", network),
        *option("--rig", rig),
        *option("--out", out),
        *option("--repeats", repeats),
        *flag("--learn", learn),
        *flag("--feedback", feedback),
        *option("--calibration", calibration),
        *option("--seed", seed),
        *option("--baseline", baseline),
        *flag("--png", png),
    ]
    outcome: outcomes.TrackOutcome = run_verb(
        outcomes.TrackOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def fit_sensor(
    scene: PathLike,
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    reduced: PathLike | None = None,
    residual: PathLike | None = None,
    servos: PathLike | None = None,
    stall_torque: float | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.FitSensorOutcome:
    """Fit the force sensor to recordings without contact.

    As `hysteron fit-sensor`.

    Args:
        scene: Scene file of the robot (scene.toml).
        recordings: Recordings without contact, with holds between motions, or folders of them; where one has
            tip_force_x_n, tip_force_y_n, tip_force_z_n it calibrates the stiffness of the tip.
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        residual: Residual network of the twin.
        servos: Result of `hysteron identify-servo` where tensions were known: the scale of the loads is its
            mean over the servos.
        stall_torque: Torque of a servo at full load [default: an XL430-W250's]. Default: 1.4.
        out: Sensor to write, .json.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "fit-sensor",
        *positional(scene),
        *positionals(recordings),
        *option("--reduced", reduced),
        *option("--residual", residual),
        *option("--servos", servos),
        *option("--stall-torque", stall_torque),
        *option("--out", out),
    ]
    outcome: outcomes.FitSensorOutcome = run_verb(
        outcomes.FitSensorOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def sense(
    scene: PathLike,
    recording: PathLike,
    *,
    sensor: PathLike,
    out: PathLike,
    reduced: PathLike | None = None,
    residual: PathLike | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.SenseOutcome:
    """Estimate tensions and the force on the tip from a recording.

    As `hysteron sense`.

    Args:
        scene: Scene file of the robot (scene.toml).
        recording: Recording of strokes and tip, .parquet or .csv; with ticks and loads where there are
            servos.
        reduced: Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that
            of the scene, if it names one].
        sensor: Sensor by hysteron fit-sensor.
        residual: Residual network of the twin that the sensor was fitted with.
        out: Recording to write, .parquet or .csv.
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
        "sense",
        *positional(scene),
        *positional(recording),
        *option("--reduced", reduced),
        *option("--sensor", sensor),
        *option("--residual", residual),
        *option("--out", out),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.SenseOutcome = run_verb(
        outcomes.SenseOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def identify_servo(
    recordings: PathLike | Sequence[PathLike],
    *,
    out: PathLike,
    stall_torque: float | None = None,
    law: str | None = None,
    servos: int | Sequence[int] | None = None,
    figures: PathLike | None = None,
    png: bool = False,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.IdentifyServoOutcome:
    """Find friction, backlash and load scale of a rig's servos in recordings.

    As `hysteron identify-servo`.

    Args:
        recordings: Recordings of the rig with tick_goal_k, tick_present_k and load_k, or folders of them;
            tension_k_n with them gives the scale of the loads and the backlash.
        stall_torque: Torque of the stalled motor at full load, where no tensions give the scale of the loads
            [default: an XL430-W250's]. Default: 1.4.
        law: stribeck, coulomb-viscous, directed-stribeck, learned-map or rising-map. Default: stribeck.
        servos: Only these servos, by number from 1.
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
        "identify-servo",
        *positionals(recordings),
        *option("--stall-torque", stall_torque),
        *option("--law", law),
        *options("--servos", servos, ","),
        *option("--out", out),
        *option("--figures", figures),
        *flag("--png", png),
    ]
    outcome: outcomes.IdentifyServoOutcome = run_verb(
        outcomes.IdentifyServoOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome


def demo(
    *,
    out: PathLike | None = None,
    overwrite: bool = False,
    verbose: bool = False,
    progress: bool = False,
) -> outcomes.DemoOutcome:
    """See the whole chain in some minutes: a virtual robot is recorded, learned and led along paths.

    As `hysteron demo`.

    Args:
        out: Folder to write to. Default: out/demo.
        overwrite: Replace results of this program that other arguments have made.
        verbose: Print the lines of the result.
        progress: Draw a bar (tqdm, where it is installed).

    Raises:
        BadInput: Input that cannot be used; nothing is written under a final name.
        Failed: Everything else that went wrong.
    """
    words = [
        "demo",
        *option("--out", out),
    ]
    outcome: outcomes.DemoOutcome = run_verb(
        outcomes.DemoOutcome, words, overwrite=overwrite, verbose=verbose, progress=progress
    )
    return outcome
