//! A recording made ready for the twin: commands in the order of its tendons, the measured tip, and whether both can be
//! of this robot; checked before anything is computed from it.

use hysteron_base::{BadInput, PrescribedQuantity, Recording};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::model::{Target, Twin, TwinTendon};
use crate::stepper::Stepper;
use crate::{Error, Result};

type Check<T> = std::result::Result<T, BadInput>;

/// Fewest samples worth identifying.
const MIN_SAMPLES: usize = 100;
/// Largest share of samples that may have been filled in there.
const MAX_GAPS: f64 = 0.2;
/// How far from its rest a tip may seem to be, over the robot's length: it can turn over, and a tracker may be
/// apart a little [-].
const FARTHEST: f64 = 2.5;
/// Distance of the resting tip from the twin's, over the robot's length, that speaks of a moved tracker [-].
const REGISTERED: f64 = 0.1;
/// Commands below this part of their largest count as none [-].
const AT_REST: f64 = 0.05;

/// Commands and measured motion of a robot, in the frame of its twin.
#[derive(Debug, Clone)]
pub struct RobotMotion {
    /// Name in messages.
    pub name: String,
    /// Duration of a sample, the mean where it varies [s].
    pub step: f64,
    /// Time (n_samples) [s].
    pub time: Vec<f64>,
    /// Strokes of the primary tendons (n_samples × n_primary, row-major), zero for one that is not driven so [m].
    pub strokes: Vec<f64>,
    /// Tensions of the primary tendons (n_samples × n_primary, row-major), zero for one that is not driven so [N].
    pub tensions: Vec<f64>,
    /// Tip (n_samples) [m].
    pub tips: Vec<[f64; 3]>,
    /// Rotation of the tip since rest (n_samples), where recorded; however the sensor is mounted.
    pub orientations: Option<Vec<UnitQuaternion<f64>>>,
    /// True where the tip was not measured but filled in (n_samples).
    pub gap: Vec<bool>,
    /// Coordinates of the tip that vary; a constant one measures nothing.
    pub axes: [bool; 3],
    /// Measured tensions of the primary tendons (n_samples × n_primary, row-major), where all of them were recorded
    /// [N].
    measured_tensions: Option<Vec<f64>>,
    /// Drive of each primary tendon.
    drives: Vec<PrescribedQuantity>,
}

impl RobotMotion {
    /// Takes commands and tip out of `recording`, called `name` in messages. Recorded strokes of auxiliary
    /// tendons are not read: they belong to the twin that they were found with.
    ///
    /// # Errors
    /// Commands of another robot, too large for it, or that never change; no tip; a tip farther off than the robot
    /// reaches, as of other units, or one that never moves.
    pub fn new(twin: &Twin, recording: &Recording, name: &str) -> Result<Self> {
        Ok(Self::checked(twin, recording, name).map_err(|bad| bad.within(name))?)
    }

    /// As [`Self::new`], of a recording that is to be identified sample by sample.
    ///
    /// # Errors
    /// Also tendons that are not driven by strokes; too few samples, or too many filled in; no fixed rate; a
    /// coordinate of the tip that never changes; a tip at rest away from the twin's.
    pub fn for_identification(twin: &Twin, recording: &Recording, name: &str) -> Result<Self> {
        let motion = Self::identifiable(twin, recording, name)?;
        motion.check_registration(twin)?;
        Ok(motion)
    }

    /// As [`Self::for_identification`], without a step of the twin: where the tip rests is left to
    /// [`Self::check_registration`].
    ///
    /// # Errors
    /// As [`Self::for_identification`], but for the place of the tip at rest.
    pub fn identifiable(twin: &Twin, recording: &Recording, name: &str) -> Result<Self> {
        let motion = Self::new(twin, recording, name)?;
        motion.check_identifiable(recording).map_err(|bad| bad.within(name))?;
        Ok(motion)
    }

