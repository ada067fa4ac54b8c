//! The servos of a rig in its recordings: what each pulley has turned, its load and its tension.

use std::f64::consts::TAU;

use hysteron_actuator::{TICKS_PER_TURN, stroke_per_tick};
use hysteron_base::{BadInput, Recording};

use crate::shared::inputs::Input;

/// Motion of one servo in one recording, positive where it pulls.
pub(super) struct PulleyCourse {
    pub angle: Vec<f64>,
    pub load: Vec<f64>,
    pub tension: Option<Vec<f64>>,
}

/// One servo of a rig in all recordings.
pub(super) struct RecordedServo {
    /// Number, from 1.
    pub number: usize,
    /// Radius of its pulley, as strokes over ticks have it [m].
    pub radius: f64,
    pub courses: Vec<PulleyCourse>,
}

/// Recordings of one rate, within 1 %.
pub(super) fn common_period(files: &[Input]) -> anyhow::Result<f64> {
    let mut first = None;
    for input in files {
        let place = format!("{}: time_s", input.path.display());
        let rate = input.recording.rate_hz().ok_or_else(|| {
            BadInput::new(&place, "equal time steps, within 1 %", "unequal ones")
                .hint("resample the recording")
        })?;
        let expected: f64 = *first.get_or_insert(rate);
        if (rate / expected - 1.0).abs() > 0.01 {
            let expected = format!("{expected:.2} samples a second, as in {}", files[0].path.display());
            return Err(BadInput::new(place, expected, format!("{rate:.2}")).into());
        }
    }
    first.map(f64::recip).ok_or_else(|| BadInput::new("recordings", "one or more", "none").into())
}

/// The channels of one recording.
struct Channels<'a> {
    goals: Vec<&'a [f64]>,
    present: Vec<&'a [f64]>,
    loads: Vec<&'a [f64]>,
    strokes: Vec<&'a [f64]>,
    tensions: Option<Vec<&'a [f64]>>,
}

impl<'a> Channels<'a> {
    fn of(recording: &'a Recording) -> Result<Self, BadInput> {
        recording.require("tick_present_1")?;
        let n = recording.numbered("tick_present", "").len();
        let all = |stem: &str, unit: &str| -> Result<Vec<&'a [f64]>, BadInput> {
            let name =
                |k: usize| if unit.is_empty() { format!("{stem}_{k}") } else { format!("{stem}_{k}_{unit}") };
            (1..=n).map(|k| recording.require(&name(k))).collect()
        };
        let measured = |stem: &str| !recording.numbered(stem, "n").is_empty();
        let tensions = ["tension", "true_tension"].into_iter().find(|stem| measured(stem));
        Ok(Self {
            goals: all("tick_goal", "")?,
            present: all("tick_present", "")?,
            loads: all("load", "")?,
            strokes: all("stroke", "m")?,
            tensions: tensions.map(|stem| all(stem, "n")).transpose()?,
        })
    }
}

/// Servos of the rig, those of the numbers in `requested` or all; strokes and goals give the direction of each.
pub(super) fn servos(files: &[Input], requested: &[usize]) -> anyhow::Result<Vec<RecordedServo>> {
    let channels = files
        .iter()
        .map(|input| Channels::of(&input.recording).map_err(|bad| bad.within(input.path.display())))
        .collect::<Result<Vec<_>, _>>()?;
    let n = channels.first().map_or(0, |channels| channels.present.len());
    if let Some(k) = channels.iter().position(|channels| channels.present.len() != n) {
        let expected = format!("{n} servos, as in {}", files[0].path.display());
        let found = channels[k].present.len().to_string();
        return Err(BadInput::new(files[k].path.display().to_string(), expected, found).into());
    }
    if let Some(k) = requested.iter().find(|k| **k > n) {
        return Err(BadInput::new("--servos", format!("1 to {n}"), k.to_string()).into());
    }
    let numbers = (1..=n).filter(|k| requested.is_empty() || requested.contains(k));
    Ok(numbers.map(|number| servo(&channels, number)).collect::<Result<_, _>>()?)
}

fn servo(channels: &[Channels], number: usize) -> Result<RecordedServo, BadInput> {
    let k = number - 1;
    let per_tick: Vec<f64> = channels
        .iter()
        .filter_map(|channels| stroke_per_tick(channels.goals[k], channels.strokes[k]))
        .collect();
    let place = format!("tick_goal_{number}");
    if per_tick.is_empty() {
        return Err(BadInput::new(place, "goals that change", "a servo that rests throughout")
            .hint(format!("record motion of tendon {number}, or leave it out with --servos")));
    }
    let mean = per_tick.iter().sum::<f64>() / per_tick.len() as f64;
    if per_tick.iter().any(|slope| (slope / mean - 1.0).abs() > 0.05) {
        let found =
            per_tick.iter().map(|slope| format!("{:.3} µm", 1e6 * slope)).collect::<Vec<_>>().join(", ");
        return Err(BadInput::new(place, "the same stroke for a tick in all recordings", found)
            .hint("are all of them of one rig, with one calibration?"));
    }
    let sign = mean.signum();
    let course = |channels: &Channels| PulleyCourse {
        angle: channels.present[k].iter().map(|ticks| sign * ticks * TAU / TICKS_PER_TURN).collect(),
        load: channels.loads[k].iter().map(|load| sign * load).collect(),
        tension: channels.tensions.as_ref().map(|tensions| tensions[k].to_vec()),
    };
    let radius = mean.abs() * TICKS_PER_TURN / TAU;
    Ok(RecordedServo { number, radius, courses: channels.iter().map(course).collect() })
}
