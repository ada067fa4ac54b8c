//! The one conversion from what was typed to what is valid, and every bound of a plan.

use super::draw::{check_draw, one};
use super::schema::FamilyName as Typed;
use super::{
    CurveMotion, Direction, Envelope, Family, MotionPlan, Space, StrokeLimits, TendonMapping, Trajectory,
    TrajectoryRole, schema,
};
use hysteron_base::schema::{between, check_header, finite, not_negative, positive, require, text};
use hysteron_base::size::{check_at_most, check_memory};
use hysteron_base::{BadInput, Bounds, rng};
use rand::RngExt;
use std::borrow::Cow;
use std::collections::HashSet;
use std::f64::consts::FRAC_PI_2;

type Check<T> = std::result::Result<T, BadInput>;

const FORMAT: (&str, i64) = ("hysteron-plan", 1);
/// More than any plan has; keeps a slip of the hand from filling the memory, or the year.
const MAX_SAMPLES: f64 = 1e7;
const MAX_STROKES: f64 = 4e7;
const MAX_TRAJECTORIES: usize = 10_000;
const MAX_TENDONS: usize = 100;
/// Most trajectories of one draw, more than a person means.
const MAX_COUNT: i64 = 10_000;
/// Longest stroke [mm] and fastest change [mm/s], in either direction.
const LONGEST: f64 = 1e5;
/// Rates at which a robot is commanded [Hz].
const RATES: [f64; 2] = [1e-2, 1e5];

/// The values that all trajectories of a plan have in common.
#[derive(Debug, Clone)]
pub(super) struct PlanHead {
    pub name: String,
    pub seed: u64,
    pub hash: String,
    pub limits: StrokeLimits,
    pub space: Space,
    scale: f64,
    vary: f64,
    rest_before: f64,
    rest_after: f64,
    rate_hz: f64,
    pub tendons: TendonMapping,
}

pub(super) fn head(typed: &schema::PlanFile, hash: String) -> Check<PlanHead> {
    check_header((&typed.format, typed.version), FORMAT)?;
    let name = text("name", typed.name.clone())?;
    let rate_hz = between("rate_hz", typed.rate_hz, RATES)?;
    let scale = positive("scale", typed.scale.unwrap_or(1.0))?;
    let vary = typed.vary.unwrap_or(0.0);
    let vary = require("vary", "0 <= vary < 1", vary, (0.0..1.0).contains(&vary))?;
    let rest_before = not_negative("rest_before_s", typed.rest_before_s)?;
    let rest_after = not_negative("rest_after_s", typed.rest_after_s)?;
    let tendons = TendonMapping {
        angles: angles(&typed.tendon_angles_deg)?,
        release: not_negative("release", typed.release)?,
        co_contraction: not_negative("co_contraction_mm", typed.co_contraction_mm.unwrap_or(0.0))?,
    };
    if typed.space == Space::Tip && tendons.co_contraction > 0.0 {
        let found = format!("{:?}", 1e3 * tendons.co_contraction);
        return Err(BadInput::new("co_contraction_mm", "none with space = \"tip\"", found)
            .hint("the strokes are found by a twin, which pulls no more than it needs"));
    }
    for (key, rest) in [("rest_before_s", rest_before), ("rest_after_s", rest_after)] {
        if tendons.co_contraction > 0.0 && rest == 0.0 {
            return Err(BadInput::new(key, "a time > 0 with co_contraction_mm", "0.0").hint(
                "all tendons are pulled in the rest before the motion, and released in the one after",
            ));
        }
    }
    let stroke_max = between("stroke_max_mm", typed.stroke_max_mm, [1e-6, LONGEST])?;
    let limits = StrokeLimits {
        stroke: Bounds { min: -stroke_max, max: stroke_max },
        stroke_rate: between("stroke_rate_max_mm_s", typed.stroke_rate_max_mm_s, [1e-6, LONGEST])?,
    };
    let (seed, space) = (typed.seed, typed.space);
    Ok(PlanHead { name, seed, hash, limits, space, scale, vary, rest_before, rest_after, rate_hz, tendons })
}

