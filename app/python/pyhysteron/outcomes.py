# Made by `cargo run --release -p hysteron-python --example generate_sources`; do not edit.
"""Outcomes of verbs: the keys of `metrics.json` and of `--json`; all numbers in SI."""

# ruff: noqa
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, Union

from ._outcome import Outcome as _Outcome

__all__ = [
    "AblatedRobot",
    "AblationMetrics",
    "AblationPath",
    "Activation",
    "ActuatorEvaluation",
    "AdaptOptions",
    "AdaptOutcome",
    "AdaptationBlock",
    "AdaptationMetrics",
    "AdaptedParts",
    "ArmAdaptOutcome",
    "ArmCheckOutcome",
    "ArmDynamicsOutcome",
    "ArmEmulateOutcome",
    "ArmEstimateOutcome",
    "ArmEvaluateOutcome",
    "ArmExciteOutcome",
    "ArmExportOutcome",
    "ArmFitDelanOutcome",
    "ArmFitNeuralOutcome",
    "ArmGenerateOutcome",
    "ArmIdentifyFrictionOutcome",
    "ArmIdentifyInertiaOutcome",
    "ArmIdentifyPayloadOutcome",
    "ArmIdentifyServoOutcome",
    "ArmInfoOutcome",
    "ArmRecordOutcome",
    "ArmSimulateOutcome",
    "ArmTrajectory",
    "Assessment",
    "AxisScore",
    "BaseMap",
    "BusCounts",
    "ByHorizon",
    "ByHorizon2",
    "ByMethod",
    "ByMethod2",
    "CalibratedRange",
    "Candidate",
    "CandidateErrors",
    "ChainSize",
    "ChannelCalibration",
    "ChannelErrors",
    "ChannelRange",
    "ChannelStatistics",
    "CheckOutcome",
    "CollisionCell",
    "CommandOutcome",
    "Commanded",
    "ComparedResult",
    "Comparison",
    "ContactScore",
    "CoreactMetrics",
    "CostEstimate",
    "Criterion",
    "DataOrigin",
    "DemoOutcome",
    "Described",
    "DetectionRow",
    "DetectorScores",
    "DistanceSummary",
    "DynamicsScores",
    "EdicMetrics",
    "EdicPath",
    "ErrorSpread",
    "ErrorStatistics",
    "Estimate",
    "EvaluateOutcome",
    "ExactSummary",
    "ExternalTorques",
    "FalseContacts",
    "FamilySamples",
    "FaultCell",
    "FaultDetectors",
    "Finding",
    "FitMaterialOutcome",
    "FitReport",
    "FitResidualOutcome",
    "FitSensorOutcome",
    "FittedParameter",
    "FittedTipErrors",
    "FittedValue",
    "FoldResult",
    "FollowedMethod",
    "ForceMethod",
    "ForceScore",
    "ForceScores",
    "ForceSensor",
    "ForceSource",
    "ForcesBySource",
    "FoundChange",
    "FrankaResult",
    "FrankaRow",
    "FreeRow",
    "FrictionResult",
    "FtdcrMetrics",
    "GenerateOutcome",
    "GoalSummary",
    "Health",
    "HeldOutError",
    "HoldErrors",
    "HorizonGradient",
    "IdentificationOptions",
    "IdentifiedRecording",
    "IdentifyOutcome",
    "IdentifyServoOutcome",
    "ImportOutcome",
    "Imported",
    "ImportedRecording",
    "InputForm",
    "InverseMetrics",
    "InverseOptions",
    "InverseRecurrentOptions",
    "InverseTraining",
    "JointMotionRange",
    "JointSummary",
    "JointWeights",
    "LayoutMetrics",
    "LayoutReach",
    "LeadingTwin",
    "LevelResult",
    "LiveEstimates",
    "Load",
    "LoadedMeans",
    "LockingComparison",
    "LockingEstimate",
    "LossWeights",
    "Machine",
    "Means",
    "MeshOutcome",
    "MeshResolution",
    "MeshSummary",
    "Method",
    "MethodError",
    "MethodErrors",
    "MethodRuns",
    "MotionErrors",
    "NamedShape",
    "NeuralCell",
    "NeuralStudy",
    "Numbers",
    "Outcome",
    "ParameterEstimate",
    "ParameterFit",
    "ParameterValue",
    "Parts",
    "PathDifference",
    "PathErrors",
    "PathScore",
    "PathSmoothing",
    "PlannedInput",
    "Polish",
    "PooledError",
    "PopulationMetrics",
    "PopulationPath",
    "PopulationRobot",
    "Port",
    "PortCounts",
    "PoseScores",
    "PredictedPath",
    "Proposed",
    "PublishedRow",
    "PublishedSuccess",
    "Reach",
    "ReachOutcome",
    "RealOptions",
    "RealRow",
    "Reason",
    "RecordOutcome",
    "Recorded",
    "Recorded2",
    "RecordedTable",
    "RecordedTrajectory",
    "RecordingEstimates",
    "RecordingFindings",
    "RecordingScore",
    "ReduceOutcome",
    "Repeatability",
    "ResidualOptions",
    "ResidualPart",
    "ResidualRecurrentOptions",
    "ResidualTensions",
    "ResidualTraining",
    "ResponseEstimate",
    "RigCalibrateOutcome",
    "RigCheckOutcome",
    "RigEmulateOutcome",
    "RigRecoverOutcome",
    "RobotSize",
    "RobotsMetrics",
    "RodResolution",
    "Row",
    "Row2",
    "RunLocking",
    "RunSummary",
    "Scaled",
    "ScaraMethod",
    "ScaraOptions",
    "SceneSummary",
    "SegmentsResult",
    "SenseOutcome",
    "SensedRobot",
    "SensingMetrics",
    "SensingScores",
    "ServoEstimates",
    "ServoHealth",
    "ServoLoad",
    "ServoSummary",
    "Setting",
    "Severity",
    "ShardsMergeOutcome",
    "ShardsPlanOutcome",
    "ShardsStatusOutcome",
    "ShardsWorkOutcome",
    "SharedTensions",
    "SimulateOutcome",
    "Simulated",
    "SimulatedErrors",
    "SimulatedRow",
    "SimulatedStudy",
    "SkippedExample",
    "Spread",
    "Stability",
    "StageCommands",
    "StationErrors",
    "StatsSummary",
    "StepDecay",
    "Study",
    "StudyAblationOutcome",
    "StudyAdaptationOutcome",
    "StudyBaxterCircleOutcome",
    "StudyBaxterHelicalOutcome",
    "StudyCharactersOutcome",
    "StudyCloningOutcome",
    "StudyConvergenceOutcome",
    "StudyCoreactOutcome",
    "StudyEdicOutcome",
    "StudyForceOutcome",
    "StudyFtdcrOutcome",
    "StudyIdentificationOutcome",
    "StudyInverseOutcome",
    "StudyKukaOutcome",
    "StudyLayoutsOutcome",
    "StudyNeuralNetworksOutcome",
    "StudyNeuralOutcome",
    "StudyPandaOutcome",
    "StudyPopulationOutcome",
    "StudyRecordedOutcome",
    "StudyRobotsOutcome",
    "StudyRunOutcome",
    "StudyScaraOutcome",
    "StudySensingOutcome",
    "StudySimulatedOutcome",
    "StudySofaOutcome",
    "StudySorosimOutcome",
    "StudyTentacleOutcome",
    "StudyWristOutcome",
    "SweepCell",
    "SweepRow",
    "SyntheticTrajectory",
    "TargetOutcome",
    "TargetSummary",
    "Task",
    "TaskScores",
    "TaskTrace",
    "TeachingResult",
    "TelemetryEstimates",
    "TendonSummary",
    "TensionErrors",
    "TensionScore",
    "TentacleMetrics",
    "TimePercentiles",
    "Tip",
    "TipBand",
    "TipBandSummary",
    "TipForceErrors",
    "TrackOutcome",
    "Tracked",
    "TrackerSurvey",
    "TrafficCounts",
    "TrainOutcome",
    "TrainedDesign",
    "TrainedMember",
    "TrainedOn",
    "TrainingOptions",
    "TrunkResult",
    "TwinErrors",
    "TwinTable",
    "Units",
    "Usability",
    "Validation",
    "Variant",
    "Verdict",
    "Warning",
    "WeightErrors",
    "WeightFormat",
    "WindowOptions",
    "WithoutContact",
    "WristResult",
]


@dataclass(frozen=True, kw_only=True)
class AblatedRobot(_Outcome):
    """A robot along every path."""

    paths: list[AblationPath]
    """One for each path."""

    robot: str
    """The robot."""


@dataclass(frozen=True, kw_only=True)
class AblationMetrics(_Outcome):
    """The numbers of `study ablation`."""

    robots: list[AblatedRobot]
    """One for each robot."""


@dataclass(frozen=True, kw_only=True)
class AblationPath(_Outcome):
    """A path by every ablation level."""

    rungs: list[LevelResult]
    """One for each level."""

    target: str
    """The path."""


@dataclass(frozen=True, kw_only=True)
class ActuatorEvaluation(_Outcome):
    """Comparison of a neural actuator with its baselines."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    condition_accuracy_auc: list[float] | None = None
    """Accuracy and area under the curve of the condition, sample by sample; none unless both conditions are
    there."""

    detectors: list[DetectorScores] | None = None
    """Detectors of a degraded motor, where recordings to fit them to were given."""

    force_from: ForceSource
    """Network that gives the force."""

    forces: ForcesBySource
    """Errors of the forces, all tasks together."""

    format: Literal["hysteron-neural-evaluation"]
    """Format of the file."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    left_out: list[str] | None = None
    """Criterion by which recordings were excluded from the training; none where that is not known."""

    mean_deg: ByMethod
    """Mean absolute error of the joints over the first steps of rollouts, mean of the tasks [deg]."""

    mean_gripper_mm: ByMethod
    """The same of the aperture [mm]; none without a gripper."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    tasks: list[TaskScores]
    """One entry per task."""

    trained_on: int
    """Number of recordings that it was trained on."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class AdaptOptions(_Outcome):
    """How fast and how far the correction goes."""

    drift_m: float
    """Deviation of the tracker's drift, along each axis [m]."""

    drift_time_s: float
    """Time over which that stays what it is [s]."""

    friction_ratio: float
    """Prior deviation of the factor on friction [-]."""

    gain: float
    """Prior deviation of what a millimetre of stroke or play does [-]."""

    largest_m: float
    """Largest correction, along each axis [m]."""

    least_gain: float
    """Part of the error on test blocks by which more numbers must do better than fewer to be kept [-]."""

    memory_s: float
    """Time constant τ of the data's weight, which falls to 1/e [s]."""

    noise_m: float
    """Noise of the tip, and hysteresis that no correction models [m]."""

    noise_time_s: float
    """Correlation time of that error [s]."""

    offset_m: float
    """Prior deviation of the constant term [m]."""

    play_m: float
    """Prior deviation of the play [m]."""

    zero_m: float
    """Prior deviation of a tendon's zero [m]."""


@dataclass(frozen=True, kw_only=True)
class AdaptOutcome(_Outcome):
    """The outcome of `adapt`."""

    blocks: list[AdaptationBlock]
    """Blocks of the recordings that were held out in turn."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    found: FoundChange
    """Beyond what the checkpoint had; in the checkpoint only if listed in `kept`."""

    held_out: list[HeldOutError]
    """By what would be kept: the root mean square distance of the tip on all blocks while each was held out."""

    kept: AdaptedParts
    """Parts of the adaptation that are kept."""

    known_error_m: float | None = None
    """Error of the twin on the robot as it was [m]: along the recordings of `--reference`, or else of the
    networks in validation."""

    options: AdaptOptions
    """Options of the adaptation."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    recordings: list[MotionErrors]
    """Errors along the recordings."""

    verdict: Verdict
    """Whether the adapted twin can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class AdaptationBlock(_Outcome):
    """A block of a recording."""

    recording: str
    """Name of the recording."""

    time_s: list[float]
    """First and last time [s]."""


@dataclass(frozen=True, kw_only=True)
class AdaptationMetrics(_Outcome):
    """The numbers of `study adaptation`."""

    rows: list[Row]
    """One for each target on each robot."""


@dataclass(frozen=True, kw_only=True)
class ArmAdaptOutcome(_Outcome):
    """The outcome of `arm adapt`."""

    actuator: str
    """File of the adapted actuator."""

    after_deg: float
    """The same by the adapted actuator [deg]."""

    before_deg: float
    """Mean absolute error of the joints in pure simulation of the recordings by the actuator as it was [deg]."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    verdict: Verdict
    """Whether the adapted actuator can be used."""


@dataclass(frozen=True, kw_only=True)
class ArmDynamicsOutcome(_Outcome):
    """The outcome of `arm dynamics`."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    out: str
    """The recording of the results."""

    rows: int
    """Number of samples."""


@dataclass(frozen=True, kw_only=True)
class ArmEmulateOutcome(_Outcome):
    """The outcome of `arm emulate`."""

    follower: PortCounts
    """The follower's port."""

    leader: PortCounts
    """The leader's port."""


@dataclass(frozen=True, kw_only=True)
class ArmExciteOutcome(_Outcome):
    """The outcome of `arm excite`."""

    base_parameters: int | None = None
    """Parameters that torques can identify; none without a search."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    condition_number: float | None = None
    """Condition number of their regressor [-]; none without a search."""

    condition_number_before: float | None = None
    """The same of a drawn series within the limits [-]."""

    duration_s: float
    """Time from the first to the last sample [s]."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    robot: str
    """Name of the robot."""

    samples: int
    """Number of samples."""

    seed: int | None = None
    """Seed of the search; none without one."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class ArmExportOutcome(_Outcome):
    """The outcome of `arm export`."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    joints: int
    """Number of joints that move."""

    out: str
    """The file."""


@dataclass(frozen=True, kw_only=True)
class ArmFitDelanOutcome(_Outcome):
    """The outcome of `arm fit delan`."""

    epochs: int
    """Epochs of Adam."""

    model: str
    """File of the model."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    steps: int
    """Steps of Levenberg and Marquardt's method."""

    validation: float
    """Error in validation over the deviation of the torques [-]."""

    verdict: Verdict
    """Whether the model can be used."""


@dataclass(frozen=True, kw_only=True)
class ArmFitNeuralOutcome(_Outcome):
    """The outcome of `arm fit neural`."""

    actuator: str
    """File of the actuator."""

    epochs: int
    """Epochs done when the weights in the loop were found."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    parameters: int
    """Parameters of the network in the loop."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    sensing_validation: float | None = None
    """Loss of force, contact and condition in validation; none without a network of their own."""

    steps_per_second: float
    """Steps simulated per second of training [1/s]."""

    validation_deg: float
    """Root mean square error of the joints in rollouts of the validation trajectories [deg]."""

    verdict: Verdict
    """Whether the actuator can be used."""


@dataclass(frozen=True, kw_only=True)
class ArmGenerateOutcome(_Outcome):
    """The outcome of `arm generate`."""

    about: str
    """Description of the data set, with its limits."""

    arm: str
    """Name of the virtual arm."""

    arm_sha256: str
    """SHA-256 of its file."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    duration_min: float
    """Duration of all [min]."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    rows: list[ArmTrajectory]
    """One entry per trajectory."""

    samples: int
    """Samples of all."""

    seed: int
    """Seed of the individual arm, its motions and its noise."""

    trajectories: int
    """Number of trajectories."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class ArmIdentifyFrictionOutcome(_Outcome):
    """The outcome of `arm identify friction`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    condition: float | None = None
    """Condition number of the parameters [-]; none of a population."""

    correlation: list[list[float]] | None = None
    """Correlations of the estimates (n_estimates × n_estimates) [-]; none of a population."""

    estimates: list[ParameterEstimate]
    """The numbers that were found."""

    folds_rms_n_m: list[float] | None = None
    """The same on the test recordings of each fold [N m]; none without folds."""

    format: Literal["hysteron-metrics"] | Literal["hysteron-identification"]
    """Format of the file."""

    joint: int
    """Number of the joint, from 1."""

    law: str
    """Law of friction."""

    method: str
    """Method of the fit."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    rms_n_m: float
    """Root mean square error of the torque [N m]."""

    samples: int
    """Number of samples."""

    seed: int
    """Seed of populations."""

    verdict: Verdict
    """Whether the law can be used."""

    version: int
    """Its version."""

    warnings: list[str]
    """Warnings about the fit, as sentences."""


@dataclass(frozen=True, kw_only=True)
class ArmIdentifyInertiaOutcome(_Outcome):
    """The outcome of `arm identify inertia`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    condition: float
    """Condition number of these combinations [-]."""

    cutoff_hz: float
    """Cut-off frequency of the low pass [Hz]."""

    estimates: list[ParameterEstimate]
    """The numbers that were found."""

    format: Literal["hysteron-metrics"] | Literal["hysteron-identification"]
    """Format of the file."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    least_pseudo_inertias: list[float]
    """Smallest eigenvalue of the pseudo-inertia, body by body; above 0 where a body is physically possible."""

    n_determined: int
    """Combinations of parameters that the motion determines."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    response: ResponseEstimate | None = None
    """Response of the measured torques; none where it was not asked for."""

    rms_n_m: list[float]
    """Root mean square error of the torque, joint by joint [N m]."""

    robot: str
    """Name of the robot."""

    samples: int
    """Number of samples."""

    test_rms_n_m: list[float] | None = None
    """The same on what was not fitted [N m]; none where all was."""

    verdict: Verdict
    """Whether the bodies can be used."""

    version: int
    """Its version."""

    warnings: list[str]
    """Terms that can hardly be distinguished, as sentences."""


