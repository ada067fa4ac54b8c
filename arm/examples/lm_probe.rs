#![allow(clippy::print_stdout, clippy::unwrap_used)]
use hysteron_arm::Model;
use hysteron_arm::lagrangian::*;
use hysteron_learn::{Activation, Progress, Session};
use std::time::Instant;

fn main() {
    let a: Vec<String> = std::env::args().collect();
    if a[1] == "study" {
        let study: hysteron_arm::study::SimulatedStudy =
            serde_json::from_str(&std::fs::read_to_string(&a[3]).unwrap()).unwrap();
        let rows = hysteron_arm::study::simulated_study(
            &study,
            &Model::builtin("three-link").unwrap(),
            std::path::Path::new(&a[2]),
            &mut |_| true,
        )
        .unwrap();
        println!("{} rows", rows.len());
        return;
    }
    let variant: Variant = serde_json::from_value(a[1].as_str().into()).unwrap();
    let num = |k: usize| a[k].parse::<f64>().unwrap();
    let (width, epochs, steps, batch, rows, traj) = (
        num(3) as usize,
        num(4) as usize,
        num(5) as usize,
        num(6) as usize,
        num(7) as usize,
        num(8) as usize,
    );
    let activation: Activation = serde_json::from_value(a[2].as_str().into()).unwrap();
    let model = Model::builtin("three-link").unwrap();
    let (all, _) = sinusoids(&model, &Sinusoids::published(traj), 0, "arm/study/training");
    let held = traj.div_ceil(10);
    let (training, validation) = (all.select(held..traj), all.select(0..held));
    let tests: Vec<_> = [1.0, 2.5]
        .iter()
        .map(|s| sinusoids(&model, &Sinusoids { speed: *s, ..Sinusoids::published(3) }, 0, "arm/study/test"))
        .collect();
    let shape = NetworkShape {
        variant,
        hidden: vec![width; 2],
        activation,
        epsilon: 1e-4,
        scales: Scales::of(&training, variant),
        lengths: vec![None; 3],
        inputs: if num(9) == 0.0 { InputForm::SinesAndCosines } else { InputForm::Products(num(9) as usize) },
    };
    let options = TrainingOptions {
        learning_rate: 5e-3,
        polish: steps,
        polish_samples: rows,
        polish_by: Polish::LevenbergMarquardt { batch },
        penalty: 0.1,
        ..TrainingOptions::normalised(epochs)
    };
    println!("parameters {}", shape.n_parameters());
    let start = Instant::now();
    let mut progress = |p: &Progress| {
        if let Progress::Epoch(e) = p {
            if e.of == steps && e.number % 10 == 0 || e.number % 25 == 0 {
                println!(
                    "{:.1} s: {}/{} training {:.3e} validation {:.3e} best {:.3e}",
                    start.elapsed().as_secs_f64(),
                    e.number,
                    e.of,
                    e.training,
                    e.validation,
                    e.best
                );
            }
        }
        true
    };
    let trained = train(
        &shape,
        [&training, &validation],
        &options,
        0,
        &mut Session { file: None, progress: &mut progress },
    )
    .unwrap();
    for (samples, truth) in &tests {
        let found = decompose(&shape, &trained.parameters, samples);
        let s = |a: &[f64], b: &[f64]| Scores::of(3, a, b).sum_nmse();
        println!(
            "torque {:.2e} inertial {:.2e} coriolis {:.2e} gravity {:.2e}",
            s(&truth.torque, &found.torque),
            s(&truth.inertial, &found.inertial),
            s(&truth.coriolis, &found.coriolis),
            s(&truth.gravity, &found.gravity)
        );
    }
    println!(
        "{variant:?} {:?} validation {:.3e}, {:.1} s",
        trained.steps,
        trained.validation,
        start.elapsed().as_secs_f64()
    );
}
