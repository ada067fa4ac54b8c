//! The outcome of `study run`, read from the files of its stages.
//!
//! Everything in it comes from these files, and nothing from the clock: a study that was interrupted ends
//! with the same bytes.

use std::path::{Path, PathBuf};

use hysteron_base::Recording;
use hysteron_control::score::{PathScore, score};
use hysteron_control::tracking::{CurvePart, TipOrigin};
use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::inputs;
use hysteron_workflow::shared::outcome::MetricsFormat;
use hysteron_workflow::shared::verdict::compared;
use hysteron_workflow::tendon::evaluate::{self, Row};
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::definition::{Study, Target};
use super::method::Method;
use super::stage::Stage;
use super::stages::{DATA, PREDICTED, STROKES, folder, repeat};

/// The outcome of `study run`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether the trained controllers bring the robot along paths.
    pub verdict: Verdict,
    /// Name of the study.
    pub study: String,
    /// Name of the robot.
    pub robot: String,
    /// The rig, for people.
    pub rig: String,
    /// True where the rig is simulated.
    pub is_virtual: bool,
    /// Seed of everything random.
    pub seed: u64,
    /// The twin on trajectories that were not in its training.
    pub predicted: Vec<PredictedPath>,
    /// Every target by every method.
    pub tracked: Vec<Tracked>,
    /// Stages and their commands.
    pub stages: Vec<StageCommands>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// The commands of a stage.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct StageCommands {
    /// Name of the stage.
    pub name: String,
    /// As a person would type them.
    pub commands: Vec<String>,
}

/// A trajectory that was not in the twin's training.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PredictedPath {
    /// Name of the trajectory.
    pub trajectory: String,
    /// Score of the twin without its network.
    pub without: PathScore,
    /// Score of the twin with it.
    pub with: PathScore,
}

/// A target by one method; one value for each repeat, none where the rig did not carry the strokes out.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Tracked {
    /// Name of the target.
    pub target: String,
    /// How strokes were found.
    pub method: Method,
    /// Distance from the path [m].
    pub rmse_m: Vec<f64>,
    /// The same over the size of the target [-].
    pub nrmse: Vec<Option<f64>>,
    /// Overlap [-].
    pub iou: Vec<Option<f64>>,
    /// Distance at equal times [m].
    pub aligned_rmse_m: Vec<Option<f64>>,
    /// Lag behind the target [s].
    pub lag_s: Vec<Option<f64>>,
    /// Part of the samples in which a limit reduced a stroke.
    #[serde(rename = "held_back")]
    pub limited: f64,
    /// Part of the samples in which a network left its training range.
    pub extrapolating: f64,
}

impl Tracked {
    /// Whether the rig carried the strokes out.
    pub(super) fn is_carried_out(&self) -> bool {
        !self.rmse_m.is_empty()
    }
}

impl hysteron_workflow::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

/// Reads what the stages of a study have written; and for every target and method the measured repeats.
///
/// # Errors
/// Files that are missing or cannot be read.
pub(super) fn read(
    out: &Path,
    study: &Study,
    stages: &[Stage],
    context: &Context,
) -> anyhow::Result<(Outcome, Vec<Vec<Row>>)> {
    let predicted = predicted(out, study)?;
    let (mut tracked, mut rows) = (Vec::new(), Vec::new());
    if let Some(track) = &study.track {
        for (target, method) in
            track.targets.iter().flat_map(|target| track.methods.iter().map(move |method| (target, *method)))
        {
            let (one, own) = tracked_in(out, target, method, track.repeats)?;
            tracked.push(one);
            rows.push(own);
        }
    }
    let commands = stages.iter().map(|stage| StageCommands {
        name: stage.name.clone(),
        commands: stage.steps.iter().map(|step| step.shown()).collect(),
    });
    let outcome = Outcome {
        format: MetricsFormat,
        version: 1,
        verdict: assess(&predicted, &tracked),
        study: study.name.clone(),
        robot: study.scene.robot.clone(),
        rig: study.rig.description.clone(),
        is_virtual: study.rig.is_virtual,
        seed: study.seed,
        predicted,
        tracked,
        stages: commands.collect(),
        command: context.command.clone(),
        commit: COMMIT.to_owned(),
    };
    Ok((outcome, rows))
}

