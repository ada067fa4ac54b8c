//! Series of a recording as the checks read them: the measured rows, by kind of channel.

use super::LONGEST_STILL_S;
use crate::Recording;
use crate::statistics::nearest_quantile;
use crate::units::Unit;

/// Prefixes of channels that are commanded or computed, not measured.
const COMMANDS: [&str; 7] = ["stroke_", "aux_", "goal_", "target_", "twin_", "tick_goal_", "command_"];
/// Flags that a program writes for a row.
const FLAGS: [&str; 5] = ["extrapolating", "outside_validation", "limited", "contact", "feedback"];

/// True for commands and computed values, which are not measured.
pub fn is_command(name: &str) -> bool {
    FLAGS.contains(&name)
        || name.ends_with("labelled_ratio")
        || name.contains("_per_stroke_")
        || COMMANDS.iter().any(|begin| name.starts_with(begin))
}

/// Whether rows at these times [s] are closer than a robot's time constants.
pub fn resolves_motion(time: &[f64]) -> bool {
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    nearest_quantile(&mut steps, 0.5).unwrap_or(0.0) < LONGEST_STILL_S
}

/// A channel without the rows that were filled in.
pub struct MeasuredChannel {
    pub name: String,
    pub values: Vec<f64>,
}

impl MeasuredChannel {
    /// True for where something is: a length or an angle.
    pub fn is_position(&self) -> bool {
        let unit = Unit::of_name(&self.name).map(|(_, unit)| unit.si_suffix);
        matches!(unit, Some("m" | "rad")) || self.name.starts_with("tick_present_")
    }
}

/// The measured rows of a recording.
pub struct MeasuredSeries<'a> {
    pub recording: &'a Recording,
    /// Their numbers, from 0.
    pub rows: &'a [usize],
    /// Their times [s].
    pub time: Vec<f64>,
    /// `stroke_k_m`.
    pub strokes: Vec<MeasuredChannel>,
    /// `tip_x_m`, `tip_y_m`, `tip_z_m`, those that are there.
    pub tip: Vec<MeasuredChannel>,
    /// `tip_qw` … `tip_qz`, all or none.
    pub orientation: Vec<MeasuredChannel>,
    /// All other measured channels.
    pub others: Vec<MeasuredChannel>,
}

impl<'a> MeasuredSeries<'a> {
    pub fn of(recording: &'a Recording, rows: &'a [usize]) -> Self {
        let of = |name: &str, values: &[f64]| MeasuredChannel {
            name: name.to_owned(),
            values: rows.iter().map(|row| values[*row]).collect(),
        };
        let named = |names: &[&str]| -> Vec<MeasuredChannel> {
            names.iter().filter_map(|name| Some(of(name, recording.channel(name)?))).collect()
        };
        let strokes = recording.strokes();
        let strokes = strokes
            .iter()
            .enumerate()
            .map(|(k, values)| of(&format!("stroke_{}_m", k + 1), values))
            .collect();
        let orientation = named(&["tip_qw", "tip_qx", "tip_qy", "tip_qz"]);
        let tip = ["tip_x_m", "tip_y_m", "tip_z_m"];
        let is_other = |name: &str| !is_command(name) && !tip.contains(&name) && !name.starts_with("tip_q");
        let others = recording.channels().iter().filter(|channel| is_other(&channel.name));
        Self {
            recording,
            rows,
            time: rows.iter().map(|row| recording.time()[*row]).collect(),
            strokes,
            tip: named(&tip),
            orientation: if orientation.len() == 4 { orientation } else { Vec::new() },
            others: others.map(|channel| of(&channel.name, &channel.values)).collect(),
        }
    }

    /// False where rows are further apart than a robot's time constants, each a rest of its own: neighbours then have nothing in
    /// common.
    pub fn resolves_motion(&self) -> bool {
        resolves_motion(&self.time)
    }

    /// The tip's axes and everything else that is measured.
    pub fn measured(&self) -> impl Iterator<Item = &MeasuredChannel> {
        self.tip.iter().chain(&self.others)
    }
}