@dataclass(frozen=True, kw_only=True)
class ArmIdentifyPayloadOutcome(_Outcome):
    """The outcome of `arm identify payload`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    cutoff_hz: float
    """Cut-off frequency of the low pass [Hz]."""

    estimates: list[ParameterEstimate]
    """The numbers that were found."""

    format: Literal["hysteron-metrics"] | Literal["hysteron-identification"]
    """Format of the file."""

    frame: str
    """Frame that holds the payload."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    rms_bare_n_m: list[float]
    """The same of the bare arm [N m]."""

    rms_with_n_m: list[float]
    """The same with the payload [N m]."""

    rms_without_n_m: list[float]
    """Root mean square error of the torque of the loaded arm without the payload, joint by joint [N m]."""

    robot: str
    """Name of the robot."""

    samples: int
    """Samples with the payload."""

    verdict: Verdict
    """Whether the payload can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class ArmIdentifyServoOutcome(_Outcome):
    """The outcome of `arm identify servo`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    condition: float
    """Condition number of the parameters [-]."""

    converged: bool
    """Whether the search ended at a minimum."""

    correlation: list[list[float]]
    """Correlations of the estimates (n_estimates × n_estimates) [-]."""

    drive: str
    """Name of the drive."""

    error_rad: float
    """Mean error of the angle over the recordings, open loop [rad]."""

    estimates: list[ParameterEstimate]
    """The numbers that were found."""

    evaluations: int
    """Evaluations of the search."""

    format: Literal["hysteron-metrics"] | Literal["hysteron-identification"]
    """Format of the file."""

    law: str
    """Law of friction."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    supply_v: float
    """Voltage of the supply [V]."""

    test_error_rad: float | None = None
    """The same on recordings that were not fitted [rad]; none without any."""

    verdict: Verdict
    """Whether the drive can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class ArmInfoOutcome(_Outcome):
    """The outcome of `arm info` and of `arm check`."""

    held_joints: list[str]
    """Joints that are held at zero."""

    joints: list[JointSummary]
    """Joints that move."""

    reach_m: float
    """Distance from the base that no point of the robot is beyond [m]."""

    robot: str
    """Name of the robot."""

    warnings: list[str]
    """Warnings about the file, as sentences."""


@dataclass(frozen=True, kw_only=True)
class ArmRecordOutcome(_Outcome):
    """The outcome of `arm record`."""

    filled_in: int
    """Samples that were not measured and are filled in."""

    late_cycles: int
    """Cycles that came late."""

    recording: str
    """The recording."""

    rows: int
    """Number of samples."""


@dataclass(frozen=True, kw_only=True)
class ArmSimulateOutcome(_Outcome):
    """The outcome of `arm simulate`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    duration_s: float
    """Time from the first to the last sample [s]."""

    energy_j: list[float]
    """Energy at the start and at the end [J]."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    joints: list[JointMotionRange]
    """One entry per joint."""

    robot: str
    """Name of the robot."""

    samples: int
    """Number of samples."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class ArmTrajectory(_Outcome):
    """A trajectory of the virtual arm."""

    condition: str
    """Condition of the motors."""

    duration_s: float
    """Time of the last sample [s]."""

    labelled: float
    """Part of the samples whose force is labelled [-]."""

    name: str
    """Subset, task, split and number."""

    payload_kg: float
    """Mass that the arm carries [kg]."""

    samples: int
    """Number of samples."""


@dataclass(frozen=True, kw_only=True)
class Assessment(_Outcome):
    """Recall, delay and false alarms of a test at one threshold."""

    delay_samples: list[float]
    """Samples from the beginning of a contact to its alarm, mean and largest of those found; NaN where none was."""

    false_alarms: int
    """Alarms that went on without a contact."""

    false_alarms_per_hour: float
    """The same for each hour without contact [1/h]."""

    recall: float
    """Share of the contacts that were found before they ended [-]."""

    threshold: float
    """The value of the test above which the alarm went on."""


@dataclass(frozen=True, kw_only=True)
class AxisScore(_Outcome):
    """Errors along one axis."""

    nrmse: float | None = None
    """The same over the range of the measured path [-]; none where that is a point."""

    rmse_m: float
    """Root mean square error [m]."""


@dataclass(frozen=True, kw_only=True)
class BusCounts(_Outcome):
    """Counts since the bus was opened."""

    answers: int
    """Answers that came whole."""

    corrupt: int
    """Answers that were damaged, or from another servo."""

    instructions: int
    """Instructions sent, those sent again included."""

    lost: int
    """Reads that failed although asked again."""

    refused: int
    """Instructions that a servo refused."""

    reopened: int
    """Times that the port was opened again."""

    retries: int
    """Instructions sent again."""

    timeouts: int
    """Answers that did not come in time."""


@dataclass(frozen=True, kw_only=True)
class ByHorizon(_Outcome):
    """A number or several of each horizon of [`HORIZONS`]."""

    key_100: float | None = field(default=None, metadata={"key": "100"})
    """Over the first 100 steps."""

    key_300: float | None = field(default=None, metadata={"key": "300"})
    """Over the first 300 steps."""

    key_500: float | None = field(default=None, metadata={"key": "500"})
    """Over the first 500 steps."""

    key_600: float | None = field(default=None, metadata={"key": "600"})
    """Over the first 600 steps."""


@dataclass(frozen=True, kw_only=True)
class ByHorizon2(_Outcome):
    """A number or several of each horizon of [`HORIZONS`]."""

    key_100: PoseScores = field(metadata={"key": "100"})
    """Over the first 100 steps."""

    key_300: PoseScores = field(metadata={"key": "300"})
    """Over the first 300 steps."""

    key_500: PoseScores = field(metadata={"key": "500"})
    """Over the first 500 steps."""

    key_600: PoseScores = field(metadata={"key": "600"})
    """Over the first 600 steps."""


@dataclass(frozen=True, kw_only=True)
class ByMethod(_Outcome):
    """A number or several of each method of [`METHODS`]."""

    copy_the_goal: ByHorizon = field(metadata={"key": "copy the goal"})
    """Motors whose positions are their goals."""

    copy_the_goal_lag_and_droop_fitted: ByHorizon = field(metadata={"key": "copy the goal, lag and droop fitted"})
    """The goal later, smoother and lower."""

    network_pure_simulation_currents_of_the_drive_model: ByHorizon = field(metadata={"key": "network, pure simulation (currents of the drive model)"})
    """Network in the loop with currents by the model of the drives."""

    network_recorded_currents_as_published: ByHorizon = field(metadata={"key": "network, recorded currents (as published)"})
    """Network in the loop with recorded currents."""

    servo_identified_by_rollout: ByHorizon = field(metadata={"key": "servo identified by rollout"})
    """Position servo identified by rollout."""


@dataclass(frozen=True, kw_only=True)
class ByMethod2(_Outcome):
    """A number or several of each method of [`METHODS`]."""

    copy_the_goal: ByHorizon2 = field(metadata={"key": "copy the goal"})
    """Motors whose positions are their goals."""

    copy_the_goal_lag_and_droop_fitted: ByHorizon2 = field(metadata={"key": "copy the goal, lag and droop fitted"})
    """The goal later, smoother and lower."""

    network_pure_simulation_currents_of_the_drive_model: ByHorizon2 = field(metadata={"key": "network, pure simulation (currents of the drive model)"})
    """Network in the loop with currents by the model of the drives."""

    network_recorded_currents_as_published: ByHorizon2 = field(metadata={"key": "network, recorded currents (as published)"})
    """Network in the loop with recorded currents."""

    servo_identified_by_rollout: ByHorizon2 = field(metadata={"key": "servo identified by rollout"})
    """Position servo identified by rollout."""


@dataclass(frozen=True, kw_only=True)
class CalibratedRange(_Outcome):
    """Strokes and rates of every tendon, and where they are from."""

    rates_m_s: list[float] | None = None
    """Fastest change of each tendon [m/s]; none where it is not known."""

    source: str
    """Robot that carried them out."""

    strokes_m: list[list[float]]
    """Smallest and largest stroke of each tendon [m]."""


@dataclass(frozen=True, kw_only=True)
class CandidateErrors(_Outcome):
    """Errors of a controller in validation."""

    candidate: Candidate
    """Which controller."""

    folds: int
    """Folds that it was fitted for: fewer than the others where it was far behind after the first."""

    is_chosen: bool
    """Whether it is the one in the checkpoint."""

    stroke_rmse_mm: float
    """Root mean square error of its strokes [mm]."""

    tip_rmse_mm: float | None = None
    """Root mean square distance of the tips that its strokes and the recorded ones bring the twin to [mm]; none
    where no twin was named, or it cannot follow."""

    tip_standard_error_mm: float | None = None
    """Standard error of that, from the differences between recordings [mm]."""


@dataclass(frozen=True, kw_only=True)
class ChainSize(_Outcome):
    """Size of a chain of condensed sections."""

    sections: int
    """Sections."""

    unknowns: int
    """Degrees of freedom."""


@dataclass(frozen=True, kw_only=True)
class ChannelCalibration(_Outcome):
    """Zero and slack of a tendon."""

    servo: int
    """Id of its servo."""

    slack_end_mm: float
    """Stroke at which the slack ends [mm]."""

    zero_ticks: int
    """Position of the servo at stroke zero [ticks]."""


@dataclass(frozen=True, kw_only=True)
class ChannelErrors(_Outcome):
    """Errors of an output."""

    errors: list[float]
    """By method."""

    name: str
    """Which output."""


@dataclass(frozen=True, kw_only=True)
class ChannelRange(_Outcome):
    """A channel."""

    changes_ratio: float
    """Part of the samples that differ from the one before [-]."""

    largest: float
    """Largest value."""

    name: str
    """Name."""

    smallest: float
    """Smallest value."""

    unit: str
    """Unit of the two numbers."""


@dataclass(frozen=True, kw_only=True)
class ChannelStatistics(_Outcome):
    """The values of a channel, in its SI unit."""

    deviation: float
    """Standard deviation."""

    largest: float
    """Largest value."""

    mean: float
    """Mean."""

    quantiles: list[float]
    """Values that 1, 50 and 99 % of the samples do not pass, good to a sixteenth of themselves."""

    smallest: float
    """Smallest value."""


@dataclass(frozen=True, kw_only=True)
class CollisionCell(_Outcome):
    """Collisions during motion: table 3 and the receiver operating characteristic."""

    free_hours: float
    """Time without contact [h]."""

    n_contacts: int
    """Collisions."""

    rows: list[DetectionRow]
    """The observers."""

    seed: int
    """Seed of all draws."""


@dataclass(frozen=True, kw_only=True)
class CommandOutcome(_Outcome):
    """The outcome of `command`."""

    approach_samples: int
    """Samples of the approach before it."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    extrapolating: float
    """Share of the path's samples outside the range of the training [-]."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    held_back: float
    """Share of the path's samples with a stroke that a limit reduced [-]."""

    out: str
    """The recording of the strokes."""

    return_samples: int
    """Samples of the return after it."""

    samples: int
    """Samples of the path itself."""

    source: str
    """Provenance of the strokes."""

    tip_band_m: float | None = None
    """Radius about the twin's tip that the robot's is expected in, median of the path, by the recordings left
    out in the training of the twin's residual network [m]."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class Commanded(_Outcome):
    """Metadata of the strokes of a tracked path."""

    extrapolating: float
    """Part of the samples in which a network was outside what it had seen in training [-]."""

    limited: float
    """Part of the samples in which a limit reduced a stroke [-]."""


@dataclass(frozen=True, kw_only=True)
class ComparedResult(_Outcome):
    """One of several results that are compared."""

    name: str
    """Name."""

    repeatability: dict[str, Repeatability] | None = None
    """By metric, over its repeats."""

    repeats: int
    """Number of repeats."""


@dataclass(frozen=True, kw_only=True)
class Comparison(_Outcome):
    """Worst relative differences of a comparison up to a stroke."""

    comparison: str
    """Law of the twin, and the reference."""

    to_stroke_mm: float
    """Strokes up to this one [mm]."""

    worst_deflection: float
    """Difference of the distances from rest over the deflection [-]."""

    worst_tension: float
    """Difference of the tensions of the pulled tendon [-]."""

    worst_tip: float
    """Distance of the tips over the deflection [-]."""


@dataclass(frozen=True, kw_only=True)
class ContactScore(_Outcome):
    """How contacts were found."""

    claimed: float
    """Share of it in which a contact was detected [-]."""

    contacts: int
    """Contacts."""

    false_alarms_per_hour: float
    """Alarms while there was no contact and had been none for a second, an hour [1/h]."""

    found_at_once: float
    """Share found within 100 ms [-], of all and of those that were not preceded by a contact that had not been
    given up."""

    free_s: float
    """Time without contact [s]."""

    strong_found_at_once: float
    """Share of contacts above 0.15 N found within 100 ms [-]."""


@dataclass(frozen=True, kw_only=True)
class CoreactMetrics(_Outcome):
    """The numbers of `study coreact`."""

    ladders: list[TwinTable]
    """Twins of the ablation of `typical`, and the best of them by a tracker without drift."""

    stability: Stability
    """Rollouts on random plans."""


@dataclass(frozen=True, kw_only=True)
class CostEstimate(_Outcome):
    """Time and size of a set, from trajectories that were simulated on one core."""

    bytes_per_sample: float
    """Size of a sample [byte]."""

    core_hours: float
    """Time of one core for the set [h]."""

    core_hours_per_1e9: float
    """Time of one core for 10⁹ samples [h]."""

    core_s_per_sample: float
    """Time of one core for a sample [s]."""

    gigabytes: float
    """Size of the set [GB]."""

    gigabytes_per_1e9: float
    """Size of 10⁹ samples [GB]."""

    samples: int
    """Their samples."""

    trajectories: int
    """Trajectories that were simulated."""


@dataclass(frozen=True, kw_only=True)
class Described(_Outcome):
    """Size of a recording."""

    channels: int
    """Number of channels."""

    duration_s: float
    """Time from the first to the last sample [s]."""

    name: str
    """Name of the file without its ending."""

    path: str
    """The file."""

    rate_hz: float | None = None
    """Rate [Hz]; none where steps are uneven."""

    samples: int
    """Number of samples."""


@dataclass(frozen=True, kw_only=True)
class DetectionRow(_Outcome):
    """How one observer detects collisions."""

    band: Assessment
    """Of the band test at its lowest threshold with at most one false alarm an hour."""

    cusum: Assessment
    """Of the cumulated sums, likewise."""

    delay_samples: float
    """Samples from the first truth above the threshold to the alarm, mean."""

    excess_delay_samples: list[float]
    """Samples by which an alarm is later than that of an observer with a perfect model at the same threshold,
    mean and largest."""

    learned: Assessment
    """Thresholds of the band fitted to motion without contact, as fitted."""

    max_n_m: list[float]
    """Largest error during collisions [N m]."""

    method: str
    """Name of [`OBSERVERS`]."""

    peak_error_n_m: list[float]
    """Error of the largest torque of a collision, mean over collisions, joint by joint [N m]."""

    right_joint: float
    """Share of collisions whose outermost loaded joint was named."""

    rmse_n_m: list[float]
    """Root mean square error during collisions [N m]."""

    roc: list[Assessment]
    """Receiver operating characteristic of the band test."""


@dataclass(frozen=True, kw_only=True)
class DetectorScores(_Outcome):
    """A detector's windows: how healthy each looks, and whether it is."""

    accuracy: float
    """Share of windows that are classified correctly, at the threshold that does best on the training windows
    [-]."""

    area: float
    """Area under the receiver operating characteristic."""

    name: str
    """Name of the detector."""


@dataclass(frozen=True, kw_only=True)
class DistanceSummary(_Outcome):
    """Distribution of a distance."""

    max_m: float
    """Largest [m]."""

    median_m: float
    """Median [m]."""

    p99_m: float
    """99th percentile [m]."""

    rms_m: float
    """Root of the mean square [m]."""


@dataclass(frozen=True, kw_only=True)
class DynamicsScores(_Outcome):
    """Errors of a model of inverse dynamics on a recording."""

    mean_r2: float
    """Mean of the joints' coefficients of determination [-]."""

    mse_n2_m2: list[float]
    """Mean squared error of the torque, joint by joint [N² m² or N²]."""

    nmse: list[float]
    """The same over the variance of the torque [-]."""

    pooled_r2: float
    """Coefficient of determination of all joints together [-]."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""


@dataclass(frozen=True, kw_only=True)
class EdicMetrics(_Outcome):
    """The numbers of `study edic`."""

    paths: list[EdicPath]
    """One for each path."""


@dataclass(frozen=True, kw_only=True)
class EdicPath(_Outcome):
    """A path by every method."""

    methods: list[MethodRuns]
    """One for each method."""

    paper_iou: float
    """Its overlap [-]."""

    paper_nrmse_percent: float
    """NRMSE of the paper's EDIC [%]."""

    path: str
    """The path, by its name and size [mm]."""


