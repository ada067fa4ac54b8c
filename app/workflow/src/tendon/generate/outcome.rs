//! The outcome of `generate`: the card of a synthetic data set.

use std::collections::BTreeMap;

use hysteron_base::{BadInput, Recording, Scene};
use hysteron_control::Trajectory;
use hysteron_control::inverse::{Axes, TipPosition, TipWorkspace};
use hysteron_twin::synthetic::OUTSIDE_VALIDATION;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::range::CalibratedRange;
use crate::shared::inputs::Input;
use crate::shared::outcome::MetricsFormat;
use crate::{COMMIT, Context};

/// Part of the samples in which a network may guess before a user is warned [-].
const GUESSED: f64 = 0.2;

/// One trajectory.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SyntheticTrajectory {
    /// Its name.
    pub name: String,
    /// Family of its motion.
    pub family: String,
    /// Amplitude of the strokes [m].
    pub amplitude_m: f64,
    /// Frequency [Hz].
    pub frequency_hz: f64,
    /// Number of samples; none if it was skipped.
    pub samples: usize,
    /// Why it was skipped; empty if it was not.
    pub left_out: String,
    /// Part of the samples in which the network left its training range [-].
    pub extrapolating: f64,
    /// Part of the samples in which a chain was bent further than it was validated [-].
    #[serde(default)]
    pub outside_validation: f64,
    /// Largest distance of the tip from the axis [m].
    pub reach_m: f64,
    /// Largest tension of a tendon [N].
    pub tension_max_n: f64,
    /// Tip, x and y [m].
    #[serde(skip)]
    pub tip: Vec<[f64; 2]>,
}

impl SyntheticTrajectory {
    fn new(trajectory: &Trajectory) -> Self {
        Self {
            name: trajectory.name.clone(),
            family: trajectory.motion.family.name().to_owned(),
            amplitude_m: trajectory.motion.amplitude,
            frequency_hz: trajectory.motion.frequency,
            samples: 0,
            left_out: String::new(),
            extrapolating: 0.0,
            outside_validation: 0.0,
            reach_m: 0.0,
            tension_max_n: 0.0,
            tip: Vec::new(),
        }
    }

    /// One that the twin did.
    pub fn made(trajectory: &Trajectory, recording: Recording) -> Result<Self, BadInput> {
        let tip = tip_of(&recording)?;
        let part = |flags: &[f64]| flags.iter().sum::<f64>() / flags.len() as f64;
        let tensions = recording.numbered("tension", "n");
        Ok(Self {
            samples: tip.len(),
            extrapolating: part(recording.require("extrapolating")?),
            outside_validation: recording.channel(OUTSIDE_VALIDATION).map_or(0.0, part),
            reach_m: tip.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max),
            tension_max_n: tensions.into_iter().flatten().copied().fold(0.0, f64::max),
            tip,
            ..Self::new(trajectory)
        })
    }

    /// One that it could not do.
    pub fn dropped(trajectory: &Trajectory, why: String) -> Self {
        Self { left_out: why, ..Self::new(trajectory) }
    }

    /// Headings of [`SyntheticTrajectory::cells`].
    pub const HEADINGS: [&'static str; 8] = [
        "Trajectory",
        "Family",
        "Amplitude [mm]",
        "Period [s]",
        "Samples",
        "Reach of the tip [mm]",
        "Largest tension [N]",
        "Network outside its training [%]",
    ];

    /// The numbers as text.
    pub fn cells(&self) -> Vec<String> {
        let mut cells = vec![
            self.name.clone(),
            self.family.clone(),
            format!("{:.2}", 1e3 * self.amplitude_m),
            format!("{:.1}", self.frequency_hz.recip()),
        ];
        if self.left_out.is_empty() {
            cells.push(self.samples.to_string());
            cells.push(format!("{:.1}", 1e3 * self.reach_m));
            cells.push(format!("{:.1}", self.tension_max_n));
            cells.push(format!("{:.1}", 100.0 * self.extrapolating));
        } else {
            cells.push(format!("skipped: {}", self.left_out));
        }
        cells
    }
}

/// How the default plan was brought within the range that the twin was calibrated on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Scaled {
    /// Its size over that of the built-in plan [-].
    pub scale: f64,
    /// The range.
    pub range: CalibratedRange,
}

