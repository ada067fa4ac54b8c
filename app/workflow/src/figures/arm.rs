//! The report of an arm's motion: joints, torques and what they are spent on, energies, and the arm at several times.

use std::path::Path;

use hysteron_arm::{
    Data, JointKind, Model, Quantity, Wanted, channel_name, dynamics_of_rows, joint_rows, skeleton,
};
use hysteron_base::{Metadata, Recording};
use plotters::prelude::*;

use hysteron_report::figure::{Figure, register_embedded_font, save};
use hysteron_report::lines::{Curve, TimeChart, TimePanel};
use hysteron_report::page::{Page, write_metrics, write_page};
use hysteron_report::sheet::{BELOW, LEFT, Sheet, number, padded, ramp};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::MetricsFormat;

/// Times at which the arm is drawn.
const POSES: usize = 7;

/// Writes the figures, `report.html` and `metrics.json` of `motion` to `folder`.
pub fn write(
    folder: &Path,
    model: &Model,
    motion: &Recording,
    outcome: &Outcome,
    with_png: bool,
) -> anyhow::Result<()> {
    register_embedded_font()?;
    write_metrics(folder, outcome)?;
    let Outcome { samples, duration_s, joints: ends, energy_j, .. } = outcome;
    let mut page = Page::new(&format!("Motion of {}", model.name()), &motion.meta().source, &outcome.command);
    page.heading("Results");
    page.list([
        ("Duration [s]", format!("{duration_s:.3}")),
        ("Samples", samples.to_string()),
        ("Energy at the start and at the end [J]", format!("{:.4}, {:.4}", energy_j[0], energy_j[1])),
    ]);
    let cells =
        |row: &JointMotionRange| [row.name.clone(), number(row.least), number(row.most), number(row.fastest)];
    let head = ["Joint", "Least [rad or m]", "Most", "Fastest [1/s]"];
    page.table(&head, ends.iter().map(|row| cells(row).to_vec()));
    page.heading("Figures");
    page.figure(&save(folder, &ArmPicture::new(model, motion)?, with_png)?);
    for chart in [joints(model, motion)?, torques(model, motion)?, energies(motion, total_energy(motion)?)?] {
        page.figure(&save(folder, &chart, with_png)?);
    }
    write_page(folder, page.finish(&outcome.commit))?;
    Ok(())
}

/// The outcome of `arm simulate`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the robot.
    pub robot: String,
    /// Number of samples.
    pub samples: usize,
    /// Time from the first to the last sample [s].
    pub duration_s: f64,
    /// One entry per joint.
    pub joints: Vec<JointMotionRange>,
    /// Energy at the start and at the end [J].
    pub energy_j: [f64; 2],
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    /// Of a simulated motion.
    pub fn new(model: &Model, motion: &Recording) -> anyhow::Result<Self> {
        let (meta, time, total) = (motion.meta(), motion.time(), total_energy(motion)?);
        Ok(Self {
            format: MetricsFormat,
            version: 1,
            robot: model.name().to_owned(),
            samples: time.len(),
            duration_s: time[time.len() - 1] - time[0],
            joints: ends(model, motion)?,
            energy_j: [total[0], total[total.len() - 1]],
            command: meta.command.clone(),
            commit: meta.commit.clone(),
        })
    }
}

/// Kinetic and potential energy together [J].
fn total_energy(motion: &Recording) -> anyhow::Result<Vec<f64>> {
    let [kinetic, potential] = ["kinetic_energy_j", "potential_energy_j"].map(|name| motion.require(name));
    Ok(kinetic?.iter().zip(potential?).map(|(a, b)| a + b).collect())
}

/// How far and how fast a joint went, in its unit.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct JointMotionRange {
    /// Name of the joint.
    pub name: String,
    /// Smallest coordinate [rad or m].
    pub least: f64,
    /// Largest coordinate [rad or m].
    pub most: f64,
    /// Largest speed [rad/s or m/s].
    pub fastest: f64,
}