pub(super) fn plan(typed: &schema::PlanFile, hash: String) -> Check<MotionPlan> {
    let head = head(typed, hash)?;
    let mut all: Vec<Cow<schema::TrajectoryTable>> = typed.trajectory.iter().map(Cow::Borrowed).collect();
    for (i, draw) in typed.draw.iter().enumerate() {
        check_trajectories(all.len().saturating_add(usize::try_from(draw.count).unwrap_or(0)))?;
        let n = check_draw(i, draw, MAX_COUNT)?;
        all.extend((0..n).map(|k| Cow::Owned(one(draw, head.seed, k, n))));
    }
    check_trajectories(all.len())?;
    check_not_empty(all.len())?;
    let mut trajectories: Vec<Trajectory> = Vec::new();
    let mut names = HashSet::new();
    for (i, typed_one) in all.into_iter().enumerate() {
        let key = format!("trajectory[{}].name", i + 1);
        let own = file_name(&key, &typed_one.name)?;
        if !names.insert(own) {
            return Err(BadInput::new(key, "a unique name", format!("\"{}\" again", typed_one.name)));
        }
        trajectories.push(trajectory(&head, &typed_one)?);
    }
    check_size(&trajectories, head.tendons.angles.len())?;
    check_roles(&trajectories)?;
    let PlanHead { name, seed, hash, limits, .. } = head;
    Ok(MotionPlan { name, seed, hash, limits, trajectories })
}

/// A trajectory of a plan, valid and in SI; its name was accepted.
pub(super) fn trajectory(head: &PlanHead, typed: &schema::TrajectoryTable) -> Check<Trajectory> {
    let mut motion = motion(&typed.name, typed, head.scale)?;
    vary_by(head.vary, &mut motion, head.seed, &typed.name);
    let trajectory = Trajectory {
        name: typed.name.clone(),
        role: typed.role,
        space: head.space,
        motion,
        rest_before: head.rest_before,
        rest_after: head.rest_after,
        rate_hz: head.rate_hz,
        tendons: head.tendons.clone(),
        plan_name: head.name.clone(),
        plan_hash: head.hash.clone(),
        seed: head.seed,
    };
    check_sampling(&trajectory)?;
    Ok(trajectory)
}

/// Accepts a plan with a trajectory.
pub(super) fn check_not_empty(n: usize) -> Check<()> {
    match n {
        0 => Err(BadInput::new("trajectory", "at least one [[trajectory]] or [[draw]]", "none")),
        _ => Ok(()),
    }
}

fn angles(typed: &[f64]) -> Check<Vec<f64>> {
    const KEY: &str = "tendon_angles_deg";
    if !(2..=MAX_TENDONS).contains(&typed.len()) {
        return Err(BadInput::new(
            KEY,
            format!("2 to {MAX_TENDONS} angles"),
            format!("{} of them", typed.len()),
        ));
    }
    typed.iter().enumerate().map(|(i, angle)| finite(&format!("{KEY}[{i}]"), *angle)).collect()
}

/// A name that can be one of a file on any system.
pub(super) fn file_name(key: &str, typed: &str) -> Check<String> {
    let is_one = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if typed.is_empty() || typed.len() > 100 || !typed.chars().all(is_one) {
        return Err(BadInput::new(key, "a name of letters, digits, - and _", format!("{typed:?}")));
    }
    Ok(typed.to_owned())
}

