//! Training shared by both designs: epochs, the best weights in validation, and resuming from a file.

use std::borrow::Cow;

use hysteron_base::Bounds;
use hysteron_learn::{
    ChannelErrors, FitReport, FitResult, Network, Normaliser, TrainingSession, TrainingTask, WeightFormat,
    fit,
};

use super::training::{InverseTraining, WeightErrors};
use super::{Dataset, Demonstration, InverseDesign, InverseModel, TipWorkspace};
use crate::{Result, StrokeLimits};

/// A trained controller and its validation errors.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedController {
    /// With the best weights.
    pub model: InverseModel,
    /// Root mean square error of each stroke in validation [mm].
    pub held_out_mm: Vec<f64>,
    /// The same of the map below the network.
    pub base_mm: Vec<f64>,
    /// Learning curve and validation errors next to those of the baselines.
    pub report: FitReport,
    /// False where the training was stopped early and can resume from its file.
    pub is_finished: bool,
}

/// A design in training, evaluated by its strokes in millimetres.
pub(super) trait StrokeDesign: TrainingTask<Network> {
    /// Mean square error of each stroke in validation [mm²].
    fn squares(&mut self, network: &Network) -> std::result::Result<Vec<f64>, Self::Error>;
}

/// The best weights, the epochs after which they were found, and whether the training came to its end.
pub(super) struct FitOutcome {
    pub result: FitResult<Network>,
    /// Root mean square error of each stroke in validation [mm].
    pub held_out_mm: Vec<f64>,
}

/// Parts of a controller next to its network.
pub(super) struct ControllerParts {
    pub inputs: Normaliser,
    pub outputs: Normaliser,
    pub design: InverseDesign,
    pub workspace: TipWorkspace,
    pub weights: WeightFormat,
    /// Name of the map below the network, or beside one that has none, and its root mean square error for each stroke in
    /// validation [mm].
    pub base: (&'static str, Vec<f64>),
    /// [s].
    pub delay_s: f64,
}

impl FitOutcome {
    /// The controller; `training` holds design, options and data.
    pub fn into_fitted(
        self,
        data: &Dataset,
        training: InverseTraining,
        parts: ControllerParts,
    ) -> Result<FittedController> {
        let report = self.report(data, &parts);
        let ControllerParts { inputs, outputs, design, workspace, weights, base: (_, base_mm), delay_s } =
            parts;
        let training = InverseTraining {
            epochs: Some(self.result.epochs),
            held_out_stroke_rmse_mm: self.held_out_mm.clone(),
            base_stroke_rmse_mm: base_mm.clone(),
            delay_s: Some(delay_s),
            ..training
        };
        let mut model = InverseModel {
            network: self.result.model,
            inputs,
            outputs,
            design,
            weights,
            n_tendons: data.n_tendons,
            step_s: data.step,
            limits: data.limits(),
            workspace,
            robots: data.robots(),
            training,
        };
        if model.weights != WeightFormat::Float32 {
            let paths = if data.validation.is_empty() { &data.training } else { &data.validation };
            let [stroke_rmse_mm, stroke_largest_mm] = weight_error_mm(&model, paths)?;
            let format = model.weights;
            model.training.weights = Some(WeightErrors { format, stroke_rmse_mm, stroke_largest_mm });
        }
        let is_finished = self.result.is_finished;
        Ok(FittedController { model, held_out_mm: self.held_out_mm, base_mm, report, is_finished })
    }

    fn report(&self, data: &Dataset, parts: &ControllerParts) -> FitReport {
        let names = |all: &[Demonstration]| all.iter().map(|one| one.name.clone()).collect();
        let (base, base_mm) = &parts.base;
        let channel = |k: usize| ChannelErrors {
            name: format!("stroke {}", k + 1),
            errors: vec![base_mm[k], self.held_out_mm[k]],
        };
        let n_channels = if data.validation.is_empty() { 0 } else { data.n_tendons };
        FitReport {
            training: names(&data.training),
            validation: names(&data.validation),
            curve: self.result.curve.clone(),
            epochs: self.result.epochs,
            unit: Cow::Borrowed("mm"),
            methods: vec![(*base).to_owned(), "network".to_owned()],
            channels: (0..n_channels).map(channel).collect(),
        }
    }
}

/// Wide enough to hold nothing back.
const WIDE: StrokeLimits = StrokeLimits { stroke: Bounds { min: -1e3, max: 1e3 }, stroke_rate: 1e9 };

/// Error of the strokes from the format of the weights, on the paths of `demonstrations`: root mean square,
/// and the largest [mm].
fn weight_error_mm(model: &InverseModel, demonstrations: &[Demonstration]) -> Result<[f64; 2]> {
    let exact = InverseModel { weights: WeightFormat::Float32, ..model.clone() };
    let (mut square, mut largest, mut count) = (0.0, 0.0f64, 0.0);
    for one in demonstrations {
        let strokes = |model: &InverseModel| {
            Ok::<_, crate::Error>(model.command(&one.tip, WIDE, &mut |_| true)?.strokes)
        };
        for (kept, exact) in strokes(model)?.iter().zip(strokes(&exact)?) {
            let off = 1e3 * (kept - exact).abs();
            (square, largest, count) = (square + off * off, largest.max(off), count + 1.0);
        }
    }
    Ok([(square / f64::max(count, 1.0)).sqrt(), largest])
}

/// Trains `network`, or resumes from the session's file; see [`fit`].
pub(super) fn run<L: StrokeDesign>(
    task: &mut L,
    network: Network,
    identity: &InverseTraining,
    session: &mut TrainingSession<'_>,
) -> std::result::Result<FitOutcome, L::Error> {
    let result = fit(task, network, identity, session)?;
    let held_out_mm = task.squares(&result.model)?.into_iter().map(f64::sqrt).collect();
    Ok(FitOutcome { result, held_out_mm })
}
