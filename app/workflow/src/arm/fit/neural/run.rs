//! Trains an actuator, and the network of force and condition, from recordings.

use std::time::Instant;

use hysteron_arm_learning::neural::{
    ActuatorDetails, ActuatorOptions, ActuatorSession, FeatureLayout, NeuralActuator, TrainingStage,
    Trajectory, fit_actuator,
};
use hysteron_base::checks::Purpose;
use hysteron_learn::TrainingProgress;
use hysteron_report::verdict::{Criterion, Verdict};

use super::data::{features_of, names, print_data};
use super::{Options, Outcome};
use crate::arm::recordings::{Role, checked, files, read, trajectories};
use crate::arm::{self, robot::held_joints};
use crate::shared::identification::deviation;
use crate::shared::{resume::Unfinished, verdict};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// `BadInput` for invalid options or recordings; an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(fit(options, context)?)
}

fn fit(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let files = files(&options.recordings, &options.leave_out)?;
    let drive_file = options.drive.as_deref().and_then(arm::file_of);
    let outputs = arm::reads(&options.model).and(&files).and(drive_file).learned("--out", &options.out);
    let _lock = outputs.check(context)?;
    let model = options.robot_options.model(&options.model, context)?;
    let actuator_options = options.actuator(options.drive.as_deref().map(arm::drive).transpose()?)?;
    context.listen();
    let named = read(&files)?;
    let findings = checked(&named, &model, Purpose::Fit)?;
    let features = features_of(&named)?;
    let settings = (&features, options.period_s, &options.free[..]);
    let [training, validation] =
        [Role::Training, Role::Validation].map(|role| trajectories(&named, role, settings));
    let (training, validation) = (training?, validation?);
    let n_parameters = actuator_options.shape(&features).n_parameters();
    print_data(&training, &validation, n_parameters, context);
    let files = ["training", "sensing-training"].map(|ending| options.out.with_extension(ending));
    let unfinished =
        Unfinished::new(&options.out, files[..1 + usize::from(actuator_options.sensing.is_some())].to_vec());
    let start = Instant::now();
    let mut bars = Bars { context, options: &actuator_options, bars: [None, None] };
    let mut session = ActuatorSession {
        recordings: &names(&named),
        files: [&files[0], &files[1]],
        progress: &mut |stage, p| bars.show(stage, p),
    };
    let found = fit_actuator(&model, &features, [&training, &validation], &actuator_options, &mut session)?;
    bars.finish();
    // Without the second network it would pass for another actuator.
    if found.actuator.sensing.is_some() != actuator_options.sensing.is_some() {
        return Err(unfinished.nothing_written());
    }
    let rate = found.steps as f64 / start.elapsed().as_secs_f64();
    let details = ActuatorDetails {
        options: Some(actuator_options.training),
        sensing_options: actuator_options.sensing,
        validation_deg: Some(found.validation),
        epochs: Some(found.epochs),
        recordings: names(&named),
        curve: found.curve,
        left_out: Some(options.leave_out.clone()),
        provenance: Some(context.provenance()),
        ..found.actuator.details
    };
    let actuator = NeuralActuator { details, ..found.actuator };
    actuator.write(&options.out)?;
    print_result((found.validation, found.sensing_validation), rate, context);
    unfinished.end(found.is_finished, context)?;
    Ok(Outcome {
        validation_deg: found.validation,
        epochs: found.epochs,
        parameters: n_parameters,
        steps_per_second: rate,
        sensing_validation: found.sensing_validation,
        actuator: options.out.clone(),
        verdict: assessed(found.validation, &validation, &features),
        recording_warnings: findings.into_warnings(),
        held_joints: held_joints(&model),
    })
}

/// Prints the errors in validation, and how fast the training was [steps/s].
fn print_result((error_deg, sensing_loss): (f64, Option<f64>), rate: f64, context: &Context) {
    context.print(format_args!("{rate:.0} simulated steps a second in training"));
    context.print(format_args!(
        "joints {:.3}° (root mean square) in rollouts of validation recordings",
        error_deg
    ));
    if let Some(loss) = sensing_loss {
        context.print(format_args!("force, contact and condition: validation loss {loss:.4}"));
    }
}

/// Whether the actuator moves the arm as measured: error of the joints in rollouts on what was not trained on [deg].
fn assessed(error: f64, validation: &[Trajectory], features: &FeatureLayout) -> Verdict {
    let (n, width) = (features.joints, 2 * (features.joints + usize::from(features.gripper.is_some())));
    let squares = |j: usize| {
        let rows = validation.iter().flat_map(|one| one.states.chunks_exact(width));
        let positions: Vec<f64> = rows.map(|row| row[j]).collect();
        deviation(&positions).to_degrees().powi(2)
    };
    let spread = ((0..n).map(squares).sum::<f64>() / n as f64).sqrt();
    let assessed = Verdict::on(format!("joints are simulated within {error:.2}° (RMS)")).because(
        Criterion::ErrorOverSpread,
        error / spread,
        format!("in validation, joints are off by {error:.2}°; they move by {spread:.2}° about their mean"),
    );
    verdict::repeated(assessed, validation.len(), "trajectory in validation").verdict()
}

/// A bar for either network.
struct Bars<'a> {
    context: &'a Context<'a>,
    options: &'a ActuatorOptions,
    bars: [Option<Box<dyn crate::Progress>>; 2],
}

impl Bars<'_> {
    fn show(&mut self, stage: TrainingStage, p: &TrainingProgress) -> bool {
        let Self { context, options, bars } = self;
        let trained = &options.training;
        let (k, title, of, epoch) = match (stage, &options.sensing) {
            (TrainingStage::Sensing, Some(own)) => {
                (1, "updates of force and condition", own.updates, own.epoch)
            }
            _ => (0, "updates", trained.warm_start + trained.updates, trained.epoch),
        };
        let bar = bars[k].get_or_insert_with(|| context.progress(title, of as usize, 0));
        match p {
            TrainingProgress::Step { epoch: done_epochs, done, .. } => {
                bar.set_position(*done_epochs as u64 * epoch + *done as u64)
            }
            TrainingProgress::Epoch(own) if stage == TrainingStage::Loop => {
                bar.set_message(format!("joints {:.3}° in validation, best {:.3}°", own.validation, own.best))
            }
            TrainingProgress::Epoch(own) => {
                bar.set_message(format!("loss {:.4} in validation, best {:.4}", own.validation, own.best))
            }
        }
        !context.is_cancelled()
    }

    fn finish(&self) {
        self.bars.iter().flatten().for_each(|bar| bar.finish());
    }
}
