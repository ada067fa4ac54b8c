//! From a path to strokes through the calibrated twin.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Channel, Metadata, Recording, Scene};
use hysteron_control::plan::Tendons;
use hysteron_twin::Twin;
use hysteron_twin::coreact::Auxiliary;
use hysteron_twin::residual::{Bare, FollowLimits, Follower, Plant, ResidualModel, Rollout};

use crate::terminal;

/// Follow
#[derive(Debug, clap::Args)]
pub struct Arguments {
    scene: PathBuf,
    #[arg(long)]
    residual: Option<PathBuf>,
    #[arg(long)]
    target: PathBuf,
    #[arg(long)]
    out: PathBuf,
    #[arg(long, default_value_t = 9.0)]
    stroke_max_mm: f64,
    #[arg(long, default_value_t = 7.0)]
    stroke_rate_max_mm_s: f64,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let scene = Scene::read(&arguments.scene)?;
    let twin = Twin::from_scene(&scene)?;
    let target = Recording::read(&arguments.target)?;
    let duration = target
        .rate_hz()
        .map(f64::recip)
        .ok_or_else(|| BadInput::new("time_s", "a fixed rate", "uneven steps"))?;
    let tendons = Tendons { angles: angles(&scene), release: 1.0, co_contraction: 0.0 };
    let coordinates = |point: [f64; 2], strokes: &mut [f64]| {
        for (k, stroke) in strokes.iter_mut().enumerate() {
            *stroke = tendons.stroke(k, point);
        }
    };
    let model = arguments.residual.as_deref().map(ResidualModel::read).transpose()?;
    let auxiliary = Auxiliary::new(&twin);
    let plant: Box<dyn Plant> = match &model {
        Some(model) => {
            let auxiliary = auxiliary.as_ref().map_err(|e| anyhow::anyhow!("{e}"))?;
            Box::new(Rollout::new(&twin, auxiliary, model, duration)?)
        }
        None => Box::new(Bare::new(&twin)),
    };
    let limits =
        FollowLimits { stroke: 1e-3 * arguments.stroke_max_mm, rate: 1e-3 * arguments.stroke_rate_max_mm_s };
    let mut follower = Follower::new(&twin, plant, &coordinates, limits, duration)?;
    let (x, y) = (target.require("tip_x_m")?, target.require("tip_y_m")?);
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); twin.n_primary + 5];
    let mut square = 0.0;
    let mut time = target.time().to_vec();
    for i in 0.. {
        let step = match x.get(i) {
            Some(x) => follower.step([*x, y[i]])?,
            None if follower.is_home() => break,
            None => follower.step_home()?,
        };
        if let Some(x) = x.get(i) {
            square += (step.tip[0] - x).powi(2) + (step.tip[1] - y[i]).powi(2);
        } else {
            time.push(target.time()[0] + i as f64 * duration);
        }
        let flags = [step.is_limited, step.is_extrapolating].map(|flag| f64::from(u8::from(flag)));
        let row = follower.strokes().iter().chain(&step.tip).chain(&flags);
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
    }
    tracing::info!(
        "tip within {:.3} mm (rms) of the path in the twin",
        1e3 * (square / x.len() as f64).sqrt()
    );
    let names = (1..=twin.n_primary)
        .map(|k| format!("stroke_{k}_m"))
        .chain(["tip_x_m", "tip_y_m", "tip_z_m", "limited", "extrapolating"].map(str::to_owned));
    let channels = names.zip(columns).map(|(name, values)| Channel::new(name, values)).collect();
    let meta = Metadata { command: terminal::command_line(), ..Metadata::default() };
    Recording::new(time, channels, Vec::new(), meta)?.write(&arguments.out)?;
    terminal::say(arguments.out.display());
    Ok(())
}

fn angles(scene: &Scene) -> Vec<f64> {
    let angle = |point: [f64; 3]| point[1].atan2(point[0]).rem_euclid(TAU);
    scene.tendons.iter().map(|tendon| angle(tendon.points[0])).collect()
}

fn _unused(_: &Path) {}