@dataclass(frozen=True, kw_only=True)
class ErrorSpread(_Outcome):
    """A distribution of errors."""

    largest: float
    """Largest error."""

    median: float
    """Half of the errors are below this."""

    percentile_99: float
    """99 of 100 are below this."""


@dataclass(frozen=True, kw_only=True)
class ErrorStatistics(_Outcome):
    """Errors over the shapes [%]."""

    max: float
    """Largest."""

    mean: float
    """Mean."""

    median: float
    """Median."""

    p95: float
    """Value that 95 % stay below."""


@dataclass(frozen=True, kw_only=True)
class Estimate(_Outcome):
    """A number with its standard error."""

    standard_error: float
    """Its standard error."""

    value: float
    """The number."""


@dataclass(frozen=True, kw_only=True)
class EvaluateOutcome(_Outcome):
    """The outcome of `evaluate`, and of `track` along a path."""

    command: str
    """The command that made this."""

    commanded: Commanded | None = None
    """How the strokes were commanded, where that is known."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    health: Health | None = None
    """Condition of the rig's servos, where the recordings were made by the same command."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    recordings: list[RecordingScore]
    """One entry per recording."""

    repeatability: dict[str, Repeatability] | None = None
    """By metric, over the recordings, where they are repeats of one result."""

    results: list[ComparedResult] | None = None
    """Results that are compared, where they have names."""

    target: TargetSummary
    """The target."""

    verdict: Verdict
    """Whether the tip follows the target."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class ExactSummary(_Outcome):
    """How far the chain of a run was off."""

    samples: int
    """Samples that were made by the finite elements too."""

    tension_largest_n: float
    """Largest error of a tension [N]."""

    tension_median_n: float
    """Half of the largest errors of a tension were less [N]."""

    tip_largest_m: float
    """Largest distance of the two tips [m]."""

    tip_median_m: float
    """Half of the tips of the chain were closer than this to those of the finite elements [m]."""

    unsolved: int
    """Others for which they found no equilibrium."""


@dataclass(frozen=True, kw_only=True)
class ExternalTorques(_Outcome):
    """External torques along a recording."""

    out: str
    """The recording of the estimates."""

    rms_n_m: list[float]
    """Root mean square of the external torque, joint by joint [N m or N]."""

    rows: int
    """Number of samples."""


@dataclass(frozen=True, kw_only=True)
class FalseContacts(_Outcome):
    """Share of contact-free rows in which a force is above a threshold [-]."""

    above_half_n: float
    """Above 0.5 N, the paper's noise floor."""

    above_learned: float
    """Above what 99 % of the training rows stay below."""

    learned_n: float
    """That threshold [N]."""


@dataclass(frozen=True, kw_only=True)
class FamilySamples(_Outcome):
    """Trajectories of a family."""

    made: int
    """Trajectories in the set."""

    samples: int
    """Samples."""

    skipped: int
    """Skipped trajectories."""


@dataclass(frozen=True, kw_only=True)
class FaultCell(_Outcome):
    """Detectors of a degraded motor on faults that the published data set does not have."""

    detectors: FaultDetectors
    """The detectors by kind of fault."""

    tests: int
    """Number of trajectories that detectors were tested on."""

    trained_on: int
    """Number of trajectories that the network was trained on."""


@dataclass(frozen=True, kw_only=True)
class FaultDetectors(_Outcome):
    """Detectors of a degraded motor by kind of fault, each next to healthy motors."""

    all: list[DetectorScores]
    """On all of them."""

    band: list[DetectorScores]
    """On motors with a rubber band."""

    friction: list[DetectorScores]
    """On motors with more dry friction."""

    lost_tooth: list[DetectorScores]
    """On motors with a lost tooth."""


@dataclass(frozen=True, kw_only=True)
class FitMaterialOutcome(_Outcome):
    """The outcome of `fit-material`; everything in SI."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    condition: float
    """Condition number of the Jacobian, columns normalised [-]."""

    constant_channels: int
    """Coordinates of the tip that never change and were skipped."""

    converged: bool
    """Whether it converged."""

    correlation: list[list[float]]
    """Correlation, rows and columns in the order of the parameters; zero where one was not fitted [-]."""

    doubts: list[str]
    """Warnings about the result, and other explanations of the errors that are left."""

    effective_residuals: float
    """Effective number of independent residuals [-]."""

    ended: str
    """Why the search ended."""

    errors_after: FittedTipErrors
    """Errors of the fitted scene."""

    errors_before: FittedTipErrors
    """Errors of the scene as given."""

    evaluations: int
    """Evaluations of the search."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    gravity_m_s2: list[float]
    """Gravity of the fitted scene [m/s²]."""

    iterations: int
    """Iterations of the search."""

    largest_tensions_n: list[float]
    """Largest tension of every tendon with the fitted scene [N]."""

    parameters: list[FittedParameter]
    """Parameters of the fit."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    recordings: int
    """Recordings that were compared."""

    recordings_of_another_role: int
    """Recordings that were skipped for their role."""

    residuals: int
    """Residuals."""

    robot: str
    """Name of the robot."""

    rows: int
    """Measured tips that were compared."""

    scene_sha256: str
    """Hash of the scene and its mesh."""

    steps: int
    """Steps of the twin in an evaluation."""

    verdict: Verdict
    """Whether the fitted scene can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class FitReport(_Outcome):
    """Report on a fit: splits, learning curve, validation errors by method and output."""

    channels: list[ChannelErrors]
    """Root mean square errors in validation."""

    curve: list[list[float]]
    """Of every epoch, the error in training and in validation, in `unit`."""

    epochs: int
    """Epochs after which the weights were found that are kept."""

    methods: list[str]
    """Methods evaluated: baselines, and the network last."""

    training: list[str]
    """Names of the training trajectories."""

    unit: str
    """Unit of all errors."""

    validation: list[str]
    """Names of the validation trajectories: early stopping and errors use these."""


@dataclass(frozen=True, kw_only=True)
class FitResidualOutcome(_Outcome):
    """The outcome of `fit-residual`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    networks: list[FitReport]
    """Learning curve, and errors in validation next to those of the baselines: one entry per network."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    training: ResidualTraining
    """Data and options, as the checkpoint holds them."""

    verdict: Verdict
    """Whether the networks can be used."""

    version: int
    """Its version."""

    warnings: list[str]
    """Where a network does no better than a baseline."""


@dataclass(frozen=True, kw_only=True)
class FitSensorOutcome(_Outcome):
    """The outcome of `fit-sensor`, which is the file of the sensor."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: str
    """Format of the file: `hysteron-force-sensor`."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    recordings: list[list[str]]
    """Names and SHA-256 of the recordings."""

    residual_sha256: str | None = None
    """Hash of the residual network, where the twin has one."""

    scene_sha256: str
    """Hash of the scene and its mesh."""

    sensor: ForceSensor
    """The sensor."""

    verdict: Verdict
    """Whether forces can be estimated with this sensor."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class FittedParameter(_Outcome):
    """A parameter of the fit, in SI."""

    is_at_bound: bool
    """Whether the fit ended at a bound."""

    lower_bound: float
    """Lower bound."""

    name: str
    """Name."""

    prior_width: float | None = None
    """Standard deviation of the prior; a factor on a logarithmic scale."""

    standard_error: float | None = None
    """Standard error, where the data determine it."""

    standing: str
    """Identifiability, in words."""

    start: float
    """Value of the scene."""

    upper_bound: float
    """Upper bound."""

    value: float
    """Fitted value."""


@dataclass(frozen=True, kw_only=True)
class FittedTipErrors(_Outcome):
    """Errors of the twin's tip."""

    rmse_axes_m: list[float]
    """Root mean square along x, y and z [m]."""

    rmse_distance_m: float
    """Root mean square of the distance [m]."""


@dataclass(frozen=True, kw_only=True)
class FittedValue(_Outcome):
    """A fitted parameter."""

    is_fitted: bool
    """Whether the data determine it."""

    name: str
    """Name of the parameter."""

    standard_error: float | None = None
    """Its standard error, where it has one."""

    start: float
    """Value at the start."""

    value: float
    """Value that was found."""


@dataclass(frozen=True, kw_only=True)
class FoldResult(_Outcome):
    """One fold."""

    fit_ended: str
    """Why its fit ended."""

    parameters: list[ParameterValue]
    """Parameters of the reduced model."""

    patterns: list[str]
    """Labels of the patterns that were held out."""

    rmse_mm: list[MethodError]
    """Errors by method."""

    rows: int
    """Their rows."""

    rows_without_equilibrium: int
    """Rows without an equilibrium of the twin."""

    twin_parameters: list[float] | None = None
    """Parameters of the finite-element twin's own fit; null without one."""


@dataclass(frozen=True, kw_only=True)
class FollowedMethod(_Outcome):
    """One method for strokes."""

    aligned_rmse_mm: float | None = None
    """Root mean square distance from where the tip was to be at that time [mm]."""

    iou: float | None = None
    """Overlap [-]."""

    lag_ms: float | None = None
    """Lag behind the target [ms]."""

    method: str
    """Name of the method."""

    nrmse_percent: float | None = None
    """NRMSE [%]."""


@dataclass(frozen=True, kw_only=True)
class ForceMethod(_Outcome):
    """The forces that one method estimates."""

    free: list[FreeRow]
    """Forces without contact, arm by arm."""

    loaded: LoadedMeans
    """Errors with objects."""

    name: str
    """Name of the method."""


@dataclass(frozen=True, kw_only=True)
class ForceScore(_Outcome):
    """Errors of the force on the tip."""

    aligned: float
    """Share whose direction is off by 15° at most [-]."""

    median_n: float
    """Median of the error's norm [N]."""

    method: str
    """Method of the estimate."""

    n: int
    """How many."""

    near: float
    """Share within 30 mN or 15 % [-]."""

    rms_n: float
    """Root mean square of the error's norm [N]."""

    samples: str
    """Which samples."""


@dataclass(frozen=True, kw_only=True)
class ForceScores(_Outcome):
    """Errors of forces over the samples that have a label."""

    false_contact: float
    """Share of the samples without force at which contact is reported [-]."""

    loaded_axis_n: float
    """Mean absolute error of the axis along which most of the force is, over the samples under force [N]."""

    loaded_mean_of_axes_n: float
    """The same over the samples under force."""

    loaded_norm_n: float
    """Mean length of the error there [N]."""

    mean_of_axes_n: float
    """Mean absolute error of the three axes, over all labelled samples, as published [N]."""

    missed_contact: float
    """Share of the samples under force at which none is [-]."""

    samples: list[int]
    """Samples with a label, and those under force."""


@dataclass(frozen=True, kw_only=True)
class ForceSensor(_Outcome):
    """Fitted errors of a robot and its twin, from which forces are estimated."""

    period_s: float
    """Duration of a sample [s]."""

    servo: ServoLoad | None = None
    """The servos, where their loads were recorded."""

    stiffness_scale: float
    """Stiffness of the robot's tip over the twin's, all friction points slipping [-]."""

    tension: TensionErrors
    """Errors of tensions."""

    tip: TipForceErrors
    """Errors of the tip."""


@dataclass(frozen=True, kw_only=True)
class ForcesBySource(_Outcome):
    """Errors of the forces of each source of [`FORCES`]; none where a source gives no force, or without any
    label."""

    force: ForceScores | None = None
    """Network with recorded telemetry."""

    force_gmo_drive: ForceScores | None = None
    """Momentum observer with a model of the drive."""

    force_gmo_linear: ForceScores | None = None
    """Momentum observer with a linear model of the torque."""

    force_pure: ForceScores | None = None
    """Network in pure simulation."""


@dataclass(frozen=True, kw_only=True)
class FoundChange(_Outcome):
    """A change of the robot that was found."""

    friction_ratio: float
    """Friction over that before [-]."""

    play_m: float
    """Backlash that was added [m]."""

    prior_weight: float
    """Weight of the prior, chosen on the blocks that were held out [-]."""

    zeros_m: list[float]
    """Zeros of the tendons [m]."""


@dataclass(frozen=True, kw_only=True)
class FrankaResult(_Outcome):
    """Recorded friction of a joint of a Franka arm: two speeds are fitted, the third is predicted."""

    ridge: list[float]
    """Ridge of the map's fit, for each speed that is predicted."""

    rows: list[FrankaRow]
    """One for each model."""


@dataclass(frozen=True, kw_only=True)
class FrankaRow(_Outcome):
    """One model."""

    all_rows_n_m: list[float | None]
    """Root mean square error over all rows of each recording; none where a prediction is not finite [N m]."""

    is_published: bool
    """True for predictions that come with the data."""

    method: str
    """Name."""

    tared_n_m: list[float] | None = None
    """The same after the first seconds, whose mean error is taken off: fitted models alone [N m]."""


@dataclass(frozen=True, kw_only=True)
class FreeRow(_Outcome):
    """One method on contact-free trajectories."""

    contacts: FalseContacts
    """Rows with a contact that is none."""

    norm_n: float
    """Mean norm of the force [N]."""


@dataclass(frozen=True, kw_only=True)
class FrictionResult(_Outcome):
    """Friction of a joint by one method."""

    averaged_error_n_m: list[float]
    """The same from means of 200 trials [N m]."""

    folds_n_m: list[list[float]]
    """Training and test error of every fold [N m]."""

    joint: int
    """The joint, from 1."""

    method: str
    """The method."""

    parameters: list[float]
    """Parameters of its law."""

    single_error_n_m: list[float]
    """Root mean square and largest error of the curve from single trials [N m]."""


@dataclass(frozen=True, kw_only=True)
class FtdcrMetrics(_Outcome):
    """The numbers of `study ftdcr`."""

    folds: list[FoldResult]
    """One for each fold."""

    pooled: list[MethodError]
    """Errors over all folds."""


@dataclass(frozen=True, kw_only=True)
class GenerateOutcome(_Outcome):
    """The outcome of `generate`: the card of a data set."""

    areas_m2: list[float]
    """Area that the tip goes over, and the robot's [m²]; convex hulls."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    dropped: int
    """Skipped trajectories."""

    extrapolating: float
    """Part of the samples in which the network left its training range [-]."""

    families: dict[str, int]
    """Samples by family."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    made: int
    """Trajectories in the set."""

    outside: float
    """Part of the samples outside what the robot's tip went over [-]."""

    outside_validation: float | None = None
    """Part of the samples in which a chain was bent further than it was validated [-]."""

    plan: str
    """Name of the plan."""

    robot: str
    """Name of the robot."""

    rows: list[SyntheticTrajectory]
    """One of each trajectory."""

    samples: int
    """Samples of all."""

    samples_real: int
    """Samples of the recordings of the robot."""

    scaled: Scaled | None = None
    """How it was brought within the calibrated range, if it is the default plan."""

    scene_sha256: str
    """Hash of the scene and its mesh."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class GoalSummary(_Outcome):
    """How the goals of a run were met."""

    largest_distance_at_s: float
    """Time of the sample in which it was [s]."""

    largest_distance_m: float
    """Largest distance of the tip from its goal [m]."""

    out_of_reach: int
    """Goals that the tip did not come so close to."""

    tolerance_m: float
    """Distance that counts as reached [m]."""


@dataclass(frozen=True, kw_only=True)
class Health(_Outcome):
    """Health of all servos."""

    baseline: str | None = None
    """Baseline of the comparison."""

    servos: list[ServoHealth]
    """Servo by servo."""

    time_s: list[float]
    """Middle of every window, in time of recording, one recording after the other [s]."""


@dataclass(frozen=True, kw_only=True)
class HeldOutError(_Outcome):
    """Error on blocks that were held out."""

    kept: AdaptedParts
    """Parts that would be kept."""

    rms_m: float
    """Root mean square distance of the tip [m]."""


@dataclass(frozen=True, kw_only=True)
class HoldErrors(_Outcome):
    """A hold with nominal parameters."""

    hold: int
    """Its number, from 1."""

    marker_error_mm: list[float]
    """Distance of every marker [mm]."""

    rmse_mm: float
    """Root mean square of these [mm]."""

    session: str
    """Its session."""

    tensions_n: list[float]
    """Tensions of both tendons [N]."""


@dataclass(frozen=True, kw_only=True)
class HorizonGradient(_Outcome):
    """Gradient of the loss over a horizon, mean of the rollouts."""

    by_torque: float
    """Mean size of the gradient by the torque of a step [1/(N m)]."""

    by_weights: float
    """Size of the gradient by the weights [-]."""

    cosine: float
    """Cosine of the gradient by the weights with that of 128 steps [-]."""

    steps: int
    """The horizon [steps]."""


@dataclass(frozen=True, kw_only=True)
class IdentificationOptions(_Outcome):
    """How much is simulated."""

    seeds: int
    """Noise seeds 1 to this."""


@dataclass(frozen=True, kw_only=True)
class IdentifiedRecording(_Outcome):
    """A recording and the result of its identification."""

    after: DistanceSummary
    """And with them."""

    before: DistanceSummary
    """Distance of the tip from the measured one without auxiliary tendons."""

    gaps: int
    """Samples whose tip had been filled in: strokes were held there."""

    name: str
    """Its name."""

    qps: list[int]
    """QPs solved, almost solved, infeasible and failed; only those solved were used."""

    samples: int
    """Samples in all."""

    samples_at_bound: list[int]
    """Samples in which at least one stroke was at this bound: lower, upper, rate."""

    samples_outside_validation: int | None = None
    """Samples in which a chain was bent further than it was validated."""

    share_at_bound: list[float]
    """The same for strokes, of all strokes in all samples [-]."""


@dataclass(frozen=True, kw_only=True)
class IdentifyOutcome(_Outcome):
    """The outcome of `identify`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    left_out: list[str]
    """Recordings that were not used, and why."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    recordings: list[IdentifiedRecording]
    """One entry per recording that was identified."""

    scene_sha256: str
    """Hash of the scene and its mesh."""

    verdict: Verdict
    """Whether a network can learn from the auxiliary strokes."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class IdentifyServoOutcome(_Outcome):
    """The outcome of `identify-servo`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"] | Literal["hysteron-identification"]
    """Format of the file."""

    law: str
    """Law of friction."""

    period_s: float
    """Time from one sample to the next [s]."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    recordings: list[list[str]]
    """Name and SHA-256 of every recording."""

    servos: list[ServoEstimates]
    """One entry per servo."""

    slowest_rad_s: float
    """Speed below which no motion counts as steady [rad/s]."""

    verdict: Verdict
    """Whether the numbers can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class Imported(_Outcome):
    """Imported recordings."""

    columns: str
    """The map: a name or a file."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    gaps: int
    """Samples that were not measured and are filled in."""

    joints: int
    """Joints of an arm, 0 of a tendon robot."""

    left_out: int
    """Rows of the sources that were skipped."""

    recordings: list[ImportedRecording]
    """One entry per recording."""

    rows: int
    """Samples of all recordings."""

    verdict: str
    """Whether the recordings can be used, in one sentence."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class ImportedRecording(_Outcome):
    """A recording."""

    channels: list[ChannelRange]
    """One entry per channel."""

    duration_s: float
    """Time from the first to the last sample [s]."""

    episode: str | None = None
    """The value of the episode's column."""

    gaps: int
    """Samples that were not measured and are filled in."""

    left_out: int
    """Rows of the source that were skipped."""

    out: str
    """Its file."""

    rate_hz: float | None = None
    """Rate [Hz]; none where rows have uneven times."""

    rows: int
    """Number of samples."""