    fn checked(twin: &Twin, recording: &Recording, name: &str) -> Check<Self> {
        let primary = &twin.tendons[..twin.n_primary];
        let tips: Vec<[f64; 3]> = {
            let [x, y, z] = ["tip_x_m", "tip_y_m", "tip_z_m"].map(|name| recording.require(name));
            let (x, y, z) = (x?, y?, z?);
            (0..recording.n_samples()).map(|i| [x[i], y[i], z[i]]).collect()
        };
        let gap = recording.gap().to_vec();
        let measured = || tips.iter().zip(&gap).filter(|(_, gap)| !**gap).map(|(tip, _)| *tip);
        let time = recording.time().to_vec();
        let motion = Self {
            name: name.to_owned(),
            step: (time[time.len() - 1] - time[0]) / (time.len().max(2) - 1) as f64,
            strokes: strokes(primary, recording)?,
            tensions: tensions(primary, recording)?,
            measured_tensions: measured_tensions(primary, recording),
            orientations: orientations(twin, recording),
            axes: std::array::from_fn(|c| is_moving(measured().map(|tip| tip[c]))),
            drives: primary.iter().map(|tendon| tendon.drive).collect(),
            time,
            tips,
            gap,
        };
        motion.check_moves()?;
        motion.check_sizes(twin)?;
        Ok(motion)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.tips.len()
    }

    /// False: a motion has samples.
    pub fn is_empty(&self) -> bool {
        self.tips.is_empty()
    }

    /// Strokes of the primary tendons in a sample [m].
    pub fn strokes_at(&self, sample: usize) -> &[f64] {
        row(&self.strokes, sample, self.drives.len())
    }

    /// Measured tension of a primary tendon that is driven by its stroke, where it was recorded [N].
    pub fn measured_tension(&self, sample: usize, tendon: usize) -> Option<f64> {
        let is_measured = self.drives[tendon] == PrescribedQuantity::Stroke;
        self.measured_tensions
            .as_ref()
            .filter(|_| is_measured)
            .map(|rows| rows[sample * self.drives.len() + tendon])
    }

    /// Largest tension recorded, if any [N].
    pub fn largest_tension(&self) -> Option<f64> {
        let rows = self.measured_tensions.as_ref()?;
        rows.iter().copied().reduce(f64::max).filter(|largest| *largest > 0.0)
    }

    /// Targets of the primary tendons in a sample, each as the scene drives it.
    pub fn targets_at(&self, sample: usize) -> Vec<Target> {
        let tensions = row(&self.tensions, sample, self.drives.len());
        let commands = self.strokes_at(sample).iter().zip(tensions);
        let target = |(drive, (stroke, tension)): (&PrescribedQuantity, (&f64, &f64))| match drive {
            PrescribedQuantity::Stroke => Target::Stroke(*stroke),
            PrescribedQuantity::Tension => Target::Tension(*tension),
            PrescribedQuantity::Free => Target::Free,
        };
        self.drives.iter().zip(commands).map(target).collect()
    }

    /// True if a tendon is driven by tension.
    pub fn has_tensions(&self) -> bool {
        self.drives.contains(&PrescribedQuantity::Tension)
    }

    /// With nothing commanded, the measured tip must be where the twin's is.
    ///
    /// # Errors
    /// It is not; the twin has no equilibrium there.
    pub fn check_registration(&self, twin: &Twin) -> Result<()> {
        let rest = self.samples_at_rest();
        let Some(first) = rest.first() else { return Ok(()) };
        let mut targets = self.targets_at(*first);
        targets.resize(twin.tendons.len(), Target::Free);
        let mut stepper = Stepper::new(twin);
        stepper.step(twin, &targets)?;
        let twins = Vector3::from(twin.tip_of(stepper.state()));
        let measured =
            rest.iter().map(|&i| Vector3::from(self.tips[i])).sum::<Vector3<f64>>() / rest.len() as f64;
        let (away, allowed) = ((measured - twins).norm(), REGISTERED * length_of(twin));
        if away <= allowed {
            return Ok(());
        }
        let at = |p: Vector3<f64>| format!("({:.1}, {:.1}, {:.1}) mm", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z);
        Err(Error::from(
            BadInput::new(
                format!("{}: tip with nothing pulled", self.name),
                format!("within {:.1} mm of {}, where the twin's rests", 1e3 * allowed, at(twins)),
                format!("{}, {:.1} mm away", at(measured), 1e3 * away),
            )
            .hint("was the tracker moved? register it again, or use fit-material --frame fit"),
        ))
    }

