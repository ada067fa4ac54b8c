//! What both designs share in training: epochs, the best weights on trajectories held out, and going on from a file.

use hysteron_learn::{Adam, Learned, Lesson, Network, Normaliser, Session, Trainer, Training, teach};
use serde_json::{Value, json};

use super::{Dataset, Demonstration, Design, InverseModel, Workspace};

/// A trained controller and how well it does on the trajectories held out.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// With the best weights.
    pub model: InverseModel,
    /// Root mean square error of each stroke [mm].
    pub held_out_mm: Vec<f64>,
    /// The same of the static regression alone.
    pub regression_mm: Vec<f64>,
    /// False where the training was ended before its time and can go on from its file.
    pub is_finished: bool,
}

/// A design in training, judged by its strokes in millimetres.
pub(super) trait Strokes: Lesson {
    /// Mean square error of each stroke held out [mm²].
    fn squares(&self, training: &Training) -> Result<Vec<f64>, Self::Error>;
}

/// The best weights, the epochs after which they were found, and whether the training came to its end.
pub(super) struct Outcome {
    pub learned: Learned,
    /// Root mean square error of each stroke held out [mm].
    pub held_out_mm: Vec<f64>,
}

/// What a controller is made of beside its network.
pub(super) struct Parts {
    pub inputs: Normaliser,
    pub outputs: Normaliser,
    pub design: Design,
    pub workspace: Workspace,
    /// Root mean square error of the static regression for each stroke held out [mm].
    pub regression_mm: Vec<f64>,
}

impl Outcome {
    /// The controller; `identity` is that of the training.
    pub fn into_fitted(self, data: &Dataset, identity: Value, parts: Parts) -> Fitted {
        let Parts { inputs, outputs, design, workspace, regression_mm } = parts;
        let mut training = identity;
        training["epochs"] = json!(self.learned.epochs);
        training["held_out_stroke_rmse_mm"] = json!(self.held_out_mm);
        training["static_regression_stroke_rmse_mm"] = json!(regression_mm);
        let model = InverseModel {
            network: self.learned.network,
            inputs,
            outputs,
            design,
            n_tendons: data.n_tendons,
            step_s: data.step,
            limits: data.limits(),
            workspace,
            robots: data.robots(),
            training,
        };
        let is_finished = self.learned.is_finished;
        Fitted { model, held_out_mm: self.held_out_mm, regression_mm, is_finished }
    }
}

/// Trains `network`, or goes on from the session's file; see [`teach`].
pub(super) fn run<L: Strokes>(
    lesson: &mut L,
    network: Network,
    seed: u64,
    identity: &Value,
    session: &mut Session<'_>,
) -> Result<Outcome, L::Error> {
    let learned = teach(lesson, network, seed, identity, session)?;
    // Judged by themselves, not by what the training came to after them.
    let judged = Training::new(Trainer::new(learned.network.clone(), Adam::default(), seed)?, None);
    let held_out_mm = lesson.squares(&judged)?.into_iter().map(f64::sqrt).collect();
    Ok(Outcome { learned, held_out_mm })
}

/// What is trained on what, for a file to go on from and for the checkpoint.
pub(super) fn identity(design: &str, options: Value, data: &Dataset) -> Value {
    let listed = |all: &[Demonstration]| -> Vec<Value> {
        let entry =
            |one: &Demonstration| json!({ "name": one.name, "sha256": one.hash, "origin": one.origin });
        all.iter().map(entry).collect()
    };
    json!({
        "design": design, "options": options,
        "trained_on": listed(&data.training), "held_out": listed(&data.validation),
    })
}