fn motion(name: &str, typed: &schema::TrajectoryTable, scale: f64) -> Check<CurveMotion> {
    let key = |key: &str| format!("trajectory.{name}.{key}");
    let is_circle = typed.family == Typed::Circle;
    let orientation = match (typed.orientation_deg, is_circle) {
        (Some(angle), false) => finite(&key("orientation_deg"), angle)?,
        (None, true) => 0.0,
        (None, false) => return Err(BadInput::new(key("orientation_deg"), "this key", "nothing")),
        (Some(angle), true) => {
            let bad = BadInput::new(key("orientation_deg"), "no such key for a circle", format!("{angle:?}"));
            return Err(bad.hint("phase_deg is where it begins"));
        }
    };
    let family = family(&key, typed)?;
    if let (Typed::Sinusoid, Some(direction)) = (typed.family, typed.direction) {
        let found = match direction {
            Direction::CounterClockwise => "counter_clockwise",
            Direction::Clockwise => "clockwise",
        };
        return Err(BadInput::new(key("direction"), "no such key for a sinusoid", found)
            .hint("phase_deg = 180 begins the other way"));
    }
    let frequency = match (typed.frequency_hz, typed.period_s) {
        (Some(frequency), None) => positive(&key("frequency_hz"), frequency)?,
        (None, Some(period)) => {
            let frequency = positive(&key("period_s"), period)?.recip();
            require(&key("period_s"), "a period that has a frequency", period, frequency.is_finite())?;
            frequency
        }
        (given, _) => {
            let found = if given.is_some() { "both" } else { "neither" };
            return Err(BadInput::new(key("frequency_hz"), "either frequency_hz or period_s", found));
        }
    };
    let amplitude = positive(&key("amplitude_mm"), typed.amplitude_mm)?;
    let scaled = amplitude * scale;
    require(&key("amplitude_mm"), "a size that can be scaled", typed.amplitude_mm, scaled.is_normal())?;
    Ok(CurveMotion {
        family,
        amplitude: scaled,
        frequency,
        phase: finite(&key("phase_deg"), typed.phase_deg.unwrap_or(0.0))?,
        orientation,
        direction: typed.direction.unwrap_or(Direction::CounterClockwise),
        envelope: Envelope {
            attack: positive(&key("attack_s"), typed.attack_s)?,
            sustain: not_negative(&key("sustain_s"), typed.sustain_s)?,
            decay: positive(&key("decay_s"), typed.decay_s)?,
        },
    })
}

/// The family with its own number, of which no other family has one.
fn family(key: &dyn Fn(&str) -> String, typed: &schema::TrajectoryTable) -> Check<Family> {
    let own = [
        (
            "aspect",
            typed.aspect,
            Typed::Ellipse,
            "an ellipse",
            "the short axis of the ellipse over its long one",
        ),
        ("swings", typed.swings, Typed::Rose, "a rose", "how often its distance swings in a turn"),
    ];
    for (name, number, of, whose, meaning) in own {
        match number {
            None if typed.family == of => {
                return Err(BadInput::new(key(name), "this key", "nothing").hint(meaning));
            }
            Some(number) if typed.family != of => {
                let expected = format!("no such key but for {whose}");
                return Err(BadInput::new(key(name), expected, format!("{number:?}")));
            }
            _ => {}
        }
    }
    let number = |name: &str, number: Option<f64>| positive(&key(name), number.unwrap_or_default());
    Ok(match typed.family {
        Typed::Sinusoid => Family::Sinusoid,
        Typed::Circle => Family::Circle,
        Typed::Square => Family::Square,
        Typed::Ellipse => {
            let aspect = number("aspect", typed.aspect)?;
            Family::Ellipse { aspect: require(&key("aspect"), "0 < aspect <= 1", aspect, aspect <= 1.0)? }
        }
        Typed::Rose => Family::Rose { swings: number("swings", typed.swings)? },
    })
}