/// Whether the best method leads the tip along the targets, better than a nominal twin where there is one; without targets,
/// whether the network makes the twin better.
fn assess(predicted: &[PredictedPath], tracked: &[Tracked]) -> Verdict {
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let mut methods: Vec<Method> = Vec::new();
    tracked.iter().for_each(|it| {
        if !methods.contains(&it.method) {
            methods.push(it.method)
        }
    });
    let of = |method: Method| tracked.iter().filter(move |it| it.method == method);
    let errors: Vec<(String, f64)> = methods
        .iter()
        .map(|&method| {
            (method.name().to_owned(), mean(of(method).flat_map(|it| it.rmse_m.clone()).collect()))
        })
        .filter(|(_, error)| error.is_finite())
        .map(|(name, error)| (name, 1e3 * error))
        .collect();
    let nrmse = |method: Method| mean(of(method).flat_map(|it| it.nrmse.iter().flatten().copied()).collect());
    let best = methods.iter().copied().min_by(|a, b| nrmse(*a).total_cmp(&nrmse(*b)));
    let rms = |of: fn(&PredictedPath) -> f64| mean(predicted.iter().map(of).collect());
    let network = (!predicted.is_empty()).then(|| rms(|it| it.with.rmse_m) / rms(|it| it.without.rmse_m));
    let mut assessment = match best {
        Some(method) => Verdict::on(format!("the tip follows the targets by the method {}", method.name())),
        None => Verdict::on("the twin with its network foresees paths that it has not learned from"),
    };
    if let Some(method) = best {
        let (share, n) = (nrmse(method), of(method).count());
        let left = of(method).filter(|it| !it.is_carried_out()).count() as f64 / n.max(1) as f64;
        let outside = of(method).map(|it| it.extrapolating).fold(0.0, f64::max);
        assessment = assessment
            .because(
                Criterion::ErrorOverTarget,
                share,
                format!(
                    "the tip is off by {:.1} % of the targets' size (NRMSE) by {}",
                    100.0 * share,
                    method.name()
                ),
            )
            .because(
                Criterion::Missing,
                left,
                format!("{:.0} % of the targets were not completed by {}", 100.0 * left, method.name()),
            )
            .because(
                Criterion::OutsideTraining,
                outside,
                format!("a network is outside its training in up to {:.0} % of the samples", 100.0 * outside),
            );
        assessment = compared(assessment, ("error of the tip", "mm"), &errors, Method::Nominal.name());
    }
    assessment
        .because_of(Criterion::ErrorOverBaseline, network, |ratio| {
            format!("with its network the twin has {:.0} % of the error without", 100.0 * ratio)
        })
        .verdict()
}

fn recording_of(out: &Path, trajectory: &str) -> PathBuf {
    out.join(DATA).join(format!("{trajectory}.parquet"))
}

/// A trajectory as measured, and by the twin without its network and with it.
pub(super) fn read_predicted(out: &Path, trajectory: &str) -> anyhow::Result<(Recording, [Recording; 2])> {
    let simulated = |kind: &str| Recording::read(out.join(kind).join(trajectory).join("tip.parquet"));
    let [with, without] = PREDICTED.map(simulated);
    Ok((Recording::read(recording_of(out, trajectory))?, [without?, with?]))
}

fn predicted(out: &Path, study: &Study) -> anyhow::Result<Vec<PredictedPath>> {
    let checks = if study.has_residual() { &study.plan.checks[..] } else { &[] };
    let mut all = Vec::new();
    for (trajectory, _) in checks {
        let (measured, simulated) = read_predicted(out, trajectory)?;
        let whole: Vec<bool> = vec![false; measured.n_samples()];
        let gap = if measured.gap().is_empty() { &whole } else { measured.gap() };
        let [without, with] = simulated.each_ref().map(|it| Some(score(measured.tip()?, it.tip()?, gap)));
        if let (Some(without), Some(with)) = (without, with) {
            all.push(PredictedPath { trajectory: trajectory.clone(), without, with });
        }
    }
    Ok(all)
}

/// Results of one method on one target.
fn tracked_in(
    out: &Path,
    target: &Target,
    method: Method,
    repeats: usize,
) -> anyhow::Result<(Tracked, Vec<Row>)> {
    let folder = out.join(folder(target, method));
    let strokes = Recording::read(folder.join(STROKES))?;
    let part = |flag: &str| {
        strokes.channel(flag).map_or(0.0, |values| values.iter().sum::<f64>() / values.len() as f64)
    };
    let tips: Vec<PathBuf> = (1..=repeats).map(|k| folder.join(repeat(k))).collect();
    // A rig that refused one of them has not completed all.
    let rows = if tips.iter().all(|tip| tip.exists()) {
        evaluate::rows(&target.path, inputs::read(&tips)?, CurvePart::AtTheSameTimes, TipOrigin::Frame)?
    } else {
        Vec::new()
    };
    let tracked = Tracked {
        target: target.path.name.clone(),
        method,
        rmse_m: rows.iter().map(|row| row.score.rmse_m).collect(),
        nrmse: rows.iter().map(|row| row.score.nrmse).collect(),
        iou: rows.iter().map(|row| row.score.iou).collect(),
        aligned_rmse_m: rows.iter().map(|row| row.score.aligned_rmse_m).collect(),
        lag_s: rows.iter().map(|row| row.score.lag_s).collect(),
        limited: part("limited"),
        extrapolating: part("extrapolating"),
    };
    Ok((tracked, rows))
}
