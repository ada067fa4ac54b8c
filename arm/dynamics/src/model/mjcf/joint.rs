//! A joint of MJCF: where it is, what limits and resists it.

use super::super::build::unit;
use super::super::description::{JointKind, JointLimits};
use super::super::xml::Check;
use super::attributes::Attributes;
use super::element::brief;
use super::settings::Settings;
use crate::spatial::{Pose, Vec3, mul3};

/// A joint with its pivot [m] and axis in the body that it moves.
pub(super) struct Hinge {
    pub kind: JointKind,
    pub pivot: Vec3<f64>,
    pub axis: Vec3<f64>,
    /// Coordinate of the joint in the configuration of the file [rad] or [m].
    pub reference: f64,
    pub drive: JointLimits,
    /// Time constant [s] and damping ratio that spring and damper are made to have.
    pub response: Option<[f64; 2]>,
    /// True where its actuator carries what gravity compensation asks of it.
    pub is_actuator_compensated: bool,
}

/// The joint of an element in `frame` of its body.
///
/// # Errors
/// `BadInput` for joints of several degrees of freedom and numbers that no joint has.
pub(super) fn hinge(at: &Attributes, settings: &Settings, frame: &Pose<f64>) -> Check<Hinge> {
    let kind = match at.text("type") {
        None | Some("hinge") => JointKind::Revolute,
        Some("slide") => JointKind::Prismatic,
        Some("ball") => {
            return Err(at
                .element
                .error("type hinge or slide", "\"ball\"")
                .hint("write three hinges at the same place in its body, each about one axis"));
        }
        Some(other) => {
            return Err(at.element.error("type hinge or slide", format!("\"{}\"", brief(other))));
        }
    };
    let scale = if kind == JointKind::Revolute { settings.angle } else { 1.0 };
    let axis: Vec3<f64> = at.array("axis")?.unwrap_or([0.0, 0.0, 1.0]);
    let axis = unit(axis).ok_or_else(|| at.element.error("an axis longer than zero", format!("{axis:?}")))?;
    let pivot = Pose { rotation: Pose::IDENTITY.rotation, position: at.array("pos")?.unwrap_or_default() };
    let coordinate = |name| Ok(at.number(name)?.unwrap_or(0.0) * scale);
    let response = response(at)?;
    let force = is_limited(at, settings, "actuatorfrclimited", "actuatorfrcrange")?
        .map(|[low, high]| high.abs().min(low.abs()));
    let range = is_limited(at, settings, "limited", "range")?.map(|range| range.map(|end| end * scale));
    let [stiffness, damping, dry] =
        [at.not_negative("stiffness")?, at.not_negative("damping")?, at.not_negative("frictionloss")?];
    let drive = JointLimits {
        range: range.filter(|_| settings.limits),
        speed_limit: None,
        effort_limit: force,
        armature: at.not_negative("armature")?,
        damping: if settings.dampers { damping } else { 0.0 },
        dry_friction: if settings.dry_friction { dry } else { 0.0 },
        stiffness: if settings.springs { stiffness } else { 0.0 },
        spring_reference: coordinate("springref")?,
    };
    Ok(Hinge {
        kind,
        pivot: frame.times(&pivot).position,
        axis: mul3(&frame.rotation, axis),
        reference: coordinate("ref")?,
        drive,
        response,
        is_actuator_compensated: at.is_true("actuatorgravcomp")?,
    })
}

/// The range of an attribute if it is a limit: by another attribute, or by default.
fn is_limited(at: &Attributes, settings: &Settings, limited: &str, range: &str) -> Check<Option<[f64; 2]>> {
    let choice = at.word(limited, &["auto", "false", "true"])?;
    let Some([low, high]) = at.array(range)? else { return Ok(None) };
    // A range of zeros is MuJoCo's own default.
    let is_auto = choice == 0 && settings.ranges_limit && [low, high] != [0.0; 2];
    match choice == 2 || is_auto {
        false => Ok(None),
        true if low > high => {
            Err(at.element.error(&format!("a {range} that ascends"), format!("{low} to {high}")))
        }
        true => Ok(Some([low, high])),
    }
}

fn response(at: &Attributes) -> Check<Option<[f64; 2]>> {
    match at.array("springdamper")? {
        None | Some([0.0, 0.0]) => Ok(None),
        Some([time, ratio]) if time > 0.0 && ratio > 0.0 => Ok(Some([time, ratio])),
        Some(other) => Err(at.element.error("springdamper of two numbers > 0", format!("{other:?}"))),
    }
}