@dataclass(frozen=True, kw_only=True)
class InverseMetrics(_Outcome):
    """The numbers of `study inverse`; a robot without recordings is skipped."""

    ftdcr: SegmentsResult | None = None
    """The three-segment robot."""

    trunk: TrunkResult | None = None
    """The trunk."""


@dataclass(frozen=True, kw_only=True)
class InverseRecurrentOptions(_Outcome):
    """How to train."""

    base: BaseMap | None = None
    """The map that the network corrects."""

    ema: float
    """Part of the exponential moving average of the weights that each update replaces."""

    ends_after: int | None = None
    """Epochs after which it ends, without validation data; none where validation chooses."""

    epochs: int
    """Most epochs."""

    filters_s: list[float]
    """Time constants of first-order filters [s]."""

    half_width_s: float
    """Half the time that they span [s]."""

    hidden: int
    """Hidden units of each layer."""

    horizons_s: list[float]
    """Times ahead at which features of the path are taken [s]; with [`PathSmoothing::Causal`] and none, a path
    need not be known in advance."""

    input_noise: float
    """Width of the uniform noise on normalised inputs while training, against overfitting."""

    largest_delay_s: float
    """Largest delay of the tip behind its strokes that is sought [s]; none is where it is zero, as for a path
    that is not known in advance."""

    layers: int
    """LSTM layers."""

    learning_rate: float
    """Step size of Adam at the start; it decays to a hundredth along half a cosine."""

    loss: LossWeights
    """Weights of the terms of the loss."""

    patience: int
    """Epochs without a better validation error after which it ends."""

    plays: list[float]
    """Plays as parts of the largest stroke."""

    seed: int
    """Seed of weights and noise."""

    slow_m_s: float
    """Speed at which the direction counts about half [m/s]."""

    smoothing: PathSmoothing
    """Which samples positions and rates come from."""

    truncation: int
    """Truncation length: samples between two updates, and of back-propagation through time."""

    weights: WeightFormat
    """Number format of the weights where the controller commands."""


@dataclass(frozen=True, kw_only=True)
class InverseTraining(_Outcome):
    """The training of an inverse controller: data, options, errors in validation."""

    base_stroke_rmse_mm: list[float] | None = None
    """The same of the map that the network corrects, or of the static regression beside a network that has none
    [mm]."""

    candidate: Candidate | None = None
    """Which of the controllers that were compared it is; none where there was no comparison."""

    command: str | None = None
    """The command."""

    commit: str | None = None
    """Commit of the program."""

    delay_s: float | None = None
    """Delay of the tip behind the strokes [s]."""

    design: TrainedDesign | None = None
    """The design."""

    epochs: int | None = None
    """Epochs after which the weights were found."""

    folds: int | None = None
    """Folds that the errors in validation are of: it was then fitted to all recordings."""

    gradient_floor_relative_error: float | None = None
    """Error of the gradient that the floor of derivatives makes, over its length, of the published design [-]."""

    held_out: list[TrainedOn] | None = None
    """Validation recordings."""

    held_out_stroke_rmse_mm: list[float] | None = None
    """Root mean square error of each stroke in validation [mm]."""

    options: InverseOptions | None = None
    """Options; none where a program of another version wrote them."""

    trained_on: list[TrainedOn] | None = None
    """Training recordings."""

    twin: LeadingTwin | None = None
    """The twin that finds the strokes where it leads the tip closer than the network in validation."""

    version: str | None = None
    """Version of the program."""

    weights: WeightErrors | None = None
    """Errors from the number format of the weights, where it is not that of the training."""


@dataclass(frozen=True, kw_only=True)
class JointMotionRange(_Outcome):
    """How far and how fast a joint went, in its unit."""

    fastest: float
    """Largest speed [rad/s or m/s]."""

    least: float
    """Smallest coordinate [rad or m]."""

    most: float
    """Largest coordinate [rad or m]."""

    name: str
    """Name of the joint."""


@dataclass(frozen=True, kw_only=True)
class JointSummary(_Outcome):
    """A joint in numbers."""

    mass_kg: float
    """Mass of what moves with it and with no later joint [kg]."""

    name: str
    """Name."""

    range: list[float] | None = None
    """Smallest and largest coordinate [rad or m]; none where the file has no limits."""


@dataclass(frozen=True, kw_only=True)
class LayoutMetrics(_Outcome):
    """The numbers of `study layouts`."""

    ladder: TwinTable
    """Twins of the ablation with these layouts."""

    layouts: list[LayoutReach]
    """One for each layout."""


@dataclass(frozen=True, kw_only=True)
class LayoutReach(_Outcome):
    """The identification with a layout."""

    layout: str
    """Name of the layout."""

    left_median_p99_mm: list[float]
    """Median and 99th percentile of the distance left, each in the mean of the recordings [mm]."""

    singular_values: list[float]
    """Singular values of ∂tip/∂s*, in the median of all samples [-]."""


@dataclass(frozen=True, kw_only=True)
class LeadingTwin(_Outcome):
    """A twin that leads the tip closer than the network that learned from it; its files are named from the
    folder of the checkpoint."""

    residual: str | None = None
    """Its residual network."""

    residual_sha256: str | None = None
    """SHA-256 of that file."""

    scene: str
    """Its scene."""

    scene_sha256: str
    """Hash of the scene and its mesh."""

    tip_rmse_mm: float
    """Its error of the tip in validation, root mean square [mm]."""


@dataclass(frozen=True, kw_only=True)
class LevelResult(_Outcome):
    """An ablation level."""

    aligned_rmse_mm: float | None = None
    """Root mean square distance from where the tip was to be at that time [mm]."""

    iou: float | None = None
    """Overlap [-]."""

    lag_ms: float | None = None
    """Lag behind the target [ms]."""

    nrmse_percent: float | None = None
    """NRMSE [%]."""

    rung: str
    """Name of the level."""


@dataclass(frozen=True, kw_only=True)
class LiveEstimates(_Outcome):
    """Estimates while a follower followed its leader."""

    age_ms: TimePercentiles
    """Time from reading the servos to the estimate."""

    contact: float
    """Part of the estimated samples in contact [-]."""

    contacts: int
    """Contacts that began."""

    filled_in: int
    """Samples that were not measured and are filled in."""

    healthy_at_end: float | None = None
    """Probability that the watched motor is healthy at the last sample [-]; none without an estimate."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    late_cycles: int
    """Cycles that came late."""

    rate_hz: float
    """Rate of the bus [Hz]."""

    recording: str
    """The recording."""

    rows: int
    """Number of samples."""

    step_ms: TimePercentiles
    """Time that a step of the estimator takes."""


@dataclass(frozen=True, kw_only=True)
class LoadedMeans(_Outcome):
    """Errors over the arms: one value for each task, then their mean; null where there is no trajectory of a
    task."""

    labelled_n: list[float | None]
    """Mean of three axes over rows with a label [N]."""

    mean_n: list[float | None]
    """Mean of three axes over all rows, rows without a label as 0 N [N]."""

    norm_n: list[float | None]
    """Norm of the error over rows with a label [N]."""

    z_n: list[float | None]
    """Along z over rows with a label [N]."""


@dataclass(frozen=True, kw_only=True)
class LockingComparison(_Outcome):
    """The same command for linear and ten-node tetrahedra."""

    command: str
    """Command that moves the tip."""

    loss: float
    """Share of the tip's motion that this mesh loses [-]; negative where it moves farther."""

    stiffness_ratio: float
    """How many times stiffer this mesh is, in tension (or load) per motion of the tip [-]."""

    tension_n: float
    """Largest tension with this mesh [N]."""

    tension_ten_node_n: float
    """The same with ten-node tetrahedra [N]."""

    tip_m: float
    """Distance of the tip from rest with this mesh [m]."""

    tip_ten_node_m: float
    """The same with ten-node tetrahedra [m]."""


@dataclass(frozen=True, kw_only=True)
class LossWeights(_Outcome):
    """Weights of the terms."""

    co_contraction_min_m: float
    """Least mean of all strokes [m]."""

    pull: float
    """Of the missing common pull [-]."""

    smooth_s: float
    """Time for which an error that changes counts as much as one of that size [s]."""

    tip: float
    """Of the tip's error over that of the strokes [-]."""


@dataclass(frozen=True, kw_only=True)
class Machine(_Outcome):
    """A machine: what times depend on."""

    cpu: str | None = None
    """Processor, where the system names it."""

    isa: str | None = None
    """Set of instructions that kernels use."""

    threads: int
    """Threads."""


@dataclass(frozen=True, kw_only=True)
class Means(_Outcome):
    """Mean and spread over the seeds of one variant, learning from the most trajectories."""

    joints: list[float]
    """Torque of every joint, at the first speed."""

    mse: list[float]
    """Mean squared errors of the same at the first speed [N² m²]."""

    nmse: list[list[float]]
    """Normalised errors of torque, inertial, Coriolis and gravity torque at every speed [-]."""

    parameters: int
    """Parameters of the model."""

    power_mse: float
    """Mean squared error of the power [W²]."""

    seconds: float
    """Time of a training [s]."""

    spread: list[float]
    """Their standard deviations over the seeds, at the first speed."""

    variant: Variant
    """The model."""


@dataclass(frozen=True, kw_only=True)
class MeshOutcome(_Outcome):
    """The outcome of `mesh`."""

    groups: dict[str, int]
    """Number of nodes in each group, by its name."""

    nodes: int
    """Number of nodes."""

    out: str
    """The file."""

    radius_ratio: Spread
    """Three times the radius of the inscribed over that of the circumscribed sphere [-]: 1 for a regular
    tetrahedron."""

    smallest_angle_rad: Spread
    """Smallest angle between two faces [rad]."""

    tetrahedra: int
    """Number of tetrahedra."""

    volume_m3: float
    """Volume of the body [m³]."""


@dataclass(frozen=True, kw_only=True)
class MeshResolution(_Outcome):
    """One mesh under the pull; null where it was not reached."""

    deflection_mm: list[float | None]
    """Deflection of the tip there [mm]."""

    failure: str | None = None
    """Why no more was reached."""

    law: str
    """Law of the material."""

    mesh: str
    """Name of the mesh."""

    n_unknowns: int
    """Degrees of freedom."""

    order: int
    """Order of its tetrahedra."""

    reached_mm: float
    """Stroke that was reached [mm]."""

    ring_mm: float
    """Radius of the rings that carry tendon points; 0 for points [mm]."""

    stroke_mm: list[float]
    """Strokes reported [mm]."""

    tension_n: list[float | None]
    """Tension of the pulled tendon there [N]."""


@dataclass(frozen=True, kw_only=True)
class MeshSummary(_Outcome):
    """Size and quality of a mesh."""

    groups: dict[str, int]
    """Number of nodes in each group, by its name."""

    nodes: int
    """Number of nodes."""

    radius_ratio: Spread
    """Three times the radius of the inscribed over that of the circumscribed sphere [-]: 1 for a regular
    tetrahedron."""

    smallest_angle_rad: Spread
    """Smallest angle between two faces [rad]."""

    tetrahedra: int
    """Number of tetrahedra."""

    volume_m3: float
    """Volume of the body [m³]."""


@dataclass(frozen=True, kw_only=True)
class MethodError(_Outcome):
    """Error of a method."""

    method: str
    """Name of the method."""

    rmse_mm: float
    """Root mean square error of the tip [mm]."""


@dataclass(frozen=True, kw_only=True)
class MethodErrors(_Outcome):
    """Errors of one method, both joints."""

    error_n_m: list[float]
    """Mean error [N m]."""

    error_percent: list[float]
    """The same over the mean torque [%]."""

    name: str
    """Name of the method."""


@dataclass(frozen=True, kw_only=True)
class MethodRuns(_Outcome):
    """A method on a path: a value for every seed whose strokes the rig ran, and repeat."""

    aligned_rmse_mm: list[float | None]
    """Root mean square distance at equal times [mm]."""

    iou: list[float]
    """Overlap [-]."""

    lag_ms: list[float | None]
    """Lag behind the target [ms]."""

    method: str
    """Name of the method."""

    nrmse_percent: list[float]
    """NRMSE [%]."""

    seeds_refused: int
    """Seeds whose strokes the rig did not run."""


@dataclass(frozen=True, kw_only=True)
class MotionErrors(_Outcome):
    """Root mean square distance of the twin's tip from the measured one [m]."""

    after_m: float
    """With the adapted model, this motion in its training; as before where nothing was kept."""

    before_m: float
    """With the model as it was."""

    extrapolating: float
    """Part of the samples in which the network was outside its training range; the fit does not use them [-]."""

    name: str
    """Name of the motion."""


@dataclass(frozen=True, kw_only=True)
class NamedShape(_Outcome):
    """Numbers of one recording, for `metrics.json`."""

    diamond_ratio: float | None = None
    """See [`ShapeNumbers::diamond_ratio`]."""

    excursion_m: float
    """See [`ShapeNumbers::excursion_m`]."""

    name: str
    """Name of the recording."""

    return_error: float
    """See [`ShapeNumbers::return_error`]."""

    tip_per_stroke: float
    """See [`ShapeNumbers::tip_per_stroke`]."""