/// Changes amplitude and frequency by up to this part of themselves, and orientation by up to this part of a
/// quarter turn. Each trajectory has a stream of its own, so another one in the plan changes nothing.
fn vary_by(part: f64, motion: &mut CurveMotion, seed: u64, name: &str) {
    if part == 0.0 {
        return;
    }
    let mut stream = rng(seed, &format!("plan/vary/{name}"));
    let mut change = || part * stream.random_range(-1.0..1.0);
    motion.amplitude *= 1.0 + change();
    motion.frequency *= 1.0 + change();
    motion.orientation += FRAC_PI_2 * change();
}

fn check_trajectories(n: usize) -> Check<()> {
    check_at_most("trajectories", n, MAX_TRAJECTORIES)
}

/// The strokes of all trajectories fit into the memory.
fn check_size(trajectories: &[Trajectory], n_tendons: usize) -> Check<()> {
    let n = trajectories.iter().map(|one| one.duration() * one.rate_hz + 1.0).sum::<f64>();
    for (what, n, most) in [("samples", n, MAX_SAMPLES), ("strokes", n * n_tendons as f64, MAX_STROKES)] {
        if n > most {
            let expected = format!("at most {most:e} {what} in all");
            return Err(
                BadInput::new("trajectories", expected, format!("{n:.3e}")).hint("times are in seconds")
            );
        }
    }
    // As columns of a recording, and in the file that is made of them.
    check_memory("trajectories", 16.0 * n * (n_tendons + 1) as f64, "a shorter plan, or a lower rate_hz")
}

/// The rate shows the motion, and the samples fit into the memory.
fn check_sampling(trajectory: &Trajectory) -> Check<()> {
    let Trajectory { name, motion, rate_hz, .. } = trajectory;
    if motion.frequency >= 0.5 * rate_hz {
        let place = format!("trajectory.{name}.frequency_hz");
        let expected = format!("below half of rate_hz = {rate_hz:?}");
        return Err(BadInput::new(place, expected, format!("{:?}", motion.frequency)));
    }
    if let Family::Rose { swings } = motion.family
        && motion.frequency * swings >= 0.5 * rate_hz
    {
        let place = format!("trajectory.{name}.swings");
        let most = 0.5 * rate_hz / motion.frequency;
        let expected = format!("below {most:.1}, so that a sample shows less than half of a swing");
        return Err(BadInput::new(place, expected, format!("{swings:?}")));
    }
    let n = trajectory.duration() * rate_hz;
    if n.is_nan() || n >= MAX_SAMPLES {
        let (place, expected) = (format!("trajectory.{name}"), format!("fewer than {MAX_SAMPLES:e} samples"));
        return Err(BadInput::new(place, expected, format!("{n:e}")).hint("times are in seconds"));
    }
    Ok(())
}

/// Validation stays within the amplitudes of the training, and what is called out of range is beyond them.
fn check_roles(trajectories: &[Trajectory]) -> Check<()> {
    let training = trajectories.iter().filter(|trajectory| trajectory.role == TrajectoryRole::Training);
    let Some(largest) = training.map(|trajectory| trajectory.motion.amplitude).reduce(f64::max) else {
        return Ok(()); // a plan of checks alone: what they are checked against is elsewhere
    };
    trajectories.iter().try_for_each(|trajectory| check_role(trajectory, largest))
}

/// The same of one trajectory, where the largest amplitude of the training is this [m].
pub(super) fn check_role(Trajectory { name, role, motion, .. }: &Trajectory, largest: f64) -> Check<()> {
    let (is_right, expected) = match role {
        TrajectoryRole::Training => (true, ""),
        TrajectoryRole::Validation => (motion.amplitude <= largest, "at most"),
        TrajectoryRole::OutOfRange => (motion.amplitude > largest, "above"),
    };
    if is_right {
        return Ok(());
    }
    let place = format!("trajectory.{name}.amplitude_mm");
    let expected = format!("{expected} {:.4}, the largest of the training", 1e3 * largest);
    Err(BadInput::new(place, expected, format!("{:.4}", 1e3 * motion.amplitude))
        .hint(format!("change it, or its role {}; scale and vary count", role.name())))
}