/// The outcome of `generate`: the card of a data set.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the robot.
    pub robot: String,
    /// Hash of the scene and its mesh.
    pub scene_sha256: String,
    /// Name of the plan.
    pub plan: String,
    /// How it was brought within the calibrated range, if it is the default plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scaled: Option<Scaled>,
    /// Trajectories in the set.
    pub made: usize,
    /// Skipped trajectories.
    pub dropped: usize,
    /// Samples of all.
    pub samples: usize,
    /// Samples of the recordings of the robot.
    pub samples_real: usize,
    /// Area that the tip goes over, and the robot's [m²]; convex hulls.
    pub areas_m2: [f64; 2],
    /// Part of the samples outside what the robot's tip went over [-].
    pub outside: f64,
    /// Part of the samples in which the network left its training range [-].
    pub extrapolating: f64,
    /// Part of the samples in which a chain was bent further than it was validated [-].
    #[serde(default)]
    pub outside_validation: f64,
    /// Samples by family.
    pub families: BTreeMap<String, usize>,
    /// One of each trajectory.
    pub rows: Vec<SyntheticTrajectory>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    /// Of the trajectories of a plan, with recordings of the robot to compare with.
    pub fn new(
        scene: &Scene,
        (plan, scaled): (&str, Option<Scaled>),
        rows: Vec<SyntheticTrajectory>,
        real: &[Input],
        context: &Context,
    ) -> Self {
        let samples = rows.iter().map(|row| row.samples).sum::<usize>();
        let all = || rows.iter().flat_map(|row| row.tip.iter().copied());
        let of_real: Vec<[f64; 2]> =
            real.iter().filter_map(|input| tip_of(&input.recording).ok()).flatten().collect();
        let samples_real = of_real.len();
        let flat = |[x, y]: [f64; 2]| [x, y, 0.0];
        let workspace = |tips: Vec<TipPosition>| TipWorkspace::new(Axes::Planar, tips);
        let own = workspace(all().map(flat).collect());
        let robots = workspace(of_real.into_iter().map(flat).collect());
        let outside = all().filter(|tip| robots.is_outside(flat(*tip), 0.0)).count();
        let flagged = |of: fn(&SyntheticTrajectory) -> f64| -> f64 {
            rows.iter().map(|row| of(row) * row.samples as f64).sum()
        };
        let extrapolating = flagged(|row| row.extrapolating);
        let outside_validation = flagged(|row| row.outside_validation);
        let mut families = BTreeMap::new();
        for row in &rows {
            *families.entry(row.family.clone()).or_insert(0) += row.samples;
        }
        let dropped = rows.iter().filter(|row| !row.left_out.is_empty()).count();
        let part = |count: f64| count / samples.max(1) as f64;
        Self {
            format: MetricsFormat,
            version: 1,
            robot: scene.name.clone(),
            scene_sha256: scene.hash.clone(),
            plan: plan.to_owned(),
            scaled,
            made: rows.len() - dropped,
            dropped,
            samples,
            samples_real,
            areas_m2: [own.area(), robots.area()],
            outside: part(outside as f64),
            extrapolating: part(extrapolating),
            outside_validation: part(outside_validation),
            families,
            rows,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }

    /// Why there is no trajectory in the set, if there is none.
    pub fn why_empty(&self) -> Option<String> {
        let first = self.rows.first().filter(|_| self.made == 0)?;
        Some(format!(
            "the twin can do none of the {} trajectories; {}: {} (hint: smaller amplitudes)",
            self.rows.len(),
            first.name,
            first.left_out
        ))
    }

    /// Prints the data set and its quality.
    pub fn print(&self, context: &Context) {
        if self.extrapolating > GUESSED {
            tracing::warn!(
                "in {:.0} % of the samples the network is outside its training range, and guesses (hint: smaller amplitudes, or \
                 a calibration from recordings that go as far)",
                100.0 * self.extrapolating
            );
        }
        if self.outside_validation > 0.0 {
            tracing::warn!(
                "in {:.1} % of the samples the chain is bent further than it was validated (hint: hysteron reduce --stroke-mm)",
                100.0 * self.outside_validation
            );
        }
        context.print(format_args!(
            "{} trajectories, {} samples; {} skipped; network outside its training range in {:.1} % of the samples",
            self.made,
            self.samples,
            self.dropped,
            100.0 * self.extrapolating
        ));
        if self.samples_real > 0 {
            context.print(format_args!(
                "tip over {:.1} cm², that of the robot over {:.1} cm²; {:.1} % of the samples are outside of it",
                1e4 * self.areas_m2[0],
                1e4 * self.areas_m2[1],
                100.0 * self.outside
            ));
        }
    }
}

/// x and y of the tip [m].
pub fn tip_of(recording: &Recording) -> Result<Vec<[f64; 2]>, BadInput> {
    let (x, y) = (recording.require("tip_x_m")?, recording.require("tip_y_m")?);
    Ok(x.iter().zip(y).map(|(x, y)| [*x, *y]).collect())
}