    /// Samples that were measured while nothing was commanded, nearly.
    fn samples_at_rest(&self) -> Vec<usize> {
        let n = self.drives.len();
        let are_small = |values: &[f64], i: usize| {
            let largest = values.iter().fold(0.0f64, |max, value| max.max(value.abs()));
            row(values, i, n).iter().all(|value| value.abs() <= AT_REST * largest)
        };
        let is_rest =
            |&i: &usize| !self.gap[i] && are_small(&self.strokes, i) && are_small(&self.tensions, i);
        (0..self.len()).filter(is_rest).collect()
    }

    /// A channel that never changes was not measured, or not moved.
    fn check_moves(&self) -> Check<()> {
        if self.axes == [false; 3] {
            let is_empty = self.gap.iter().all(|gap| *gap);
            let found = if is_empty { "only rows that were filled in" } else { "one that never moves" };
            return Err(
                BadInput::new("tip", "a measured one that moves", found).hint("was the tracker running?")
            );
        }
        let n = self.drives.len();
        let is_constant = |values: &[f64]| values.chunks(n).all(|other| *other == values[..n]);
        if is_constant(&self.strokes) && is_constant(&self.tensions) {
            let found = "the same values in every row";
            return Err(BadInput::new("commands", "strokes or tensions that change", found));
        }
        Ok(())
    }

    /// Numbers a thousand times too large or of a larger robot.
    fn check_sizes(&self, twin: &Twin) -> Check<()> {
        for i in 0..self.len() {
            for (j, stroke) in self.strokes_at(i).iter().enumerate() {
                let length = twin.cables.rest_lengths[j];
                if stroke.abs() >= length {
                    let expected = format!("less than the tendon's length, {:.1} mm", 1e3 * length);
                    let found = format!("{:.1} mm", 1e3 * stroke);
                    return Err(BadInput::new(format!("row {}: stroke_{}_m", i + 1, j + 1), expected, found)
                        .hint("is the unit of the column its ending, _mm or _m?"));
                }
                if self.drives[j] == PrescribedQuantity::Stroke {
                    twin.tendons[j].check_stroke(*stroke, || format!("row {}: stroke_{}_m", i + 1, j + 1))?;
                }
            }
        }
        let (rest, length) = (Vector3::from(twin.tip_of(&twin.rest())), length_of(twin));
        let is_far = |i: &usize| (Vector3::from(self.tips[*i]) - rest).norm() > FARTHEST * length;
        let Some(i) = (0..self.len()).filter(|&i| !self.gap[i]).find(is_far) else { return Ok(()) };
        let mm = self.tips[i].map(|c| 1e3 * c);
        Err(BadInput::new(
            format!("row {}: tip", i + 1),
            format!("within reach of a robot of {:.1} mm", 1e3 * length),
            format!("({:.1}, {:.1}, {:.1}) mm", mm[0], mm[1], mm[2]),
        )
        .hint("is the unit of the columns their ending, _mm or _m? are they in the frame of the scene?"))
    }

    fn check_identifiable(&self, recording: &Recording) -> Check<()> {
        if let Some(j) = self.drives.iter().position(|drive| *drive != PrescribedQuantity::Stroke) {
            let found = format!("tendon {}, which is not", j + 1);
            return Err(BadInput::new("drive", "tendons driven by strokes", found));
        }
        let n = self.len();
        if n < MIN_SAMPLES {
            return Err(BadInput::new("rows", format!("at least {MIN_SAMPLES}"), n.to_string()));
        }
        if recording.rate_hz().is_none() {
            let found = "time steps that differ by more than 1 %";
            return Err(BadInput::new("time_s", "a fixed rate", found)
                .hint("resample it, and set gap to 1 where a row was filled in"));
        }
        let n_gaps = self.gap.iter().filter(|gap| **gap).count();
        if n_gaps as f64 > MAX_GAPS * n as f64 {
            let expected = format!("at most {:.0} % of rows filled in", 100.0 * MAX_GAPS);
            return Err(BadInput::new("gap", expected, format!("{n_gaps} of {n}")));
        }
        match ["tip_x_m", "tip_y_m", "tip_z_m"].iter().zip(self.axes).find(|(_, is_used)| !is_used) {
            None => Ok(()),
            Some((name, _)) => {
                let found = "the same value in every row";
                Err(BadInput::new(*name, "a measured tip", found).hint("was the tracker running?"))
            }
        }
    }
}