@dataclass(frozen=True, kw_only=True)
class NeuralCell(_Outcome):
    """An actuator of one seed compared with its baselines on the test tasks of a split."""

    condition_accuracy_auc: list[float] | None = None
    """Accuracy and area under the curve of the condition, sample by sample [-]; none unless both conditions are
    there."""

    detectors: list[DetectorScores] | None = None
    """Detectors of a degraded motor; none without a network of force and condition, or where a condition is
    missing."""

    force_from: ForceSource
    """Network that gives the force."""

    forces: ForcesBySource
    """Errors of the forces, all tasks together."""

    format: Literal["hysteron-neural-evaluation"]
    """Format of the comparison."""

    gradients: list[HorizonGradient] | None = None
    """Gradients of the loss by horizon, of the first seed alone; none without trajectories that are long enough."""

    left_out: list[str] | None = None
    """Criterion by which recordings were excluded from the training; none where that is not known."""

    mean_deg: ByMethod
    """Mean absolute error of the joints over the first steps of rollouts, mean of the tasks [deg]."""

    mean_gripper_mm: ByMethod
    """The same of the aperture [mm]; none without a gripper."""

    parameters: int
    """Number of parameters of the network in the loop."""

    tasks: list[TaskScores]
    """One entry per task."""

    traces: list[TaskTrace | None] | None = None
    """Trajectories for figures, of the first seed alone; null for a task that is not there."""

    trained_on: int
    """Number of trajectories that it was trained on."""

    validation_deg: float
    """Root mean square error of the joints in rollouts of the validation trajectories [deg]."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class NeuralStudy(_Outcome):
    """The study, split by split and network by network."""

    faults: list[list[FaultCell]]
    """Splits of [`FAULT_SPLITS`], seed by seed; empty without such data."""

    left_out: list[list[NeuralCell]]
    """Splits of [`LEFT_OUT`], seed by seed; empty where networks alone are compared, as are faults."""

    networks: list[list[NeuralCell]]
    """Networks of [`NETWORKS`] but the first, seed by seed."""

    published: list[NeuralCell]
    """The first network of [`NETWORKS`] on the published split, seed by seed."""


@dataclass(frozen=True, kw_only=True)
class Numbers(_Outcome):
    """The quantities at one time."""

    friction_pulling_percent: Estimate | None = None
    """Dry friction pulling, of full load [%]."""

    friction_releasing_percent: Estimate | None = None
    """Dry friction releasing, of full load [%]."""

    lost_motion_mm: Estimate | None = None
    """Lost motion [mm]."""

    temperature_degc: float | None = None
    """Mean temperature [°C]."""


@dataclass(frozen=True, kw_only=True)
class Outcome(_Outcome):
    """The outcome of `evaluate`, and of `track` along a path."""

    command: str
    """The command that made this."""

    commanded: Commanded | None = None
    """How the strokes were commanded, where that is known."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    health: Health | None = None
    """Condition of the rig's servos, where the recordings were made by the same command."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    recordings: list[RecordingScore]
    """One entry per recording."""

    repeatability: dict[str, Repeatability] | None = None
    """By metric, over the recordings, where they are repeats of one result."""

    results: list[ComparedResult] | None = None
    """Results that are compared, where they have names."""

    target: TargetSummary
    """The target."""

    verdict: Verdict
    """Whether the tip follows the target."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class ParameterEstimate(_Outcome):
    """A number that was identified."""

    name: str
    """Name with its unit."""

    note: str
    """Note on its identifiability; empty where there is nothing to note."""

    standard_error: float | None = None
    """Standard error; none where there is no estimate of it."""

    value: float
    """Value."""


@dataclass(frozen=True, kw_only=True)
class ParameterFit(_Outcome):
    """A set of fitted parameters."""

    converged: bool
    """Whether the fit converged."""

    left_out_mean_of_markers_rmse_mm: float
    """The same of holds that were not fitted [mm]."""

    mean_of_markers_rmse_mm: float
    """Mean of the markers' root mean square errors [mm]."""

    parameters: list[FittedValue]
    """Its parameters."""

    set: str
    """Name of the set."""


@dataclass(frozen=True, kw_only=True)
class ParameterValue(_Outcome):
    """A fitted parameter."""

    name: str
    """Name of the parameter."""

    value: float
    """Its value."""


@dataclass(frozen=True, kw_only=True)
class Parts(_Outcome):
    """Σ over joints of mean squared error over variance: the nMSE of table 5 [-]."""

    coriolis: float
    """Of c."""

    gravity: float
    """Of g."""

    inertial: float
    """Of H q̈."""

    torque: float
    """Of the torque."""


@dataclass(frozen=True, kw_only=True)
class PathDifference(_Outcome):
    """How far two recorded paths of the same commands are apart, in the horizontal plane."""

    aligned_rmse_mm: float | None = None
    """Root mean square distance at equal times [mm]."""

    chamfer_mm: float
    """Chamfer distance [mm]."""

    frechet_mm: float
    """Fréchet distance [mm]."""

    hausdorff_mm: float
    """Hausdorff distance [mm]."""

    lag_s: float | None = None
    """Lag of the second path [s]."""


@dataclass(frozen=True, kw_only=True)
class PathErrors(_Outcome):
    """NRMSE on a test trajectory, one for each seed or robot."""

    path: str
    """Name of the trajectory."""

    x_percent: list[float]
    """Along x [%]."""

    y_percent: list[float]
    """Along y [%]."""

    z_percent: list[float]
    """Along z [%]."""


@dataclass(frozen=True, kw_only=True)
class PathScore(_Outcome):
    """Errors of a path."""

    axes: list[AxisScore]
    """Along x, y and z."""

    max_m: float
    """Largest distance [m]."""

    rmse_m: float
    """Root mean square distance [m]."""

    samples: int
    """Samples compared: those that were measured."""


@dataclass(frozen=True, kw_only=True)
class PlannedInput(_Outcome):
    """A file that workers read."""

    name: str
    """Its name."""

    sha256: str
    """SHA-256 of its bytes, and its name in the set."""


@dataclass(frozen=True, kw_only=True)
class PooledError(_Outcome):
    """Errors over several holds, compared with rod models."""

    over: str
    """The holds, and how markers are pooled."""

    own_rod_mm: float | None = None
    """Of a rod model of the project's own [mm]."""

    published_rod_mm: float | None = None
    """Of the published rod model [mm]."""

    rmse_mm: float
    """Of this twin [mm]."""


@dataclass(frozen=True, kw_only=True)
class PopulationMetrics(_Outcome):
    """The numbers of `study population`."""

    robots: list[PopulationRobot]
    """One for each robot."""


@dataclass(frozen=True, kw_only=True)
class PopulationPath(_Outcome):
    """A path by every method."""

    methods: list[FollowedMethod]
    """One for each method."""

    target: str
    """The path."""


@dataclass(frozen=True, kw_only=True)
class PopulationRobot(_Outcome):
    """A robot along every path, or why there is nothing."""

    failed: str | None = None
    """Why a stage failed on it."""

    paths: list[PopulationPath] | None = None
    """One for each path."""

    robot: str
    """The robot."""


@dataclass(frozen=True, kw_only=True)
class Port(_Outcome):
    """A serial port."""

    description: str
    """Its description by the system."""

    port: str
    """Its device file."""


@dataclass(frozen=True, kw_only=True)
class PortCounts(_Outcome):
    """Traffic on an emulated port."""

    answers: int
    """Answers sent."""

    instructions: int
    """Instructions with a right checksum."""


@dataclass(frozen=True, kw_only=True)
class PoseScores(_Outcome):
    """Mean absolute errors of poses over the first steps of rollouts."""

    gripper_mm: float | None = None
    """Of the aperture [mm]."""

    joints_deg: list[float]
    """Of each joint [deg]."""

    trajectories: int
    """Trajectories."""


@dataclass(frozen=True, kw_only=True)
class PredictedPath(_Outcome):
    """A trajectory that was not in the twin's training."""

    trajectory: str
    """Name of the trajectory."""

    with_: PathScore = field(metadata={"key": "with"})
    """Score of the twin with it."""

    without: PathScore
    """Score of the twin without its network."""


@dataclass(frozen=True, kw_only=True)
class Proposed(_Outcome):
    """A map to edit."""

    map: str
    """Its text."""

    out: str
    """Its file, or `-` for the console."""


@dataclass(frozen=True, kw_only=True)
class PublishedRow(_Outcome):
    """A row of a published table."""

    mse: list[float]
    """Mean squared error of every joint [N² m²]."""

    name: str
    """Name of the model in the paper."""

    pooled_r2: float
    """(11), about one mean of all joints."""


@dataclass(frozen=True, kw_only=True)
class PublishedSuccess(_Outcome):
    """A printed row."""

    task: Task
    """The task."""

    trials: int
    """Its trials."""

    with_force: int
    """Successes of the policy with a force."""

    without_force: int
    """Successes of the policy without a force."""


@dataclass(frozen=True, kw_only=True)
class Reach(_Outcome):
    """Reachability of a target by a robot's twin."""

    goals: int
    """Goals along the curve that were tried: once one is out of reach, fewer."""

    largest_distance_at_m: list[float]
    """The goal at which it was, from where the tip rests [m]."""

    largest_distance_m: float
    """Largest distance of the tip from its goal [m]."""

    out_of_reach: int
    """Those that the tip did not come so close to."""

    scene: str
    """Name of the robot."""

    scene_sha256: str
    """SHA-256 of its scene."""

    tension_max_n: float
    """Largest tension of a tendon [N]."""

    tolerance_m: float
    """Distance that counts as reached [m]."""


@dataclass(frozen=True, kw_only=True)
class RealOptions(_Outcome):
    """How the models of a set are found."""

    activation: Activation
    """Between layers."""

    features: int
    """Fourier features."""

    hidden: list[int]
    """Units of every hidden layer."""

    lengths: list[float]
    """Lengths of theirs that are tried, in spreads."""

    members: int
    """Networks whose mean is taken."""

    stride: int
    """Every so many samples are used in fits."""

    training: TrainingOptions
    """How networks are trained."""

    variants: list[Variant]
    """Learned models."""


@dataclass(frozen=True, kw_only=True)
class RealRow(_Outcome):
    """One model on one set."""

    choice: str
    """The choice, in words."""

    mean_r2: float
    """Mean over the joints of R² about their own means."""

    mse: list[float]
    """Mean squared error of every joint on the test [N² m²]."""

    name: str
    """Name of the model."""

    pooled_r2: float
    """(11), about one mean of all joints."""

    shown: list[float] | None = None
    """Torques at [`shown_samples`] of the test, [sample][joint] [N m]."""

    sum_mse: float
    """Their sum."""

    validation: float
    """Validation error that chose it: mean nMSE of a joint on validation trajectories [-]."""


@dataclass(frozen=True, kw_only=True)
class Reason(_Outcome):
    """A number that was compared with its limits."""

    care_above: float
    """Above this a result is usable with care."""

    criterion: Criterion
    """Criterion of the number."""

    not_usable_above: float | None = None
    """Above this it is not usable."""

    statement: str
    """Statement of the number, as part of a sentence."""

    usability: Usability
    """Usability by this number alone."""

    value: float | None = None
    """The number; none where it is not finite."""


@dataclass(frozen=True, kw_only=True)
class RecordOutcome(_Outcome):
    """The outcome of `record`: its recordings, and with a report what they show."""

    command: str
    """The command that made the first recording."""

    commit: str
    """Commit of the program that made it."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    health: Health | None = None
    """Condition of the servos, of a rig that has some."""

    samples: int
    """Samples of all recordings."""

    shapes: list[NamedShape] | None = None
    """Command and tip over each other, of the recordings that are drawn."""

    source: str
    """Provenance of the first recording."""

    tip_range_m: list[list[float]] | None = None
    """Smallest and largest x, y and z of the tip over all recordings [m]."""

    trajectories: list[RecordedTrajectory]
    """One entry per trajectory."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class Recorded(_Outcome):
    """Repeats of recorded strokes."""

    health: Health | None = None
    """Condition of the servos, of a rig that has some."""

    out: str
    """Folder of the recordings."""

    repeats: list[str]
    """The recordings."""


@dataclass(frozen=True, kw_only=True)
class Recorded2(_Outcome):
    """Models of recorded arms."""

    left_out: list[str]
    """Sets that were not there."""

    options: RealOptions
    """How models were found."""

    tables: list[RecordedTable]
    """One for each set."""


@dataclass(frozen=True, kw_only=True)
class RecordedTable(_Outcome):
    """Models of one recorded arm."""

    cutoff_hz: float
    """Cut-off of the low-pass filter [Hz]."""

    published: list[PublishedRow]
    """The same models as published, where they are."""

    rows: list[RealRow]
    """One for each model."""

    set: str
    """Its name."""

    test_samples: int
    """Samples that errors are of."""

    training: list[int]
    """Samples and trajectories that models were chosen by."""


@dataclass(frozen=True, kw_only=True)
class RecordedTrajectory(_Outcome):
    """One trajectory."""

    events: int
    """Events beyond the course of the run."""

    filled_in: int
    """Samples that were not measured and are filled in."""

    name: str
    """Name of the trajectory."""

    role: str
    """Role of the recording: training, validation or test."""

    rows: int
    """Number of samples."""

    timing: StatsSummary | None = None
    """Timing of the cycles, on a rig."""


@dataclass(frozen=True, kw_only=True)
class RecordingEstimates(_Outcome):
    """Estimates along a recording."""

    contact: float
    """Part of the samples in contact [-]."""

    healthy_at_end: float
    """Probability that the watched motor is healthy at the last sample [-]."""

    held_joints: list[str] | None = None
    """Joints that `--fix-base` holds at zero."""

    out: str
    """The recording of the estimates."""

    rows: int
    """Number of samples."""


@dataclass(frozen=True, kw_only=True)
class RecordingFindings(_Outcome):
    """Recordings, and what was found in them."""

    errors: int
    """Number of findings that cannot be right, unreadable files included."""

    findings: list[Warning]
    """All findings."""

    recordings: list[Described]
    """One for each recording."""

    scene: SceneSummary | None = None
    """The scene that the recordings were compared with."""

    unreadable: list[list[str]]
    """Files that could not be read, and why."""

    warnings: int
    """Number of warnings."""


@dataclass(frozen=True, kw_only=True)
class RecordingScore(_Outcome):
    """A recording and its score."""

    aligned_rmse_m: float | None = None
    """Root mean square distance at the same times [m]; none where times do not compare."""

    chamfer_m: float
    """Symmetric Chamfer distance [m]."""

    frechet_m: float
    """Discrete Fréchet distance, samples of the target against those of the path [m]; of closed targets the
    smallest over all beginnings."""

    hausdorff_m: float
    """Hausdorff distance [m]."""

    iou: float | None = None
    """Polygon IoU, mean over the laps [-]; none where the target is open."""

    lag_s: float | None = None
    """By how much the path comes late [s]; none where times do not compare."""

    name: str
    """Name of the recording."""

    nrmse: float | None = None
    """Mean over x and y of that RMSE over the target's range along the axis (eq. 19) [-]; none where the target
    is straight along an axis."""

    result: str | None = None
    """The result that it is a repeat of, where results are compared."""

    rmse_axes_m: list[float]
    """The two RMSE [m]."""

    rmse_m: float
    """Mean of the RMSE along x and along y from the points of the target to the nearest of the path (eqs. 21,
    22) [m]."""

    samples: int
    """Samples of the path that count."""

    sha256: str
    """SHA-256 of its file."""

    source: str
    """Its provenance."""


@dataclass(frozen=True, kw_only=True)
class ReduceOutcome(_Outcome):
    """The outcome of `reduce`."""

    errors: Validation
    """Errors against the mesh."""

    mesh_unknowns: int
    """Unknowns of the mesh."""

    out: str
    """The file."""

    scene_sha256: str
    """Hash of the scene and its mesh."""

    sections: int
    """Sections of the chain."""

    unknowns: int
    """Unknowns of the chain."""

    verdict: Verdict
    """Whether the chain can stand for the mesh."""


@dataclass(frozen=True, kw_only=True)
class Repeatability(_Outcome):
    """Mean and spread of one metric over repeats, in the metric's unit."""

    deviation: float
    """Standard deviation of the repeats, n - 1 in its denominator."""

    mean: float
    """Mean."""

    variation: float | None = None
    """Coefficient of variation, deviation over mean [-]; none where the mean is zero."""


@dataclass(frozen=True, kw_only=True)
class ResidualRecurrentOptions(_Outcome):
    """How to train."""

    ema: float
    """Part of the exponential moving average of the weights that each update replaces."""

    ends_after: int | None = None
    """Epochs after which it ends, without validation data; none where validation chooses."""

    epochs: int
    """Most epochs."""

    feedback: bool
    """Whether the twin's tip is an input of the network."""

    feedback_noise_m: float
    """Standard deviation of the noise on that tip while training [m], so that errors of the loop decay."""

    filters_s: list[float]
    """Time constants of first-order filters [s]."""

    hidden: int
    """Hidden units of each layer."""

    input_noise: float
    """Width of the uniform noise on normalised inputs while training, against overfitting."""

    layers: int
    """LSTM layers."""

    learning_rate: float
    """Step size of Adam at the start; it decays to a hundredth along half a cosine."""

    patience: int
    """Epochs without a better validation error after which it ends."""

    plays: list[float]
    """Plays as parts of the largest stroke."""

    seed: int
    """Seed of weights and noise."""

    truncation: int
    """Truncation length: samples between two updates, and of back-propagation through time."""


@dataclass(frozen=True, kw_only=True)
class ResidualTensions(_Outcome):
    """Residual tensions that bring the markers to where they were measured."""

    cables: int
    """Auxiliary cables."""

    readings: list[SharedTensions]
    """One for each way in which holds share them."""


@dataclass(frozen=True, kw_only=True)
class ResidualTraining(_Outcome):
    """The training of a residual network: data, options, errors in validation, later adaptation."""

    adapted_kept: AdaptedParts | None = None
    """Parts of the adaptation that were kept."""

    adapted_to: list[list[str]] | None = None
    """Names and SHA-256 of the recordings that the network was adapted to."""

    command: str | None = None
    """The command."""

    commit: str | None = None
    """Commit of the program."""

    data_sha256: list[str] | None = None
    """SHA-256 of the training recordings and then of the validation recordings, of the published design."""

    epochs: int | None = None
    """Epochs after which the weights were found, of the published design."""

    gradient_floor_relative_error: float | None = None
    """Error of the gradient that the floor of derivatives makes, over its length, of the published design [-]."""

    held_out: list[str] | None = None
    """Names of the validation recordings, of the published design."""

    held_out_stroke_rmse_mm: float | None = None
    """Root mean square error of the auxiliary strokes in validation, of the published design [mm]."""

    members: list[TrainedMember] | None = None
    """One entry per network, of the recurrent design."""

    networks_of_all: int | None = None
    """Networks that learned from all recordings, for as many epochs as `members` took in the mean, whose errors
    are those of validation; none where the networks are `members` themselves."""

    options: ResidualOptions | None = None
    """Options; none where a program of another version wrote them."""

    part: ResidualPart | None = None
    """The part that gains in validation, of the recurrent design; none in files of older programs, which hold
    the network."""

    scene: str | None = None
    """Hash of the scene, of the published design."""

    sequences: list[str] | None = None
    """Names of all recordings, of the recurrent design."""

    tip_band: TipBand | None = None
    """How far the tip may be off, by the recordings that were left out, of the recurrent design; none once it is
    adapted."""

    trained_on: list[str] | None = None
    """Names of the training recordings, of the published design."""

    version: str | None = None
    """Version of the program."""


