//! The section of a robot's file with the spread of its population, exactly as typed; and its bounds.

use super::bounds::{Check, not_negative, require};
use super::population::{Population, PopulationSpread, Ranges};
use hysteron_base::BadInput;
use hysteron_base::schema::FixedArray;
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpreadFile {
    stiffness_relative: f64,
    anisotropy_relative: f64,
    principal_axes_deg: f64,
    natural_curvature_1_m: f64,
    creep_relative: f64,
    friction_relative: f64,
    tendon_stiffness_relative: f64,
    slack_mm: f64,
    play_relative: f64,
    servo_friction_relative: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RangesFile {
    stiffness_factor: FixedArray<f64, 2>,
    bending_ratio: FixedArray<f64, 2>,
    section_factor: FixedArray<f64, 2>,
    natural_curvature_1_m: FixedArray<f64, 2>,
    creep_factor: FixedArray<f64, 2>,
    guide_offset_mm: FixedArray<f64, 2>,
    guide_angle_deg: FixedArray<f64, 2>,
    tendon_stiffness_factor: FixedArray<f64, 2>,
    friction_factor: FixedArray<f64, 2>,
    presliding_mm: FixedArray<f64, 2>,
    play_mm: FixedArray<f64, 2>,
    zero_error_mm: FixedArray<f64, 2>,
    slack_tendon_mm: FixedArray<f64, 2>,
    pulley_factor: FixedArray<f64, 2>,
    servo_friction_factor: FixedArray<f64, 2>,
    tracker_position_mm: FixedArray<f64, 2>,
}

/// One of the two.
pub(super) fn population(spread: Option<SpreadFile>, ranges: Option<RangesFile>) -> Check<Population> {
    match (spread, ranges) {
        (Some(typed), None) => Ok(Population::Around(self::spread(&typed)?)),
        (None, Some(typed)) => Ok(Population::Wide(self::ranges(&typed)?)),
        (spread, _) => {
            let found = if spread.is_some() { "both" } else { "neither" };
            Err(BadInput::new("spread", "[spread] or [ranges]", found))
        }
    }
}

fn spread(typed: &SpreadFile) -> Check<PopulationSpread> {
    let deviation = |key: &str, x: f64| not_negative(&format!("spread.{key}"), x);
    Ok(PopulationSpread {
        stiffness: deviation("stiffness_relative", typed.stiffness_relative)?,
        anisotropy: deviation("anisotropy_relative", typed.anisotropy_relative)?,
        axes_angle: deviation("principal_axes_deg", typed.principal_axes_deg)?,
        natural_curvature: deviation("natural_curvature_1_m", typed.natural_curvature_1_m)?,
        creep: deviation("creep_relative", typed.creep_relative)?,
        friction: deviation("friction_relative", typed.friction_relative)?,
        tendon_stiffness: deviation("tendon_stiffness_relative", typed.tendon_stiffness_relative)?,
        slack: deviation("slack_mm", typed.slack_mm)?,
        play: deviation("play_relative", typed.play_relative)?,
        servo_friction: deviation("servo_friction_relative", typed.servo_friction_relative)?,
    })
}

fn ranges(typed: &RangesFile) -> Check<Ranges> {
    let any = |key: &str, ends: FixedArray<f64, 2>| range(key, ends, "smallest <= largest", |_| true);
    let positive =
        |key: &str, ends: FixedArray<f64, 2>| range(key, ends, "0 < smallest <= largest", |x| x > 0.0);
    let not_negative =
        |key: &str, ends: FixedArray<f64, 2>| range(key, ends, "0 <= smallest <= largest", |x| x >= 0.0);
    Ok(Ranges {
        stiffness: positive("stiffness_factor", typed.stiffness_factor)?,
        bending_ratio: positive("bending_ratio", typed.bending_ratio)?,
        section: positive("section_factor", typed.section_factor)?,
        natural_curvature: any("natural_curvature_1_m", typed.natural_curvature_1_m)?,
        creep: positive("creep_factor", typed.creep_factor)?,
        guide_offset: any("guide_offset_mm", typed.guide_offset_mm)?,
        guide_angle: any("guide_angle_deg", typed.guide_angle_deg)?,
        tendon_stiffness: positive("tendon_stiffness_factor", typed.tendon_stiffness_factor)?,
        friction: positive("friction_factor", typed.friction_factor)?,
        presliding: positive("presliding_mm", typed.presliding_mm)?,
        play: not_negative("play_mm", typed.play_mm)?,
        zero_error: any("zero_error_mm", typed.zero_error_mm)?,
        slack_tendon: not_negative("slack_tendon_mm", typed.slack_tendon_mm)?,
        pulley: positive("pulley_factor", typed.pulley_factor)?,
        servo_friction: positive("servo_friction_factor", typed.servo_friction_factor)?,
        tracker_position: any("tracker_position_mm", typed.tracker_position_mm)?,
    })
}

/// Two ends in order, in SI, each of which `holds`.
fn range(
    key: &str,
    FixedArray([min, max]): FixedArray<f64, 2>,
    expected: &str,
    holds: fn(f64) -> bool,
) -> Check<[f64; 2]> {
    let place = format!("ranges.{key}");
    let end = |x: f64| require(&place, expected, x, x.is_finite() && holds(x) && min <= max);
    Ok([end(min)?, end(max)?])
}