fn ends(model: &Model, motion: &Recording) -> anyhow::Result<Vec<JointMotionRange>> {
    let end = |(k, joint): (usize, &hysteron_arm::Joint)| {
        let of = |quantity| motion.require(&channel_name(model, quantity, k));
        let (q, dq) = (of(Quantity::Position)?, of(Quantity::Velocity)?);
        Ok(JointMotionRange {
            name: joint.name.clone(),
            least: q.iter().copied().fold(f64::INFINITY, f64::min),
            most: q.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            fastest: dq.iter().fold(0.0, |most, speed| f64::max(most, speed.abs())),
        })
    };
    model.joints().iter().enumerate().map(end).collect()
}

/// Names of the joints of one kind, and their numbers.
pub(super) fn of_kind(model: &Model, kind: JointKind) -> Vec<(usize, &str)> {
    let joints = model.joints().iter().enumerate();
    joints.filter(|(_, joint)| joint.kind == kind).map(|(k, joint)| (k, joint.name.as_str())).collect()
}

fn joints(model: &Model, motion: &Recording) -> anyhow::Result<TimeChart> {
    let mut panels = Vec::new();
    for (kind, unit) in [(JointKind::Revolute, "rad"), (JointKind::Prismatic, "m")] {
        for (quantity, label) in
            [(Quantity::Position, format!("q [{unit}]")), (Quantity::Velocity, format!("q' [{unit}/s]"))]
        {
            let curve = |(i, (k, name)): (usize, (usize, &str))| {
                Ok(Curve::new(name, i, motion.require(&channel_name(model, quantity, k))?.to_vec()))
            };
            let curves =
                of_kind(model, kind).into_iter().enumerate().map(curve).collect::<anyhow::Result<_>>()?;
            panels.push(TimePanel::new(label, curves));
        }
    }
    panels.retain(|panel| !panel.curves.is_empty());
    let caption = "Coordinate and speed of every joint over time [s]; each panel has its own scale.";
    Ok(TimeChart::over_time("joints", "Joints", caption, motion.time(), panels))
}

fn torques(model: &Model, motion: &Recording) -> anyhow::Result<TimeChart> {
    let parts =
        dynamics_of_rows(model, motion, Wanted { frame: 0, derivatives: false }, Metadata::default())?;
    let panel = |(k, joint): (usize, &hysteron_arm::Joint)| {
        let unit = if joint.kind == JointKind::Revolute { ["n_m", "N m"] } else { ["n", "N"] };
        let applied = motion.require(&channel_name(model, Quantity::Torque, k))?;
        let of = |stem: &str| parts.require(&format!("{stem}_{}_{}", k + 1, unit[0]));
        let (gravity, coriolis) = (of("gravity")?, of("coriolis")?);
        let rest = (0..applied.len()).map(|i| applied[i] - gravity[i] - coriolis[i]).collect();
        let curves = vec![
            Curve::new("applied", 0, applied.to_vec()),
            Curve::new("gravity", 1, gravity.to_vec()),
            Curve::new("Coriolis", 2, coriolis.to_vec()),
            Curve::new("inertia, friction, stops", 3, rest),
        ];
        Ok(TimePanel::new(format!("{} [{}]", joint.name, unit[1]), curves))
    };
    let panels = model.joints().iter().enumerate().map(panel).collect::<anyhow::Result<_>>()?;
    let caption = "What every joint is driven with, and what it is spent on, over time [s]: against gravity, against Coriolis \
                   and centrifugal torques, and what is left, which accelerates the arm or goes into friction and stops.";
    Ok(TimeChart::over_time("torques", "Torques", caption, motion.time(), panels))
}