@dataclass(frozen=True, kw_only=True)
class ResponseEstimate(_Outcome):
    """How measured torques follow those of the rigid arm."""

    lead_s: list[float]
    """Lead of the measured torque, joint by joint [s]."""

    rms_n_m: list[float]
    """Root mean square error of the torque with this response, joint by joint [N m]."""

    second_s2: list[float]
    """Coefficient of its second derivative, joint by joint [s²]."""

    test_rms_n_m: list[float] | None = None
    """The same on what was not fitted [N m]; none where all was."""


@dataclass(frozen=True, kw_only=True)
class RigCalibrateOutcome(_Outcome):
    """The outcome of `rig calibrate`."""

    calibration: str
    """The calibration file."""

    channels: list[ChannelCalibration]
    """One entry per tendon."""


@dataclass(frozen=True, kw_only=True)
class RigCheckOutcome(_Outcome):
    """The outcome of `rig check`."""

    joints: int | None = None
    """Joints of two arms."""

    ports: list[Port]
    """Serial ports of this machine."""

    servos: list[ServoSummary] | None = None
    """Servos of a rig."""

    tracker: TrackerSurvey | None = None
    """Tracker of a rig that has one."""


@dataclass(frozen=True, kw_only=True)
class RigRecoverOutcome(_Outcome):
    """The outcome of `rig recover`."""

    filled_in: int
    """Samples that were not measured and are filled in."""

    recording: str
    """The recording."""

    rows: int
    """Number of samples."""


@dataclass(frozen=True, kw_only=True)
class RobotSize(_Outcome):
    """Size of a robot's model."""

    auxiliary_tendons: int
    """Auxiliary tendons, which correct the twin."""

    chain: ChainSize | None = None
    """The chain that moves in place of the mesh, if there is one."""

    name: str
    """Name of the robot."""

    nodes: int
    """Nodes of its mesh."""

    scene_sha256: str
    """SHA-256 of its scene."""

    tendons: int
    """Tendons of the robot."""

    tetrahedra: int
    """Tetrahedra of its mesh."""

    unknowns: int
    """Degrees of freedom."""


@dataclass(frozen=True, kw_only=True)
class RobotsMetrics(_Outcome):
    """The numbers of `study robots`."""

    ladders: list[TwinTable]
    """Twins of the ablation of every preset, and those of `typical` on the population around it."""


@dataclass(frozen=True, kw_only=True)
class RodResolution(_Outcome):
    """All shapes with one resolution of the mesh."""

    error_percent_of_length: StationErrors
    """Distances from the reference."""

    iterations_per_shape: float
    """Iterations of Newton's method, mean over the shapes."""

    layers: int
    """Layers of the mesh."""

    n_unknowns: int
    """Degrees of freedom."""

    seconds_on_two_threads: float
    """Time of all shapes on two threads [s]."""

    shapes: int
    """Number of shapes."""

    sides: int
    """Sides of the section."""

    worst_relative_residual: float
    """Worst relative residual of a shape [-]."""


@dataclass(frozen=True, kw_only=True)
class Row(_Outcome):
    """A target on a robot, before and after adaptation; null where the rig did not carry the strokes out."""

    after: Tip | None = None
    """With the adapted network."""

    before: Tip | None = None
    """With the network of the robot as it was."""

    change: str
    """Change of the robot."""

    gain: float | None = None
    """Part of the error at equal times that adaptation took away [-]."""

    kept: AdaptedParts
    """Parts that the adaptation kept."""

    target: str
    """The target."""

    unchanged_robot_aligned_rmse_mm: float | None = None
    """Error of the twin on the unchanged robot along the target, at equal times [mm]."""


@dataclass(frozen=True, kw_only=True)
class Row2(_Outcome):
    """One row of the table."""

    against_nothing: list[list[int] | float] | None = None
    """Against the policy that observes plan and positions alone: trials that only this row, or only that one,
    masters, and the probability of a difference as large if both were alike (McNemar, exact)."""

    distance_mm: float
    """Median over the trials of the largest distance in the last seconds [mm]."""

    interval: list[float]
    """See `rate`."""

    method: str
    """Observation of the policy; none for the expert and for goals that do not lead."""

    rate: float
    """Successes over trials, and its 95 % interval (Wilson)."""

    successes: int
    """See `trials`."""

    task: Task
    """Task of the trials."""

    trials: int
    """Trials and successes."""


@dataclass(frozen=True, kw_only=True)
class RunLocking(_Outcome):
    """Reach of a run that moved the tip `reached` \\[m\\] at most, as ten-node tetrahedra would give it."""

    tip_m: float
    """Farthest that the tip was from rest [m]."""

    tip_ten_node_m: float
    """The same with ten-node tetrahedra, estimated [m]."""


@dataclass(frozen=True, kw_only=True)
class RunSummary(_Outcome):
    """Numbers of a run; written as they are into `metrics.json`."""

    against_measured: PathScore | None = None
    """How close the tip came to the measured one, if the strokes came with one."""

    clarabel_solves: int
    """QPs solved by clarabel."""

    duration_s: float
    """Time from the first to the last sample [s]."""

    exact: ExactSummary | None = None
    """How far the chain was off where the finite elements made a sample too, if that was requested."""

    extrapolated: float | None = None
    """Part of the samples in which the residual network left its training range, if there was one [-]."""

    goals: GoalSummary | None = None
    """How the goals were met, if there were any."""

    iterations: int
    """Corrections with the stale factor."""

    locking: RunLocking | None = None
    """Error by the locking of linear tetrahedra, where they can be compared with ten-node ones."""

    newton_iterations: int
    """Iterations of Newton's method, where the stale factor did not serve."""

    outside_validation: float | None = None
    """Part of the samples in which a chain was bent further than it was validated, if there was one [-]."""

    refactorisations: int
    """Times the factor was renewed."""

    rounds: int
    """QPs solved for strokes, each tried with one or several forward steps; none without goals."""

    samples: int
    """Samples in the recording."""

    steps: int
    """Samples simulated by this run; an earlier one may have done others."""

    sub_steps: int
    """Parts into which such steps were divided."""

    tendons: list[TendonSummary]
    """One entry per primary tendon."""

    tip_band: TipBandSummary | None = None
    """Where the robot's own tip is expected, by a network that learned with recordings left out."""

    tip_max_m: list[float]
    """See `tip_min_m`."""

    tip_min_m: list[float]
    """Smallest and largest coordinates of the tip [m]."""

    wall_s: float
    """Time the steps took [s]."""

    worst_relative_residual: float
    """Largest force residual over applied forces [-]."""

    worst_stroke_error_m: float
    """Largest error of a prescribed stroke [m]."""


@dataclass(frozen=True, kw_only=True)
class Scaled(_Outcome):
    """How the default plan was brought within the range that the twin was calibrated on."""

    range: CalibratedRange
    """The range."""

    scale: float
    """Its size over that of the built-in plan [-]."""


@dataclass(frozen=True, kw_only=True)
class ScaraMethod(_Outcome):
    """One method on one joint of the SCARA; errors are means over the seeds."""

    averaged_max_n_m: float
    """Largest error of that curve [N m]."""

    averaged_rms_n_m: float
    """Root mean square error of the curve from means of 200 trials [N m]."""

    folds_training_test_n_m: list[float]
    """Training and test error of the five folds, means over folds and seeds [N m]."""

    joint: int
    """The joint, from 1."""

    method: str
    """Name of the method."""

    parameters: list[float]
    """Parameters of its law, of the first seed."""

    single_max_n_m: float
    """Largest error of that curve [N m]."""

    single_rms_n_m: float
    """Root mean square error of the curve from single trials [N m]."""


@dataclass(frozen=True, kw_only=True)
class ScaraOptions(_Outcome):
    """How much is simulated."""

    seed: int
    """Seed of all draws."""

    stretches: int
    """Stretches of 300 s with collisions."""

    trials: int
    """Trials of 12 s in which the hand leads the arm."""


@dataclass(frozen=True, kw_only=True)
class SceneSummary(_Outcome):
    """A scene in numbers."""

    auxiliary_tendons: int
    """Auxiliary tendons, which correct the twin."""

    factor_bytes: int
    """Memory that the factor of the stiffness takes [byte]."""

    locking: LockingEstimate
    """Share of the motion that linear tetrahedra lose."""

    mass_kg: float
    """Mass of the body [kg]."""

    mesh: MeshSummary
    """The mesh."""

    robot: str
    """Name of the robot."""

    scene_sha256: str
    """SHA-256 of the scene."""

    tendons: int
    """Tendons of the robot."""

    tip_m: list[float]
    """Tip of the unloaded body [m]."""

    unknowns: int
    """Degrees of freedom."""

    warnings: list[str]
    """Warnings about the mesh, as sentences."""


@dataclass(frozen=True, kw_only=True)
class SegmentsResult(_Outcome):
    """Errors on the three-segment robot."""

    folds_mm: list[list[float]]
    """Errors of the strokes on test patterns, fold by fold and method by method [mm]."""

    methods: list[str]
    """Names of the methods."""


@dataclass(frozen=True, kw_only=True)
class SenseOutcome(_Outcome):
    """The outcome of `sense`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    recording: str
    """Name of the recording."""

    recording_sha256: str
    """SHA-256 of its file."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recording."""

    scores: SensingScores
    """How good the estimates are, where the truth is known."""

    sensor: ForceSensor
    """The sensor that made the estimates."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class SensedRobot(_Outcome):
    """The sensor of one robot."""

    robot: str
    """The robot."""

    scores: SensingScores
    """Scores of tensions and pushes, as `sense` gives them."""

    sensor: ForceSensor
    """The sensor, as `sense` gives it."""

    without_contact: WithoutContact
    """False alarms in recordings without contact."""


@dataclass(frozen=True, kw_only=True)
class SensingMetrics(_Outcome):
    """The numbers of `study sensing`."""

    robots: list[SensedRobot]
    """One for each robot."""


@dataclass(frozen=True, kw_only=True)
class SensingScores(_Outcome):
    """Scores of all estimates."""

    contacts: ContactScore | None = None
    """See `forces`; samples without pushes too."""

    forces: list[ForceScore]
    """Samples with a known force during pushes."""

    tensions: list[TensionScore]
    """Where tensions are known."""


@dataclass(frozen=True, kw_only=True)
class ServoEstimates(_Outcome):
    """A servo."""

    cannot_be_told: str | None = None
    """Why friction cannot be identified."""

    condition: float | None = None
    """Condition number of the parameters [-]."""

    estimates: list[ParameterEstimate]
    """The numbers that were found."""

    has_tension: bool
    """Whether tensions were measured."""

    misfit: float | None = None
    """Misfit of the law, 1 for none [-]."""

    radius_mm: float
    """Radius of its pulley [mm]."""

    reversals_mm: list[float] | None = None
    """Width of the gap at every reversal [mm]."""

    rms_n_m: float | None = None
    """Root mean square error of the friction [N m]."""

    samples: int | None = None
    """Samples of steady motion."""

    servo: int
    """Its number, from 1."""


@dataclass(frozen=True, kw_only=True)
class ServoHealth(_Outcome):
    """Everything of one servo."""

    change: Numbers | None = None
    """Changes from the baseline, as parts of it."""

    condition: float | None = None
    """Probability that no quantity has grown by a quarter of the baseline; none without one."""

    friction_pulling_percent: Estimate | None = None
    """Dry friction pulling, of full load [%]."""

    friction_releasing_percent: Estimate | None = None
    """Dry friction releasing, of full load [%]."""

    lost_motion_mm: Estimate | None = None
    """Lost motion [mm]."""

    servo: int
    """Number, from 1."""

    temperature_degc: float | None = None
    """Mean temperature [°C]."""

    temperature_max_degc: float | None = None
    """Highest temperature of its case [°C]."""

    windows: list[Numbers]
    """Window by window."""


@dataclass(frozen=True, kw_only=True)
class ServoLoad(_Outcome):
    """Tensions from the load of the servos: torque, radius and friction."""

    breakaway_n_m: float
    """See `coulomb_n_m`."""

    coulomb_n_m: float
    """Friction of motor and gear, back EMF included, as torques at the output."""

    radius_m: float
    """Radius of the pulleys [m]."""

    stall_torque_n_m: float
    """Torque of a load of 1 [N m]."""

    stribeck_velocity_rad_s: float
    """See `coulomb_n_m`."""

    viscous_n_m_s_per_rad: float
    """See `coulomb_n_m`."""


@dataclass(frozen=True, kw_only=True)
class ServoSummary(_Outcome):
    """A servo as it answered."""

    id: int
    """Id on the bus."""

    is_torque_on: bool
    """Whether its torque is on."""

    model: int
    """Model number."""

    position_ticks: int
    """Position [ticks]."""

    registers: dict[str, int]
    """Registers that a calibration stores, by name; empty for servos that have none."""

    supply_v: float
    """Supply voltage [V]."""

    temperature_c: float
    """Temperature [°C]."""


@dataclass(frozen=True, kw_only=True)
class Setting(_Outcome):
    """Setting of the study."""

    arm: str
    """The virtual arm."""

    demonstrations: list[int]
    """Demonstrations of a policy, and of its validation."""

    epochs: int
    """Epochs of the training."""

    heaviest_kg: float
    """Heaviest object [kg]."""

    hidden: list[int]
    """Units of the hidden layers."""

    near_mm: float
    """Distance from the goal that counts as a success [mm]."""

    policies: int
    """Policies of a row."""

    stays_s: float
    """How long before the end the tip must be that near [s]."""

    trials: int
    """Trials of a row."""


@dataclass(frozen=True, kw_only=True)
class ShardsMergeOutcome(_Outcome):
    """The outcome of `shards merge`: the card of a set."""

    area_m2: float
    """Area that the tip goes over [m²]; convex hull."""

    bytes: int
    """Size of all rows [byte]."""

    channels: dict[str, ChannelStatistics]
    """By name of the channel."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    complete: bool
    """Whether all shards are there."""

    dropped: int
    """Skipped trajectories."""

    extrapolating: float
    """Part of the samples in which the network left its training range [-]."""

    families: dict[str, FamilySamples]
    """By family of the motion."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    made: int
    """Trajectories in the set."""

    manifest_sha256: str
    """SHA-256 of its manifest."""

    missing: int
    """Shards that are missing."""

    missing_shards: str
    """The missing shards in words, the first few; empty where none is missing."""

    outside_validation: float
    """Part of the samples in which a chain was bent further than it was validated [-]."""

    plan: str
    """Name of the plan."""

    robot: str
    """Name of the robot."""

    samples: int
    """Samples of all."""

    scene_sha256: str
    """Hash of the scene and its mesh."""

    shards: int
    """Shards of the set."""

    skipped: list[SkippedExample]
    """The first of the skipped trajectories."""

    url: str
    """Place of the set."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class ShardsPlanOutcome(_Outcome):
    """The outcome of `shards plan`."""

    estimate: CostEstimate | None = None
    """Time and size of the set, where trajectories were simulated for it."""

    inputs: list[PlannedInput]
    """Files that workers read."""

    manifest_sha256: str
    """SHA-256 of its manifest."""

    plan: str
    """Name of the plan."""

    robot: str
    """Name of the robot."""

    samples: int
    """Samples of all."""

    shards: int
    """Number of shards."""

    trajectories: int
    """Trajectories."""

    url: str
    """Place of the set."""

    was_there: bool
    """Whether the same set was planned there before."""


@dataclass(frozen=True, kw_only=True)
class ShardsStatusOutcome(_Outcome):
    """The outcome of `shards status`."""

    bytes: int
    """Size of the rows [byte]."""

    done: int
    """Shards that are done."""

    hours_left: float | None = None
    """Time for the missing shards at that rate [h]."""

    missing: int
    """Shards that are missing."""

    missing_shards: str
    """The missing shards in words, the first few."""

    plan: str
    """Name of the plan."""

    shards: int
    """Shards of the set."""

    shards_per_hour: float | None = None
    """Shards done in an hour, from the first to the last, by the clock of the store; absent with fewer than two."""

    unfinished: int
    """Shards among the missing ones whose rows are stored without their sketch: their worker ended in between."""

    url: str
    """Place of the set."""