fn row(values: &[f64], sample: usize, n: usize) -> &[f64] {
    &values[sample * n..(sample + 1) * n]
}

/// Recorded strokes, row by row; zero for tendons that are not driven by them.
fn strokes(primary: &[TwinTendon], recording: &Recording) -> Check<Vec<f64>> {
    let strokes = recording.strokes();
    let is_used = |tendon: &TwinTendon| tendon.drive == PrescribedQuantity::Stroke;
    if (primary.iter().any(is_used) || !strokes.is_empty()) && strokes.len() != primary.len() {
        let expected = format!("{}, one per tendon of the scene", primary.len());
        return Err(BadInput::new("stroke columns", expected, strokes.len().to_string())
            .hint("is this a recording of another robot?"));
    }
    let mut rows = vec![0.0; recording.n_samples() * primary.len()];
    for (k, values) in strokes.iter().enumerate().filter(|(k, _)| is_used(&primary[*k])) {
        values.iter().enumerate().for_each(|(i, value)| rows[i * primary.len() + k] = *value);
    }
    Ok(rows)
}

/// Recorded tensions, row by row; zero for tendons that are not driven by them.
fn tensions(primary: &[TwinTendon], recording: &Recording) -> Check<Vec<f64>> {
    let mut tensions = vec![0.0; recording.n_samples() * primary.len()];
    for (k, tendon) in
        primary.iter().enumerate().filter(|(_, tendon)| tendon.drive == PrescribedQuantity::Tension)
    {
        let name = format!("tension_{}_n", k + 1);
        for (i, value) in recording.require(&name)?.iter().enumerate() {
            if !tendon.tension.contains(*value) {
                return Err(BadInput::new(
                    format!("row {}: {name}", i + 1),
                    format!(
                        "{} to {} N, the bounds of {}",
                        tendon.tension.min, tendon.tension.max, tendon.name
                    ),
                    format!("{value} N"),
                ));
            }
            tensions[i * primary.len() + k] = *value;
        }
    }
    Ok(tensions)
}

/// Recorded tensions of all primary tendons, row by row; none where one is missing or is no number.
fn measured_tensions(primary: &[TwinTendon], recording: &Recording) -> Option<Vec<f64>> {
    let columns: Vec<&[f64]> =
        (1..=primary.len()).map(|k| recording.channel(&format!("tension_{k}_n"))).collect::<Option<_>>()?;
    let rows: Vec<f64> =
        (0..recording.n_samples()).flat_map(|i| columns.iter().map(move |column| column[i])).collect();
    rows.iter().all(|tension| tension.is_finite()).then_some(rows)
}

/// Rotations since the first sample, in which the robot is assumed to be straight: how the sensor sits in the tip
/// drops out.
fn orientations(twin: &Twin, recording: &Recording) -> Option<Vec<UnitQuaternion<f64>>> {
    let [w, x, y, z] = recording.tip_orientation()?;
    let turned = |i: usize| UnitQuaternion::from_quaternion(Quaternion::new(w[i], x[i], y[i], z[i]));
    let mount = turned(0).inverse() * twin.tip_rotation_of(&twin.rest());
    Some((0..recording.n_samples()).map(|i| turned(i) * mount).collect())
}

/// Distance of the tip from the farthest node at rest [m].
fn length_of(twin: &Twin) -> f64 {
    let tip = Vector3::from(twin.tip.at(&twin.body.rest));
    let distance = |&[x, y, z, _]: &[f64; 4]| (Vector3::new(x, y, z) - tip).norm();
    twin.body.rest.iter().map(distance).fold(0.0, f64::max)
}

fn is_moving(mut values: impl Iterator<Item = f64>) -> bool {
    let first = values.next();
    values.any(|value| Some(value) != first)
}
