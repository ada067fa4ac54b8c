//! Learned inverse dynamics: simulated and recorded arms.

use std::path::Path;

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::datasets::{BaxterTraining, RealSet, baxter, characters, kuka, kuka_arm, panda};
use hysteron_arm_learning::lagrangian::{InputForm, TrainingOptions, Variant};
use hysteron_base::BadInput;
use hysteron_learn::Activation;
use hysteron_studies::{
    Listener, RealOptions, SimulatedStudy, Units, characters_study, real_study, simulated_study,
};
use serde_json::Value;

use super::{ActivationName, Options, PolishName, SetName};
use crate::arm_study_figures::{self, RealTable, Study};
use crate::{Context, arm};

/// Carries out the study; `None` where it was interrupted.
pub(super) fn run(
    options: &Options,
    mut listener: Listener<'_>,
    context: &Context,
) -> anyhow::Result<Option<Value>> {
    let cells = options.out.join("cells");
    let study = match options.set {
        SetName::Simulated | SetName::Characters => {
            let study = simulated(options)?;
            let rows = if options.set == SetName::Simulated {
                simulated_study(&study, &Model::builtin("three-link")?, &cells, &mut listener)?
            } else {
                let file = data(options)?.join("delan-characters/characters.csv");
                characters_study(&study, characters(&file)?, &cells, &mut listener)?
            };
            Study::Simulated { study, rows }
        }
        SetName::Recorded => recorded(options, &mut listener, context)?,
        _ => {
            let (set, model) = real_set(options.set, data(options)?)?;
            let options = real(options)?;
            let rows = real_study(&set, &model, &options, &cells, &mut listener)?;
            Study::Real { options, tables: vec![RealTable::new(&set, rows)], left_out: Vec::new() }
        }
    };
    if context.is_cancelled() {
        return Ok(None);
    }
    let meta = arm::meta(context, "study of learned inverse dynamics");
    arm_study_figures::write(&options.out, &study, &meta).map(Some)
}

/// Every recorded set whose folder is there, one after the other.
fn recorded(options: &Options, mut listener: Listener<'_>, context: &Context) -> anyhow::Result<Study> {
    let data = data(options)?;
    let sets = [
        (SetName::BaxterCircle, "baxter", "baxter-circle"),
        (SetName::BaxterHelical, "baxter", "baxter-helical"),
        (SetName::Kuka, "kuka-lwr4", "kuka"),
        (SetName::Panda, "panda-gaz", "panda"),
    ];
    let (there, missing): (Vec<_>, Vec<_>) =
        sets.into_iter().partition(|(_, folder, _)| data.join(folder).is_dir());
    if there.is_empty() {
        let expected = sets.map(|(_, folder, _)| folder)[1..].join(", or ");
        return Err(BadInput::new(data.display().to_string(), expected, "none of them").into());
    }
    let left_out: Vec<String> =
        missing.iter().map(|(_, folder, set)| format!("{set}: no {folder}/")).collect();
    left_out.iter().for_each(|why| tracing::warn!("left out: {why} in {}", data.display()));
    let real = real(options)?;
    let mut tables = Vec::new();
    for (name, _, key) in there {
        let (set, model) = real_set(name, data)?;
        let rows = real_study(&set, &model, &real, &options.out.join("cells").join(key), &mut listener)?;
        if context.is_cancelled() {
            break;
        }
        tables.push(RealTable::new(&set, rows));
    }
    Ok(Study::Real { options: real, tables, left_out })
}

fn data(options: &Options) -> Result<&Path, BadInput> {
    options.data.as_deref().ok_or_else(|| BadInput::new("--data", "a folder of recordings", "nothing"))
}

fn training(options: &Options) -> Result<TrainingOptions, BadInput> {
    let is_simulated = is_simulated(options);
    let epochs = options.epochs.unwrap_or(if is_simulated { 3 } else { 300 });
    let by_default = if is_simulated { PolishName::LevenbergMarquardt } else { PolishName::Lbfgs };
    let polish_by = options.polish_by.unwrap_or(by_default);
    let mut training = if options.published {
        TrainingOptions::published(epochs)
    } else {
        let polish = options.polish.unwrap_or(if is_simulated { 150 } else { 300 }) as usize;
        let normalised = TrainingOptions::normalised(epochs);
        let normalised = match polish_by {
            PolishName::Lbfgs => normalised,
            PolishName::LevenbergMarquardt => normalised.with_levenberg_marquardt(),
        };
        TrainingOptions { polish, learning_rate: 5e-3, ..normalised }
    };
    if let Some(rate) = options.learning_rate {
        if !(rate > 0.0 && rate < 1.0) {
            return Err(BadInput::new("--learning-rate", "above 0 and below 1", rate.to_string()));
        }
        training.learning_rate = rate;
    }
    if !(options.penalty >= 0.0 && options.penalty.is_finite()) {
        return Err(BadInput::new("--penalty", "a number from 0 on", options.penalty.to_string()));
    }
    training.penalty = options.penalty;
    Ok(training)
}