@dataclass(frozen=True, kw_only=True)
class ShardsWorkOutcome(_Outcome):
    """The outcome of `shards work`."""

    already_there: int
    """Shards that were there already."""

    made: int
    """Shards that this worker has made."""

    made_twice: int
    """Shards that this worker has made and another one has stored first."""

    samples: int
    """Samples that this worker has simulated."""

    seconds: float
    """Time that it took [s]."""

    url: str
    """Place of the set."""


@dataclass(frozen=True, kw_only=True)
class SharedTensions(_Outcome):
    """Residual tensions that holds share."""

    left_out_rmse_mm: float | None = None
    """The same of test holds [mm]."""

    rmse_mm: float
    """Mean of the markers' root mean square errors [mm]."""

    sharing: str
    """How holds share them."""


@dataclass(frozen=True, kw_only=True)
class SimulateOutcome(_Outcome):
    """The outcome of `simulate` and of `reach`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    iterations_per_step: float
    """Corrections with the lagged factor per sample [-]."""

    robot: RobotSize
    """The robot and the size of its model."""

    run: RunSummary
    """The numbers of the run."""

    shapes: list[NamedShape] | None = None
    """Command and tip over each other, where the tendons bend in two directions."""

    source: str
    """Provenance of the strokes or goals."""

    steps_per_s: float
    """Samples simulated per second of computing time [1/s]."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class Simulated(_Outcome):
    """Models of a simulated arm."""

    rows: list[SimulatedRow]
    """One for each training."""

    study: SimulatedStudy
    """Models, seeds and data that were compared."""


@dataclass(frozen=True, kw_only=True)
class SimulatedErrors(_Outcome):
    """Errors of inverse dynamics and of the disturbance observer, joint by joint, in the paper's simulations."""

    model_error: list[list[float]]
    """A wrong model [N m]."""

    noise: list[list[float]]
    """Noise on the encoders [N m]."""

    sensitivity: list[list[float]]
    """Sensitivity to the mass of the second link [m²/s²]."""


@dataclass(frozen=True, kw_only=True)
class SimulatedRow(_Outcome):
    """One training of the study."""

    joints: list[float]
    """Mean squared error over variance of every joint's torque, at the first speed [-]."""

    mse: Parts
    """Mean squared error of the torque over all joints, at the first speed [N² m²]."""

    parameters: int
    """Parameters of the model."""

    parts: list[Parts]
    """For every speed of the test, in the order of [`SimulatedStudy::speeds`]."""

    power_mse: float
    """Mean squared error of the power q̇ᵀτ, at the first speed [W²]."""

    seconds: float
    """Time of the training by the clock [s]."""

    seed: int
    """Of its initial parameters."""

    steps: list[int]
    """Epochs of Adam and steps of what follows it until the best parameters."""

    trajectories: int
    """Training trajectories."""

    validation: float
    """Root mean square error on validation trajectories, in spreads [-]."""

    variant: Variant
    """Which model."""


@dataclass(frozen=True, kw_only=True)
class SimulatedStudy(_Outcome):
    """Options of the comparison: models, seeds, data, networks."""

    activation: Activation
    """Between layers."""

    first_seed: int
    """The first of them."""

    hidden: list[int] | None = None
    """Units of every hidden layer; none for two layers of as many as the variant was found to need."""

    inputs: InputForm
    """Form of the positions as inputs of networks."""

    seeds: int
    """Seeds of initial parameters and of minibatches: how many."""

    speeds: list[float]
    """Speeds of the test, over that of training."""

    squares: int
    """Dense columns of the factor of a mass matrix, next to its triangle; an inverse mass matrix has none, for
    it is no sum of squares of products."""

    training: TrainingOptions
    """How they are trained."""

    trajectories: list[int]
    """Training trajectories, validation among them."""

    units: Units
    """Whether networks get SI units, as published, or spreads."""

    variants: list[Variant]
    """Rows of the table."""


@dataclass(frozen=True, kw_only=True)
class SkippedExample(_Outcome):
    """A trajectory that the twin cannot follow."""

    name: str
    """Its name."""

    why: str
    """Why it was skipped."""


@dataclass(frozen=True, kw_only=True)
class Spread(_Outcome):
    """The distribution of a measure of quality over the tetrahedra."""

    max: float
    """Largest value."""

    mean: float
    """Mean."""

    median: float
    """Half of the tetrahedra are below this."""

    min: float
    """Smallest value."""

    min_tetrahedron: int
    """The tetrahedron that has it, by its number in the file."""

    percentile_1: float
    """A hundredth of the tetrahedra are below this."""

    percentile_5: float
    """A twentieth of the tetrahedra are below this."""


@dataclass(frozen=True, kw_only=True)
class Stability(_Outcome):
    """Rollouts on random plans."""

    ratio_to_bare: list[float]
    """Error of the tip over that of the twin without a network, plan by plan [-]."""

    worse_by_10_percent: list[int]
    """Plans on which the network makes the error larger by more than 10 %."""


@dataclass(frozen=True, kw_only=True)
class StageCommands(_Outcome):
    """The commands of a stage."""

    commands: list[str]
    """As a person would type them."""

    name: str
    """Name of the stage."""


@dataclass(frozen=True, kw_only=True)
class StationErrors(_Outcome):
    """Distances from the reference, over the length of the rod."""

    all_stations_but_the_clamp: ErrorStatistics = field(metadata={"key": "all stations but the clamp"})
    """At all stations but the clamp."""

    mid_length: ErrorStatistics = field(metadata={"key": "mid-length"})
    """At mid-length."""

    tip: ErrorStatistics
    """At the tip."""


@dataclass(frozen=True, kw_only=True)
class StatsSummary(_Outcome):
    """The same for a file."""

    bus: BusCounts
    """Counts of the traffic and faults of the bus."""

    bus_median_ms: float
    """Median of the transfers of a cycle [ms]."""

    bus_p99_ms: float
    """99 % of them do not exceed this [ms]."""

    late_max_ms: float
    """Largest lateness [ms]."""

    late_p99_ms: float
    """Lateness that 99 % of all cycles do not exceed [ms]."""

    n_cycles: int
    """Cycles."""

    n_missed: int
    """Cycles that did not take place, because one before them came too late."""

    n_poses: list[int]
    """Poses that were trusted, and those that were not."""

    pose_age_median_ms: float
    """Median age of a trusted pose when a cycle took it [ms]."""

    pose_age_p99_ms: float
    """99 % of them are no older [ms]."""

    processor_percent: float | None = None
    """Part of one core that the process used, in real time [%]."""

    temperature_degc: list[list[float]] | None = None
    """Time since the first row [s], then the temperature of every servo [°C]."""

    wire_ms: float
    """Time that the bytes of a cycle take on the wire [ms]."""

    within_1ms: float
    """Part of all cycles that began within 1 ms of their time [-]."""


@dataclass(frozen=True, kw_only=True)
class StudyAblationOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: AblationMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyAdaptationOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: AdaptationMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyCloningOutcome(_Outcome):
    """The outcome of `study cloning`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    published: list[PublishedSuccess]
    """Printed rows."""

    rows: list[Row2]
    """Rows of the table."""

    study: Setting
    """Setting of the study."""

    verdict: Verdict
    """Whether policies that observe a force do better."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyConvergenceOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: list[MeshResolution]
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyCoreactOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: CoreactMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyEdicOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: EdicMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyForceOutcome(_Outcome):
    """The outcome of `study force`."""

    about: str
    """Arms that were recorded."""

    arms: int
    """Number of arms."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    methods: list[ForceMethod]
    """One for each method."""

    samples: list[list[int]]
    """Samples for identification, of tests with objects and of tests without, arm by arm."""

    study: str
    """Name of the study."""

    tasks: list[str]
    """Names of the tasks."""

    verdict: Verdict
    """Whether forces at the tip can be estimated."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyFtdcrOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: FtdcrMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyIdentificationOutcome(_Outcome):
    """The outcome of `study identification`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    franka: FrankaResult | None = None
    """Recorded friction of a Franka arm; null without data."""

    options: IdentificationOptions
    """How much was simulated."""

    scara: list[ScaraMethod]
    """Friction of the SCARA: method by method for each joint, over the seeds."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether friction can be identified from single trials."""

    version: int
    """Its version."""

    wrist: list[SweepCell]
    """Bodies of the wrist, seed by seed."""


@dataclass(frozen=True, kw_only=True)
class StudyInverseOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: InverseMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyLayoutsOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: LayoutMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyNeuralOutcome(_Outcome):
    """The outcome of `study neural`."""

    about: str
    """The arm that was recorded, and the size of the networks."""

    cells: NeuralStudy
    """Every comparison, without what is only drawn."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether an actuator that is learned from telemetry simulates the arm."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyPopulationOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: PopulationMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyRobotsOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: RobotsMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyRunOutcome(_Outcome):
    """The outcome of `study run`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    is_virtual: bool
    """True where the rig is simulated."""

    predicted: list[PredictedPath]
    """The twin on trajectories that were not in its training."""

    rig: str
    """The rig, for people."""

    robot: str
    """Name of the robot."""

    seed: int
    """Seed of everything random."""

    stages: list[StageCommands]
    """Stages and their commands."""

    study: str
    """Name of the study."""

    tracked: list[Tracked]
    """Every target by every method."""

    verdict: Verdict
    """Whether the trained controllers bring the robot along paths."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyScaraOutcome(_Outcome):
    """The outcome of `study scara`."""

    collisions: CollisionCell
    """Collisions by every method."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    friction: list[FrictionResult]
    """Identified friction, joint by joint and method by method."""

    options: ScaraOptions
    """How much was simulated."""

    study: str
    """Name of the study."""

    teaching: list[TeachingResult]
    """External torques while the hand leads the arm, by every model of friction."""

    truth_deviation_n_m: list[float]
    """Deviation of the true external torque of both joints [N m]."""

    verdict: Verdict
    """Whether external torques can be estimated."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudySensingOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: SensingMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudySimulatedOutcome(_Outcome):
    """The outcome of a study of learned inverse dynamics."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    means: list[Means]
    """Means over the seeds, of simulated arms."""

    study: Study
    """Models and their errors."""

    verdict: Verdict
    """Whether the best model does better than the simplest."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudySofaOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: list[Comparison]
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudySorosimOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: list[RodResolution]
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyTentacleOutcome(_Outcome):
    """The outcome of a study of tendon robots."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    machine: Machine
    """The machine that it ran on."""

    metrics: TentacleMetrics
    """Numbers of the study."""

    study: str
    """Name of the study."""

    verdict: Verdict
    """Whether the result can be used."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class StudyWristOutcome(_Outcome):
    """The outcome of `study wrist`."""

    cells: list[WristResult]
    """Trials: by drift of friction, load and seed."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    simulated_rms: SimulatedErrors
    """The paper's simulations: root mean square errors."""

    study: str
    """Name of the study."""

    sweep_rms_n_m: list[list[float]]
    """Residuals of both joints in the swept sine, model by model [N m]."""

    verdict: Verdict
    """Whether interaction torques can be estimated from the motors."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class SweepCell(_Outcome):
    """Both methods on one sweep."""

    rows: list[SweepRow]
    """The methods."""

    seed: int
    """Seed of all draws."""


@dataclass(frozen=True, kw_only=True)
class SweepRow(_Outcome):
    """One method."""

    evaluations: int | None = None
    """Evaluations of the cost, of evolution."""

    least_pseudo_inertias: list[float]
    """Least eigenvalue of the pseudo-inertias of both bodies: above 0 where they can exist."""

    method: str
    """"convex" or "differential-evolution"."""

    rms_n_m: list[float]
    """Root mean square of what is left, joint by joint [N m]."""

    seconds: float
    """Time it took [s]."""

    weighed_n_m: float
    """The two together, joint 2 weighed six-fold: what evolution makes least [N m]."""


@dataclass(frozen=True, kw_only=True)
class SyntheticTrajectory(_Outcome):
    """One trajectory."""

    amplitude_m: float
    """Amplitude of the strokes [m]."""

    extrapolating: float
    """Part of the samples in which the network left its training range [-]."""

    family: str
    """Family of its motion."""

    frequency_hz: float
    """Frequency [Hz]."""

    left_out: str
    """Why it was skipped; empty if it was not."""

    name: str
    """Its name."""

    outside_validation: float | None = None
    """Part of the samples in which a chain was bent further than it was validated [-]."""

    reach_m: float
    """Largest distance of the tip from the axis [m]."""

    samples: int
    """Number of samples; none if it was skipped."""

    tension_max_n: float
    """Largest tension of a tendon [N]."""


@dataclass(frozen=True, kw_only=True)
class TargetOutcome(_Outcome):
    """The outcome of `target`."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    curve_s: list[float]
    """Times at which the curve begins and ends [s]."""

    duration_s: float
    """Time from the first to the last sample [s]."""

    family: str
    """Family of its curve."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    laps: int
    """Laps."""

    length_m: float
    """Length of a lap [m]."""

    name: str
    """Name of the target."""

    rate_hz: float
    """Rate [Hz]."""

    reach: Reach | None = None
    """Whether a robot reaches it, where a scene was given."""

    samples: int
    """Number of samples."""

    target_sha256: str
    """SHA-256 of what it was made from."""

    version: int
    """Its version."""


@dataclass(frozen=True, kw_only=True)
class TargetSummary(_Outcome):
    """A target in numbers."""

    family: str
    """Family of its curve."""

    laps: int
    """Laps."""

    length_m: float
    """Length of a lap [m]."""

    name: str
    """Name."""

    sha256: str
    """SHA-256 of what it was made from."""


@dataclass(frozen=True, kw_only=True)
class TaskScores(_Outcome):
    """The scores of a task."""

    forces: ForcesBySource
    """Errors of the forces."""

    poses: ByMethod2
    """Errors of the poses."""

    task: str
    """Its name."""

    trajectories: int
    """Number of its trajectories."""


@dataclass(frozen=True, kw_only=True)
class TaskTrace(_Outcome):
    """The first trajectory of a task over time."""

    forces_n: list[list[float] | None]
    """Force along z by each source of [`FORCES`] (n_rows) [N]; none where a source gives none."""

    label_n: list[float]
    """Label of the force along z, 0 where there is none (n_rows) [N]."""

    measured_rad: list[list[float]]
    """Measured angles (n_joints × n_rows) [rad]."""

    methods_rad: list[list[list[float]]]
    """Angles by each method of [`METHODS`] (n_joints × n_rows) [rad]."""

    task: str
    """Name of the task."""

    time_s: list[float]
    """Times (n_rows) [s]."""


@dataclass(frozen=True, kw_only=True)
class TeachingResult(_Outcome):
    """External torques by one model of friction, both joints."""

    max_n_m: list[float]
    """Largest error [N m]."""

    mean_n_m: list[float]
    """Mean error [N m]."""

    method: str
    """The method of the model."""

    min_n_m: list[float]
    """Least error [N m]."""

    r2: list[float]
    """Share of the variance that is explained (R²) [-]."""

    rmse_n_m: list[float]
    """Root mean square error [N m]."""


@dataclass(frozen=True, kw_only=True)
class TendonSummary(_Outcome):
    """Numbers of one tendon over a run."""

    name: str
    """Name in the scene."""

    share_at_lower_bound: float
    """Share of the samples in which it was at its lower tension bound: slack, if that is zero [-]."""

    stroke_max_m: float
    """See `stroke_min_m`."""

    stroke_min_m: float
    """Commanded strokes [m]."""

    tension_max_n: float
    """Largest tension [N]."""


@dataclass(frozen=True, kw_only=True)
class TensionErrors(_Outcome):
    """Errors of twin and loads."""

    force_scale: float
    """Tension of the robot over the twin's [-]: not observable from a tip, for strokes and shape are the same
    with all forces doubled."""

    load_n: float
    """Standard deviation of a tension from a load [N]; neighbours have correlated errors, so it counts as often
    as it is new."""

    model_n: float
    """Largest standard deviation of that error [N]."""

    walk_sqrt_n: float
    """Random walk of the twin's error over a change of tension [√N]."""


@dataclass(frozen=True, kw_only=True)
class TensionScore(_Outcome):
    """Errors of tensions over their root mean square [-]."""

    all: float
    """All samples."""

    method: str
    """Method of the estimate."""

    moving: float
    """While the tendons move."""

    resting: float
    """While they rest."""


@dataclass(frozen=True, kw_only=True)
class TentacleMetrics(_Outcome):
    """The numbers of `study tentacle`."""

    fits: list[ParameterFit] | None = None
    """Fitted parameters, of a study that is not quick."""

    holds: list[HoldErrors]
    """One for each hold, with nominal parameters."""

    residual_tensions: ResidualTensions | None = None
    """Residual tensions on top of the last fit."""

    summary: list[PooledError]
    """Errors over the holds."""


@dataclass(frozen=True, kw_only=True)
class TimePercentiles(_Outcome):
    """Percentiles of times [ms]."""

    max: float
    """The longest."""

    median: float
    """Half of the times are shorter."""

    p95: float
    """95 % are shorter."""

    p99: float
    """99 % are shorter."""


@dataclass(frozen=True, kw_only=True)
class Tip(_Outcome):
    """How closely a tip followed its target."""

    aligned_rmse_mm: float
    """Distance at equal times [mm]."""

    nrmse_percent: float
    """NRMSE [%]."""

    rmse_mm: float
    """Distance from the path [mm]."""


