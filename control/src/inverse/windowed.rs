//! The paper's controller, as published (section V-B c): windows of 200 samples of the tip's x and y, 2 × 512 units
//! with dropout, linear head to all strokes, mean squared error, Adam with a step size that decays step by step.

use hysteron_base::BadInput;
use hysteron_learn::{
    ChannelRange, HeadActivation, Network, Normaliser, TrainingSession, WeightFormat, WindowOptions,
    WindowTask, WindowedSequence,
};

use super::fit::{ControllerParts, FittedController, StrokeDesign, run};
use super::path_point::PathSmoothing;
use super::smooth::{Smoothed, smoothed};
use super::training::{InverseOptions, InverseTraining, TrainedDesign};
use super::{Check, Dataset, Demonstration, InverseDesign, TipPosition};
use crate::Result;

/// As published, but for the decay of the step size: the paper names a `StepLR` and not its numbers.
pub const PUBLISHED: WindowOptions = WindowOptions {
    window: 200,
    stride: 1,
    hidden: 512,
    layers: 2,
    dropout: 0.1,
    epochs: 30,
    batch: 256,
    learning_rate: 1e-3,
    decay_epochs: 10,
    decay_factor: 0.5,
    weight_decay: 1e-4,
    gradient_floor: 1e-16,
    seed: 1,
};

/// Half the time over which the tip is smoothed for the static regression and the workspace; the network sees it as
/// it is.
const HALF_WIDTH_S: f64 = 0.1;
/// Largest delay of the tip in the regression that is the baseline [s].
const LARGEST_DELAY_S: f64 = 0.5;

/// Trains the paper's design; [`PUBLISHED`] are its options.
///
/// # Errors
/// Options out of range, a file of another training, training that leaves finite numbers.
pub fn fit_windowed(
    data: &Dataset,
    options: &WindowOptions,
    session: &mut TrainingSession<'_>,
) -> Result<FittedController> {
    options.check()?;
    let Smoothed { regression_mm, delay_s, workspace, .. } =
        smoothed(data, PathSmoothing::Centred, HALF_WIDTH_S, LARGEST_DELAY_S)?;
    let (inputs, outputs) = (input_ranges(data)?, output_ranges(data)?);
    let paths = [&data.training, &data.validation]
        .map(|all| all.iter().map(|one| normalised(one, &inputs, &outputs)).collect());
    let architecture = options.architecture(data.axes.len(), data.n_tendons, HeadActivation::Linear);
    architecture.check_training([options.window, options.batch], 1)?;
    let network = Network::new(&architecture, options.seed)?;
    let training = InverseTraining::of(TrainedDesign::Paper, InverseOptions::Windowed(options.clone()), data);
    let mut task = WindowTask::new(options, &network, &outputs, 1e3, paths)?;
    let outcome = run(&mut task, network, &training, session)?;
    let floor_error = task.gradient_floor_error(&outcome.result.model)?;
    let parts = ControllerParts {
        inputs,
        outputs,
        design: InverseDesign::Windowed { window: options.window },
        workspace,
        weights: WeightFormat::Float32,
        base: ("static regression", regression_mm),
        delay_s,
    };
    let mut fitted = outcome.into_fitted(data, training, parts)?;
    fitted.model.training.gradient_floor_relative_error = Some(floor_error);
    Ok(fitted)
}

impl StrokeDesign for WindowTask<'_> {
    fn squares(&mut self, network: &Network) -> hysteron_learn::Result<Vec<f64>> {
        WindowTask::squares(self, network)
    }
}

fn input_ranges(data: &Dataset) -> Check<Normaliser> {
    let names: Vec<String> = data.axes.names().iter().map(|axis| format!("tip_{axis}_m")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let tips = data.training.iter().flat_map(|one| one.tip.iter().map(|tip| &tip[..names.len()]));
    Normaliser::from_samples(&names, tips)
}

fn output_ranges(data: &Dataset) -> Check<Normaliser> {
    let names: Vec<String> = (1..=data.n_tendons).map(|k| format!("stroke_{k}_m")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let ranges = Normaliser::from_samples(
        &names,
        data.training.iter().flat_map(|one| one.strokes.chunks_exact(data.n_tendons)),
    )?;
    match ranges.channels.iter().find(|channel| channel.min == channel.max) {
        Some(ChannelRange { name, min, .. }) => {
            Err(BadInput::new(name, "a stroke that changes", format!("{min} m throughout")))
        }
        None => Ok(ranges),
    }
}

fn normalised(one: &Demonstration, inputs: &Normaliser, outputs: &Normaliser) -> WindowedSequence {
    let mut targets = vec![0.0; one.strokes.len()];
    for (i, target) in targets.chunks_exact_mut(one.n_tendons).enumerate() {
        outputs.normalise_into(one.strokes_at(i), target);
    }
    let ends = (0..one.len()).filter(|&i| !one.gap[i]).collect();
    WindowedSequence { inputs: normalised_path(&one.tip, inputs), targets, ends }
}

/// A path as input of the network (n × axes).
pub(super) fn normalised_path(path: &[TipPosition], inputs: &Normaliser) -> Vec<f32> {
    let n = inputs.channels.len();
    let mut values = vec![0.0; n * path.len()];
    for (tip, out) in path.iter().zip(values.chunks_exact_mut(n)) {
        inputs.normalise_into(&tip[..n], out);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_network_is_the_published_one() {
        // Section V-B c: windows of 200 × 2, two layers of 512 with dropout 0.1, linear head to 4 strokes.
        // Parameters by hand: 4·512·(2 + 512 + 1) + 4·512·(512 + 512 + 1) + 4·(512 + 1).
        let architecture = PUBLISHED.architecture(2, 4, HeadActivation::Linear);
        assert_eq!((PUBLISHED.window, PUBLISHED.batch, PUBLISHED.epochs), (200, 256, 30));
        assert_eq!((architecture.dropout, architecture.head), (0.1, HeadActivation::Linear));
        assert_eq!(
            (PUBLISHED.learning_rate, PUBLISHED.decay_epochs, PUBLISHED.decay_factor),
            (1e-3, 10, 0.5)
        );
        assert_eq!(Network::new(&architecture, 1).map(|n| n.n_parameters()).ok(), Some(3_155_972));
    }
}
