//! The page of `arm identify servo`.

use std::path::Path;

use hysteron_actuator::Drive;
use hysteron_actuator::identify::{PendulumRollout, PendulumRun};
use hysteron_actuator::law::{JointFriction, Sliding, holding_range};
use hysteron_report::folder::ReportFolder;
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};

use super::Outcome;
use crate::shared::identification::{ESTIMATE_HEADINGS, ParameterEstimate};
use crate::shared::identification_page::{begin, finish, relative_errors};

/// Motions as measured and as simulated.
pub(super) struct Motions<'a> {
    /// As identified.
    pub drive: &'a Drive,
    /// Recordings: those that were not fitted, where there are any.
    pub runs: &'a [PendulumRun],
    /// The same open loop.
    pub simulated: &'a [PendulumRollout],
}

/// Recordings that are drawn at most.
const MAX_DRAWN: usize = 8;
/// Loads of a diagram.
const LOADS: usize = 41;

/// Writes the figures, `report.html` and `metrics.json` to `folder`.
pub(super) fn write(folder: &ReportFolder, motions: &Motions, outcome: &Outcome) -> anyhow::Result<()> {
    let about = format!(
        "Motor, supply, heat and friction of a {} that swings a weight, so that the simulation, which is given the goals alone, \
         comes nearest to the measured motion.",
        outcome.drive
    );
    let mut page = begin(folder, outcome, &outcome.verdict, ("Identified servo", &about, &outcome.command))?;
    let tested = outcome.test_error_rad.map_or_else(|| "-".to_owned(), |error| format!("{error:.4}"));
    page.list([
        ("Mean error of the angle, open loop [rad]", format!("{:.4}", outcome.error_rad)),
        ("On recordings that were not fitted [rad]", tested),
    ]);
    page.table(&ESTIMATE_HEADINGS, outcome.estimates.iter().map(ParameterEstimate::cells));
    page.heading("Figures");
    for (k, (run, simulated)) in motions.runs.iter().zip(motions.simulated).take(MAX_DRAWN).enumerate() {
        folder.add(&mut page, &motion(k, run, simulated))?;
    }
    let errors = over_speed(motions);
    for chart in [errors, friction(motions), holding(motions), relative_errors(&outcome.estimates)] {
        folder.add(&mut page, &chart)?;
    }
    finish(folder, page, &outcome.recording_warnings)
}

fn motion(k: usize, run: &PendulumRun, simulated: &PendulumRollout) -> TimeChart {
    let errors = simulated.position.iter().zip(&run.position).map(|(a, b)| a - b).collect();
    let panels = vec![
        TimePanel::new(
            "angle [rad]",
            vec![
                Curve::new("goal", 6, run.goal.clone()),
                Curve::new("measured", 5, run.position.clone()),
                Curve::new("simulated", 1, simulated.position.clone()),
            ],
        ),
        TimePanel::new("simulated less measured [rad]", vec![Curve::new("error", 3, errors)]),
        TimePanel::new("current, simulated [A]", vec![Curve::new("current", 0, simulated.current.clone())]),
    ];
    let name =
        Path::new(&run.name).file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let title = format!("{name}: gain {}", run.gain);
    let caption = "Angle over time [s]: goal, measured, simulated open loop; their difference; current of the simulated motor.";
    TimeChart::over_time(format!("motion-{}", k + 1), title, caption, &run.time, panels)
}

/// Residuals over the measured speed.
fn over_speed(motions: &Motions) -> ScatterChart {
    let (mut speeds, mut errors) = (Vec::new(), Vec::new());
    for (run, simulated) in motions.runs.iter().zip(motions.simulated) {
        for k in 1..run.time.len().saturating_sub(1) {
            speeds.push((run.position[k + 1] - run.position[k - 1]) / (run.time[k + 1] - run.time[k - 1]));
            errors.push(simulated.position[k] - run.position[k]);
        }
    }
    ScatterChart {
        name: "residuals-speed".into(),
        title: "Residuals over speed".into(),
        caption: "Simulated less measured angle over the measured speed, all recordings together.".into(),
        tiles: vec![Scatter {
            x_name: "speed [rad/s]".into(),
            y_name: "simulated less measured [rad]".into(),
            marks: vec![Marks::dots("samples", 3, &speeds, &errors)],
        }],
    }
}

/// Largest torque of a weight in the recordings [N m].
fn largest_load(motions: &Motions) -> f64 {
    motions.runs.iter().map(|run| run.pendulum.mass * run.pendulum.length * 9.81).fold(0.0, f64::max)
}

/// Friction over speed under several loads, the motor holding the load.
fn friction(motions: &Motions) -> ScatterChart {
    let gear = &motions.drive.gear;
    let fastest = motions
        .runs
        .iter()
        .flat_map(|run| {
            run.position
                .windows(2)
                .zip(run.time.windows(2))
                .map(|(q, t)| ((q[1] - q[0]) / (t[1] - t[0])).abs())
        })
        .fold(0.1, f64::max);
    let speeds: Vec<f64> = (1..=120).map(|k| fastest * f64::from(k) / 120.0).collect();
    let largest = largest_load(motions);
    let line = |(k, part): (usize, f64)| {
        let load = part * largest;
        let torque = |v: &f64| {
            gear.law.torque(&gear.friction, &Sliding { velocity: *v, motor_torque: load, load_torque: -load })
        };
        Marks::line(format!("load {load:.2} N m"), k, &speeds, &speeds.iter().map(torque).collect::<Vec<_>>())
    };
    ScatterChart {
        name: "friction".into(),
        title: "Friction".into(),
        caption: "Torque of friction over speed while the motor holds loads up to the largest weight of the recordings.".into(),
        tiles: vec![Scatter {
            x_name: "speed [rad/s]".into(),
            y_name: "friction [N m]".into(),
            marks: [0.0, 0.5, 1.0].into_iter().enumerate().map(line).collect(),
        }],
    }
}

/// The drive and backdrive diagram.
fn holding(motions: &Motions) -> ScatterChart {
    let gear = &motions.drive.gear;
    let largest = 2.0 * largest_load(motions);
    let loads: Vec<f64> = (0..LOADS).map(|k| largest * k as f64 / (LOADS - 1) as f64).collect();
    let ranges: Vec<_> = loads.iter().map(|load| holding_range(&gear.law, &gear.friction, *load)).collect();
    let drive: Vec<f64> = ranges.iter().map(|range| range.drive.unwrap_or(f64::NAN)).collect();
    let back: Vec<f64> = ranges.iter().map(|range| range.backdrive).collect();
    ScatterChart {
        name: "drive-backdrive".into(),
        title: "Drive and backdrive".into(),
        caption: "Torque of the motor over the load that pulls back, at standstill: above the upper line the motor lifts the load, below the \
                  lower one the load turns the motor, between them friction holds. Without friction both were the line in the middle."
            .into(),
        tiles: vec![Scatter {
            x_name: "load [N m]".into(),
            y_name: "torque of the motor [N m]".into(),
            marks: vec![
                Marks::line("no friction", 6, &loads, &loads),
                Marks::line("drives", 1, &loads, &drive),
                Marks::line("is driven back", 0, &loads, &back),
            ],
        }],
    }
}