@dataclass(frozen=True, kw_only=True)
class TipBand(_Outcome):
    """Distances of the true tip from the predicted one that are exceeded in few samples."""

    alone_mm: float
    """The same of the twin alone [mm]."""

    level: float
    """Part of the samples within [-]."""

    radius_mm: float
    """Radius of the band [mm]."""

    recordings: int
    """Recordings that were left out in turn."""


@dataclass(frozen=True, kw_only=True)
class TipBandSummary(_Outcome):
    """Where the robot's own tip is expected: the band about the tip of the twin, as wide as the error on
    recordings that were left out in learning, and wider where an input of the network lies outside its
    training range."""

    held: float | None = None
    """Part of the measured samples that it holds, where the tip was measured [-]."""

    level: float
    """Part of the samples that the band is to hold [-]."""

    radius_max_m: float
    """Largest radius [m]."""

    radius_median_m: float
    """Radius about the tip, median [m]."""

    recordings: int
    """Recordings that it is calibrated on."""


@dataclass(frozen=True, kw_only=True)
class TipForceErrors(_Outcome):
    """How far a tip without contact strays from the twin's."""

    creep_m_per_sqrt_s: list[float]
    """Random walk of b at rest, along x, y, z [m/√s]."""

    length_m: float
    """Path of the tendons over which b becomes another [m]."""

    model_m: list[float]
    """Standard deviation of b along x, y, z: of the twin, and of the tracker [m]."""

    noise_m: list[float]
    """Noise of a sample along x, y, z [m]."""

    offset_m: list[float]
    """See `model_m`."""

    response: float
    """Standard error of the twin's response [-]."""

    thresholds: list[float]
    """Statistic of a change from which on it is a contact [-], for each of [`TipForceErrors::class`]."""

    walk_across_sqrt_m: float
    """See `walk_along_sqrt_m`."""

    walk_along_sqrt_m: float
    """Random walk of b over the path, along the tip's motion and across it [√m]."""


@dataclass(frozen=True, kw_only=True)
class Tracked(_Outcome):
    """A target by one method; one value for each repeat, none where the rig did not carry the strokes out."""

    aligned_rmse_m: list[float | None]
    """Distance at equal times [m]."""

    extrapolating: float
    """Part of the samples in which a network left its training range."""

    held_back: float
    """Part of the samples in which a limit reduced a stroke."""

    iou: list[float | None]
    """Overlap [-]."""

    lag_s: list[float | None]
    """Lag behind the target [s]."""

    method: Method
    """How strokes were found."""

    nrmse: list[float | None]
    """The same over the size of the target [-]."""

    rmse_m: list[float]
    """Distance from the path [m]."""

    target: str
    """Name of the target."""


@dataclass(frozen=True, kw_only=True)
class TrackerSurvey(_Outcome):
    """Survey of a tracker with the tip at rest."""

    doubts: list[str]
    """Warnings, each with what to do."""

    jitter_ms: float
    """Root mean square deviation of the intervals between stamps from their mean [ms]."""

    longest_gap_ms: float
    """Longest interval between stamps [ms]."""

    n_doubtful: int
    """See `n_poses`."""

    n_poses: int
    """Poses, and how many of them are not to be trusted."""

    noise_mm: float
    """Root mean square distance from the mean position [mm]."""

    orientation_wxyz: list[float]
    """Last orientation, w, x, y, z [-]."""

    position_mm: list[float]
    """Mean position in the tracker's frame [mm]."""

    rate_hz: float
    """Poses per second, by their stamps [Hz]."""


@dataclass(frozen=True, kw_only=True)
class TrafficCounts(_Outcome):
    """Counts of the traffic on the bus so far."""

    answers: int
    """Answers sent, damaged ones among them."""

    bad_packets: int
    """Packets with a wrong checksum."""

    broken_rounds: int
    """Sync reads of which an answer was missing or damaged."""

    complete_rounds: int
    """Sync reads of which every answer was sent whole."""

    instructions: int
    """Instructions with a right checksum."""

    slipped_ms: int
    """Time that the world did not live through, because the machine was too slow [ms]."""


@dataclass(frozen=True, kw_only=True)
class TrainOutcome(_Outcome):
    """The outcome of `train`."""

    candidates: list[CandidateErrors] | None = None
    """The controllers that the twin of `--scene` compared, from the simplest on; empty where none was named."""

    command: str
    """The command that made this."""

    commit: str
    """Commit of the program."""

    format: Literal["hysteron-metrics"]
    """Format of the file."""

    networks: list[FitReport]
    """Learning curve, and errors in validation next to those of the baselines: one entry for each network."""

    recording_warnings: list[Warning] | None = None
    """Warnings about the recordings."""

    training: InverseTraining
    """Data and options, as the checkpoint holds them."""

    twin_tip_rmse_mm: float | None = None
    """Distance of the tip that the recorded strokes bring that twin to from the one that was measured, root mean
    square in validation: the error where the twin itself finds the strokes [mm]."""

    verdict: Verdict
    """Whether the controller can be used."""

    version: int
    """Its version."""

    warnings: list[str]
    """Where the network does no better than a baseline, and kinds of motion that are validated on nowhere."""


@dataclass(frozen=True, kw_only=True)
class TrainedMember(_Outcome):
    """The training of one of several networks whose mean is taken."""

    epochs: int
    """Epochs after which its weights were found."""

    held_out: list[str]
    """Names of its validation recordings."""

    held_out_rmse_mm: float
    """Root mean square error of the tip in validation [mm]."""

    is_kept: bool | None = None
    """Whether it is in the mean: false where it does no better in validation than the twin alone."""


@dataclass(frozen=True, kw_only=True)
class TrainedOn(_Outcome):
    """A recording of a training."""

    name: str
    """Its name."""

    origin: DataOrigin
    """Where its strokes and tip come from."""

    sha256: str
    """SHA-256 of its file."""


@dataclass(frozen=True, kw_only=True)
class TrainingOptions(_Outcome):
    """How a model is trained."""

    batch: int
    """Samples of a step."""

    decay: StepDecay
    """Whether the step size stays, or decays along half a cosine."""

    epochs: int
    """Epochs of Adam at most."""

    learning_rate: float
    """Step size at the start."""

    patience: int
    """Epochs without a better error on validation data after which Adam ends."""

    penalty: float
    """λ of (10)."""

    polish: int
    """Steps of it at most."""

    polish_by: Polish
    """Optimiser that continues after Adam, in double precision."""

    polish_samples: int
    """Samples that it sees, spread evenly."""

    weight_decay: float
    """Penalty on weights."""

    weights: JointWeights
    """How joints are weighed."""


@dataclass(frozen=True, kw_only=True)
class TrunkResult(_Outcome):
    """Errors on the trunk, seed by seed and method by method."""

    delays_s: list[list[float]]
    """Delays that the methods chose [s]."""

    loaded_deg: list[list[float]]
    """The same with 200 g at the tip [deg]."""

    methods: list[str]
    """Names of the methods."""

    path_under_load: PathDifference
    """The path under load against the one without, same commands."""

    unseen_blocks_deg: list[list[float]]
    """Errors of the motor angles on test blocks [deg]."""


@dataclass(frozen=True, kw_only=True)
class TwinErrors(_Outcome):
    """One twin on the test trajectories."""

    nrmse: list[PathErrors]
    """Its errors, path by path."""

    twin: str
    """Name of the twin."""


@dataclass(frozen=True, kw_only=True)
class TwinTable(_Outcome):
    """All twins of a robot, or of several, on the test trajectories."""

    robot: str
    """The robot."""

    twins: list[TwinErrors]
    """Its twins."""


@dataclass(frozen=True, kw_only=True)
class Validation(_Outcome):
    """Errors of a chain against its finite elements."""

    count: int
    """Equilibria that were compared."""

    refused: list[int]
    """Targets under which the finite elements had no equilibrium, and others under which the chain had none."""

    seed: int
    """Seed of the targets."""

    strain: float
    """Largest strain of a section [-]."""

    stroke_m: float
    """Largest stroke asked for [m]."""

    tension_n: float
    """Largest tension of auxiliary tendons asked for [N]."""

    tensions: ErrorSpread
    """Largest error of a tension over the largest tension, or over a fortieth of the largest of all where that
    is more [-]."""

    tip: ErrorSpread
    """Distance of the tips over the tip's displacement, or over a fortieth of the body's length where it moves
    less [-]."""

    turn_rad: ErrorSpread
    """Angle between the rotations of the tip [rad]."""


@dataclass(frozen=True, kw_only=True)
class Verdict(_Outcome):
    """Whether a result can be used."""

    reasons: list[Reason]
    """Reasons, the worst first."""

    sentence: str
    """The verdict in one sentence."""

    usability: Usability
    """That of the worst reason."""


@dataclass(frozen=True, kw_only=True)
class Warning(_Outcome):
    """A finding with its number."""

    channel: str
    """Channel, or channels."""

    finding: str
    """The finding in words, its number and its limit among them."""

    hint: str
    """Advice to the user."""

    kind: Finding
    """Kind of finding."""

    limit: float
    """The limit that it broke [`Warning::unit`]."""

    recording: str
    """Name of the recording; empty for a warning about all of them."""

    rows: list[int] | None = None
    """First and last row, counted from 1; none for a warning about all rows."""

    severity: Severity
    """How sure it is."""

    unit: str
    """Unit of both."""

    value: float
    """The number [`Warning::unit`]."""


@dataclass(frozen=True, kw_only=True)
class WeightErrors(_Outcome):
    """Errors of the strokes in validation that the number format of the weights makes."""

    format: WeightFormat
    """The format."""

    stroke_largest_mm: float
    """Largest [mm]."""

    stroke_rmse_mm: float
    """Root mean square [mm]."""


@dataclass(frozen=True, kw_only=True)
class WindowOptions(_Outcome):
    """How to train on windows."""

    batch: int
    """Windows of a step."""

    decay_epochs: int
    """Epochs between two changes of the step size."""

    decay_factor: float
    """Factor on the step size every `decay_epochs` epochs [-]."""

    dropout: float
    """Dropout between layers."""

    epochs: int
    """Epochs."""

    gradient_floor: float
    """Derivatives of at most this size become zero in back-propagation through time, which then ends early; at
    zero none do."""

    hidden: int
    """Hidden units of each layer."""

    layers: int
    """LSTM layers."""

    learning_rate: float
    """Step size of Adam at the start."""

    seed: int
    """Seed of weights, order and dropout."""

    stride: int
    """Samples between the ends of two windows."""

    weight_decay: float
    """Weight decay of Adam."""

    window: int
    """Samples of a window."""


@dataclass(frozen=True, kw_only=True)
class WithoutContact(_Outcome):
    """False alarms in recordings without contact."""

    alarms: float
    """Number of alarms."""

    seconds: float
    """Time without contact [s]."""


@dataclass(frozen=True, kw_only=True)
class WristResult(_Outcome):
    """Every method under one load, one drift of friction and one seed."""

    drift: float
    """Relative change of friction after identification [-]."""

    identified_rms_n_m: list[float]
    """Residual of the identification, both joints [N m]."""

    load: Load
    """Load of the wrist."""

    mean_truth_n_m: list[float]
    """Mean size of the true torque of both joints [N m]."""

    methods: list[MethodErrors]
    """One for each method."""

    seed: int
    """Seed of the noise."""


Activation = Literal["relu"] | Literal["tanh"] | Literal["softplus"]
"""Activation between two layers."""

AdaptedParts = Literal["nothing"] | Literal["change"] | Literal["correction"] | Literal["both"]
"""Parts of the adaptation that are kept."""

ArmEvaluateOutcome = ActuatorEvaluation | DynamicsScores
"""The outcome of `arm evaluate`: of a neural actuator, or of a model of inverse dynamics."""

BaseMap = Literal["cubic"] | Literal["kernel"]
"""A map from the path to strokes; a network may correct it."""

Candidate = Literal["static_regression"] | Literal["kernel_regression"] | Literal["recorded_network"] | Literal["network"]
"""A controller to choose from, from the simplest on."""

CheckOutcome = RecordingFindings | SceneSummary
"""The outcome of `check`: of a scene alone, or of recordings, with the scene that they are compared with."""

Criterion = Literal["error_over_spread"] | Literal["error_over_baseline"] | Literal["held_out_over_fitted"] | Literal["error_over_target"] | Literal["relative_standard_error"] | Literal["parameters_on_bound"] | Literal["parameters_undetermined"] | Literal["condition_number"] | Literal["parameters_over_residuals"] | Literal["not_converged"] | Literal["solver_failures"] | Literal["outside_training"] | Literal["at_limit"] | Literal["single_repeat"] | Literal["missing"]
"""Criterion that a result is measured by. Larger is worse for all of them."""

DataOrigin = Literal["real"] | Literal["synthetic"]
"""Where strokes and tip come from."""

Finding = Literal["time_unit"] | Literal["gap"] | Literal["uneven_time"] | Literal["repeated_stamp"] | Literal["unit"] | Literal["speed"] | Literal["reach"] | Literal["frozen"] | Literal["sample_and_hold"] | Literal["duplicated_row"] | Literal["spike"] | Literal["wrap"] | Literal["saturation"] | Literal["quantisation"] | Literal["orientation"] | Literal["delay"] | Literal["copy_of_recording"] | Literal["copy_within"] | Literal["tendon"] | Literal["excitation"]
"""Kind of finding."""

ForceSource = Literal["loop"] | Literal["observer"]
"""Network that gives force, contact and condition."""

ImportOutcome = Imported | Proposed
"""The outcome of `import`: recordings, or a proposed map."""

InputForm = Literal["sines-and-cosines"] | dict[Literal["products"], int]
"""Form of the positions as inputs of networks."""

InverseOptions = InverseRecurrentOptions | WindowOptions
"""Options of a training."""

JointWeights = Literal["equal"] | Literal["inverse-variance"]
"""How the errors of joints are weighed."""

Load = Literal["payload"] | Literal["force-sensor"]
"""Load of the wrist."""

LockingEstimate = Literal["ten_node"] | dict[Literal["not_estimated"], dict[Literal["nodes"], int]] | dict[Literal["estimated"], list[LockingComparison]]
"""Error by the locking of linear tetrahedra on a robot."""

Method = Literal["nominal"] | Literal["scene"] | Literal["twin"] | Literal["network"]
"""How strokes are found."""

PathSmoothing = Literal["centred"] | Literal["causal"]
"""Which samples a line is drawn through."""

Polish = Literal["lbfgs"] | dict[Literal["levenberg-marquardt"], dict[Literal["batch"], int]]
"""Optimiser that refines the weights after Adam."""

ResidualOptions = ResidualRecurrentOptions | WindowOptions
"""Options of a training."""

ResidualPart = Literal["nothing"] | Literal["linear"] | Literal["network"]
"""Parts of a residual model, from the fewest numbers to the most."""

RigEmulateOutcome = TrafficCounts
"""The outcome of `rig emulate`."""

Severity = Literal["warning"] | Literal["error"]
"""How sure a finding is."""

StepDecay = Literal["constant"] | Literal["cosine"]
"""Schedule of the learning rate."""

Study = Simulated | Recorded2
"""Models of a simulated arm, or of recorded ones."""

Task = Literal["place"] | Literal["stay"]
"""Task with the object."""

TelemetryEstimates = LiveEstimates | RecordingEstimates
"""Estimates from the telemetry of servos: along a recording, or live."""

TrackOutcome = Outcome | Recorded
"""The outcome of `track`: of a path, how closely the tip followed it; of recorded strokes, the recordings."""

TrainedDesign = Literal["recurrent"] | Literal["paper"]
"""Which design was trained."""

Units = Literal["si"] | Literal["spread"]
"""Units of the motions that networks get."""

Usability = Literal["usable"] | Literal["usable_with_care"] | Literal["not_usable"]
"""Whether a result can be used, from best to worst."""

Variant = Literal["structured-lagrangian"] | Literal["black-box-lagrangian"] | Literal["structured-hamiltonian"] | Literal["black-box-hamiltonian"] | Literal["feed-forward"] | Literal["friction"] | Literal["augmented"]
"""A model of inverse dynamics."""

WeightFormat = Literal["float32"] | Literal["int16"]
"""How what steps a network keeps the weights of its matrices. A network that does not stay in a core's own
    cache takes as long for a sample as its weights take to come from memory: half as many bits come in half
    the time."""

ArmEstimateOutcome = ExternalTorques | TelemetryEstimates
"""The outcome of `arm estimate`: with learned dynamics, or from the telemetry of servos."""

ArmCheckOutcome = ArmInfoOutcome

DemoOutcome = StudyRunOutcome

ReachOutcome = SimulateOutcome

StudyBaxterCircleOutcome = StudySimulatedOutcome

StudyBaxterHelicalOutcome = StudySimulatedOutcome

StudyCharactersOutcome = StudySimulatedOutcome

StudyKukaOutcome = StudySimulatedOutcome

StudyNeuralNetworksOutcome = StudyNeuralOutcome

StudyPandaOutcome = StudySimulatedOutcome

StudyRecordedOutcome = StudySimulatedOutcome