/// Units of a hidden layer, but of simulated arms.
const UNITS: usize = 64;

/// Whether it is the simulated arm in our own form, which has defaults of its own.
fn is_simulated(options: &Options) -> bool {
    options.set == SetName::Simulated && !options.published
}

/// Activation between the layers.
fn activation(options: &Options) -> Activation {
    match options.activation {
        Some(ActivationName::Relu) => Activation::Relu,
        Some(ActivationName::Tanh) => Activation::Tanh,
        None if is_simulated(options) => Activation::Tanh,
        Some(ActivationName::Softplus) | None => Activation::Softplus,
    }
}

fn simulated(options: &Options) -> Result<SimulatedStudy, BadInput> {
    let ([products, squares], units) =
        if is_simulated(options) { ([3, 6], None) } else { ([0; 2], Some(UNITS)) };
    if options.trajectories.iter().any(|n| *n < 2) {
        return Err(BadInput::new("--trajectories", "2 or more, for one validates", "1"));
    }
    Ok(SimulatedStudy {
        variants: if options.variants.is_empty() { Variant::ALL.to_vec() } else { options.variants.clone() },
        seeds: options.seeds as u64,
        first_seed: u64::from(options.first_seed),
        trajectories: options.trajectories.clone(),
        speeds: if options.set == SetName::Simulated { vec![1.0, 1.5, 2.0, 2.5] } else { vec![1.0] },
        hidden: options.hidden.or(units).map(|units| vec![units; 2]),
        activation: activation(options),
        inputs: InputForm::of(options.products.unwrap_or(products) as usize),
        squares: options.squares.unwrap_or(squares) as usize,
        units: if options.published { Units::Si } else { Units::Spread },
        training: training(options)?,
    })
}

fn real(options: &Options) -> Result<RealOptions, BadInput> {
    let variants = [Variant::FeedForward, Variant::Friction, Variant::Augmented];
    if let Some(bad) = options.variants.iter().find(|v| v.is_hamiltonian()) {
        return Err(
            BadInput::new("--variants", "models of velocities", bad.label()).hint("no momenta are recorded")
        );
    }
    Ok(RealOptions {
        variants: if options.variants.is_empty() { variants.to_vec() } else { options.variants.clone() },
        members: options.seeds as u64,
        hidden: vec![options.hidden.unwrap_or(UNITS); 2],
        activation: activation(options),
        training: training(options)?,
        features: options.features,
        lengths: vec![2.0, 4.0, 8.0, 16.0],
        stride: options.stride,
    })
}

/// A recorded set and the kinematics of its arm.
fn real_set(set: SetName, data: &Path) -> anyhow::Result<(RealSet, Model)> {
    let folder = data.join("baxter");
    let arm = || {
        Ok::<_, anyhow::Error>(Model::from_urdf(
            hysteron_arm_learning::datasets::BAXTER_ARM,
            "baxter_arm.urdf",
        )?)
    };
    Ok(match set {
        SetName::BaxterHelical => {
            let test = "sin_XYZ_12_5s_T2_5_Tz_5T_r18_ang_vel_torq.csv";
            (baxter(&folder, test, BaxterTraining::Helical)?, arm()?)
        }
        SetName::Kuka => {
            let folder = data.join("kuka-lwr4");
            (kuka(&folder)?, kuka_arm(&folder)?)
        }
        SetName::Panda => {
            let fingers = [("panda_finger_joint1", 0.0), ("panda_finger_joint2", 0.0)];
            (panda(&data.join("panda-gaz"))?, Model::builtin("panda")?.with_locked(&fingers)?)
        }
        _ => (baxter(&folder, "circle_XY_T2_r10_ang_vel_torq.csv", BaxterTraining::All)?, arm()?),
    })
}