fn energies(motion: &Recording, total: Vec<f64>) -> anyhow::Result<TimeChart> {
    let curves = vec![
        Curve::new("kinetic", 0, motion.require("kinetic_energy_j")?.to_vec()),
        Curve::new("potential", 1, motion.require("potential_energy_j")?.to_vec()),
        Curve::new("sum", 2, total),
    ];
    let caption = "Energy of the arm [J] over time [s]; potential energy is zero in the height of the base.";
    let panels = vec![TimePanel::new("energy [J]", curves)];
    Ok(TimeChart::over_time("energies", "Energies", caption, motion.time(), panels))
}

/// The arm as lines between its joints, at several times, from two sides.
pub(super) struct ArmPicture {
    /// Times [s], and lines from point to point [m].
    poses: Vec<(f64, Vec<[[f64; 3]; 2]>)>,
}

/// Size of a view, and of the bar of colours [px].
const VIEW: [f64; 2] = [400.0, 400.0];
const BAR: [f64; 2] = [90.0, 400.0];
/// Axes to the right and up.
const VIEWS: [[usize; 2]; 2] = [[0, 2], [1, 2]];

impl ArmPicture {
    pub(super) fn new(model: &Model, motion: &Recording) -> anyhow::Result<Self> {
        let (n, time) = (model.n_joints(), motion.time());
        let rows = joint_rows(model, motion, Quantity::Position)?.unwrap_or_default();
        let mut data = Data::new(model, 0.0);
        let last = time.len() - 1;
        let mut at: Vec<usize> = (0..POSES).map(|k| k * last / (POSES - 1)).collect();
        at.dedup();
        let pose = |i: usize| (time[i], skeleton(model, &mut data, &rows[n * i..n * (i + 1)]));
        Ok(Self { poses: at.into_iter().map(pose).collect() })
    }

    /// From the smallest to the largest coordinate [m].
    fn extent(&self, axis: usize) -> std::ops::Range<f64> {
        padded(self.poses.iter().flat_map(|(_, lines)| lines.iter().flatten()).map(|point| point[axis]))
    }

    /// Part of the time that has passed at pose `k` [-].
    fn part(&self, k: usize) -> f64 {
        k as f64 / (self.poses.len() - 1).max(1) as f64
    }
}

impl Figure for ArmPicture {
    fn name(&self) -> String {
        "arm".to_owned()
    }

    fn title(&self) -> String {
        "The arm".to_owned()
    }

    fn caption(&self) -> String {
        format!(
            "Lines between the joints and to the frames of the arm [m], from the front and from the right, at {} times; the \
             colours are those of the time [s].",
            self.poses.len()
        )
    }

    fn tiles(&self) -> Vec<[f64; 2]> {
        vec![VIEW, VIEW, BAR]
    }

    fn draw<DB: DrawingBackend>(&self, tile: usize, sheet: &Sheet<DB>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let Some(axes) = VIEWS.get(tile) else {
            let last = self.poses.last().map_or(0.0, |(time, _)| *time);
            return sheet.color_bar("time [s]", self.poses[0].0, last);
        };
        // The same scale along both axes, and in both views.
        let (width, height) = sheet.size();
        let room = f64::min(width - LEFT, height - BELOW);
        let span = (0..3).map(|axis| self.extent(axis)).map(|own| own.end - own.start).fold(0.0, f64::max);
        let range = |axis: usize, px: f64| {
            let own = self.extent(axis);
            let (middle, half) = (0.5 * (own.start + own.end), 0.5 * span * px / room);
            middle - half..middle + half
        };
        let [x, y] = axes.map(|axis| format!("{} [m]", ["x", "y", "z"][axis]));
        let mut chart = sheet.chart(range(axes[0], width - LEFT), range(axes[1], height - BELOW), &x, &y)?;
        for (k, (_, lines)) in self.poses.iter().enumerate() {
            let style = sheet.line(ramp(self.part(k)), 2.5);
            let flat = |point: &[f64; 3]| (point[axes[0]], point[axes[1]]);
            chart.draw_series(
                lines.iter().map(|line| PathElement::new(line.each_ref().map(flat).to_vec(), style)),
            )?;
        }
        Ok(())
    }
}
