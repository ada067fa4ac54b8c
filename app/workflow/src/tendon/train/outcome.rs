//! The outcome of `train`.

use hysteron_base::checks::Warning;
use hysteron_base::number::digits;
use hysteron_control::inverse::{Folds, InverseTraining, LeadingTwin};
use hysteron_learn::FitReport;
use hysteron_report::verdict::{Criterion, Verdict};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::compared::{CandidateErrors, ComparedController, ControllerComparison, SAME};
use crate::shared::outcome::MetricsFormat;
use crate::shared::recording_checks::Findings;
use crate::shared::training;
use crate::shared::verdict::{ratio, repeated};
use crate::{COMMIT, Context};

/// The outcome of `train`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether the controller can be used.
    pub verdict: Verdict,
    /// The controllers that the twin of `--scene` compared, from the simplest on; empty where none was named.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub candidates: Vec<CandidateErrors>,
    /// Distance of the tip that the recorded strokes bring that twin to from the one that was measured, root mean square in
    /// validation: the error where the twin itself finds the strokes [mm].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twin_tip_rmse_mm: Option<f64>,
    /// Learning curve, and errors in validation next to those of the baselines: one entry for each network.
    pub networks: Vec<FitReport>,
    /// Where the network does no better than a baseline, and kinds of motion that are validated on nowhere.
    pub warnings: Vec<String>,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Data and options, as the checkpoint holds them.
    pub training: InverseTraining,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(
        folds: &Folds,
        (comparison, candidates, twin_tip_rmse_mm): (
            &ControllerComparison,
            Vec<CandidateErrors>,
            Option<f64>,
        ),
        training: &InverseTraining,
        findings: &Findings,
        context: &Context,
    ) -> Self {
        let networks: Vec<FitReport> = comparison
            .controllers
            .iter()
            .filter(|one| one.candidate.is_network() || comparison.controllers.len() == 1)
            .map(ComparedController::report)
            .collect();
        let judged = judged(&candidates, training.twin.as_ref(), folds.validated().count());
        // A network that loses is not used where controllers are compared.
        let mut warnings = if judged.is_some() { Vec::new() } else { training::losses(&networks) };
        if training.twin.is_none() {
            warnings.extend(better_twin(&candidates, twin_tip_rmse_mm));
        }
        if folds.len() == 1 {
            for (kind, names) in folds.fold(0).unvalidated() {
                let names = names.join(", ");
                warnings
                    .push(format!("motion of kind {kind} is learned from and validated on nowhere: {names}"));
            }
        }
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: judged.unwrap_or_else(|| training::verdict(&networks)),
            candidates,
            twin_tip_rmse_mm,
            networks,
            warnings,
            recording_warnings: findings.warnings().to_vec(),
            training: training.clone(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

impl Outcome {
    /// Lines that compare the controllers, and the twin that compared them.
    pub(super) fn comparison(&self) -> Vec<String> {
        let line = |[name, strokes, tip]: &[String; 3]| match &tip[..] {
            "-" => format!("{name}: strokes {strokes} mm"),
            _ => format!("{name}: tip {tip} mm, strokes {strokes} mm"),
        };
        self.rows().iter().map(line).collect()
    }

    /// Name, error of the strokes and error at the tip [mm] of every controller, and of the twin where one compared them.
    pub(super) fn rows(&self) -> Vec<[String; 3]> {
        let most = self.candidates.iter().map(|one| one.folds).max().unwrap_or(1);
        let shown = |error: Option<f64>| error.map_or("-".to_owned(), digits);
        let row = |one: &CandidateErrors| {
            let mark = match one {
                one if one.is_chosen => ", written".to_owned(),
                one if one.folds < most => format!(", given up after {} of {most} folds", one.folds),
                _ => String::new(),
            };
            let name = format!("{}{mark}", one.candidate.name());
            let standard = one.tip_standard_error_mm.map_or(String::new(), |mm| format!(" ± {}", digits(mm)));
            [name, digits(one.stroke_rmse_mm), format!("{}{standard}", shown(one.tip_rmse_mm))]
        };
        let mut rows: Vec<[String; 3]> = self.candidates.iter().map(row).collect();
        if !rows.is_empty() && self.twin_tip_rmse_mm.is_some() {
            let mark = if self.training.twin.is_some() { ", leads command and track" } else { "" };
            rows.push([format!("the twin itself{mark}"), shown(None), shown(self.twin_tip_rmse_mm)]);
        }
        rows
    }
}

/// Whether the best of the controllers that were compared can be used; none where there was no comparison.
fn judged(
    candidates: &[CandidateErrors],
    twin: Option<&LeadingTwin>,
    n_validation: usize,
) -> Option<Verdict> {
    let chosen = candidates.iter().find(|one| one.is_chosen)?;
    let is_at_tip = candidates.iter().any(|one| one.tip_rmse_mm.is_some());
    let error = |one: &CandidateErrors| if is_at_tip { one.tip_rmse_mm } else { Some(one.stroke_rmse_mm) };
    let (what, of_chosen) = (if is_at_tip { "the tip" } else { "strokes" }, error(chosen)?);
    let (leader, own) =
        twin.map_or((chosen.candidate.name(), of_chosen), |twin| ("twin itself", twin.tip_rmse_mm));
    let next = match twin {
        Some(_) => format!(", the {} within {} mm", chosen.candidate.name(), digits(of_chosen)),
        None => String::new(),
    };
    let verb = if is_at_tip { "leads" } else { "finds" };
    let claim = format!(
        "the {leader} {verb} {what} within {} mm on recordings that it did not learn from{next}",
        digits(own)
    );
    let mut verdict = Verdict::on(claim);
    let simplest = candidates.first().filter(|one| twin.is_some() || !one.is_chosen);
    if let Some((simplest, baseline)) = simplest.and_then(|one| Some((one, error(one)?))) {
        verdict = verdict.because(
            Criterion::ErrorOverBaseline,
            ratio(own, baseline),
            format!("the {} {verb} {what} within {} mm", simplest.candidate.name(), digits(baseline)),
        );
    }
    Some(repeated(verdict, n_validation, "recording in validation").verdict())
}

/// A sentence that names the twin where it leads the tip closer than the best controller.
fn better_twin(candidates: &[CandidateErrors], twin_mm: Option<f64>) -> Option<String> {
    let (chosen, twin_mm) = (candidates.iter().find(|one| one.is_chosen)?, twin_mm?);
    let tip_mm = chosen.tip_rmse_mm?;
    ((1.0 + SAME) * twin_mm < tip_mm).then(|| {
        format!(
            "the twin itself leads the tip within {} mm, the {} within {} mm: with `--scene` `hysteron command` and \
             `hysteron track` find the strokes through the twin, at a step of it a sample",
            digits(twin_mm),
            chosen.candidate.name(),
            digits(tip_mm)
        )
    })
}
