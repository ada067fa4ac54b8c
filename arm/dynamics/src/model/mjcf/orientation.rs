//! The orientation attributes of MJCF.

use super::super::build::unit;
use super::super::xml::Check;
use super::attributes::Attributes;
use super::settings::Settings;
use crate::spatial::{Mat3, Pose, Vec3, cross, dot3};

/// `pos` and one of the orientation attributes.
///
/// # Errors
/// `BadInput` for numbers that are none, axes of length zero, and two ways at once.
pub(super) fn pose(at: &Attributes, settings: &Settings) -> Check<Pose<f64>> {
    let position = at.array("pos")?.unwrap_or_default();
    Ok(Pose { rotation: rotation(at, settings)?, position })
}

/// The middle of `fromto` [m], its axes with z along it, and its length [m]; `None` where the attribute is not there.
pub(super) fn segment(at: &Attributes) -> Check<Option<(Pose<f64>, f64)>> {
    let Some([a, b, c, d, e, f]) = at.array("fromto")? else { return Ok(None) };
    let along = [a - d, b - e, c - f];
    let axis = unit(along)
        .ok_or_else(|| at.element.error("fromto of two points that differ", "the same point twice"))?;
    let middle = [0.5 * (a + d), 0.5 * (b + e), 0.5 * (c + f)];
    Ok(Some((Pose { rotation: turned_to(axis), position: middle }, dot3(along, along).sqrt())))
}

fn rotation(at: &Attributes, settings: &Settings) -> Check<Mat3<f64>> {
    const WAYS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];
    let own: Vec<&str> = WAYS.into_iter().filter(|way| at.element.attribute(way).is_some()).collect();
    let way = match own[..] {
        [] => WAYS.into_iter().rev().find(|way| at.of_class(way).is_some()),
        [way] => Some(way),
        _ => return Err(at.element.error("one specification of the orientation", own.join(" and "))),
    };
    let Some(way) = way else { return Ok(Pose::IDENTITY.rotation) };
    let text = at.text(way).unwrap_or_default();
    let longer = || at.element.error(&format!("{way} of axes longer than zero"), format!("\"{text}\""));
    Ok(match way {
        "quat" => of_quaternion(at.parse_array(way, text)?).ok_or_else(longer)?,
        "axisangle" => {
            let [x, y, z, angle] = at.parse_array(way, text)?;
            about(unit([x, y, z]).ok_or_else(longer)?, angle * settings.angle)
        }
        "euler" => euler(at.parse_array(way, text)?, settings),
        "xyaxes" => {
            let [a, b, c, d, e, f] = at.parse_array(way, text)?;
            let x = unit([a, b, c]).ok_or_else(longer)?;
            let z = unit(cross(x, [d, e, f])).ok_or_else(longer)?;
            let y = cross(z, x);
            [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
        }
        _ => turned_to(unit(at.parse_array(way, text)?).ok_or_else(longer)?),
    })
}

/// Rotation of a quaternion w, x, y, z of any length but zero.
pub(super) fn of_quaternion(q: [f64; 4]) -> Option<Mat3<f64>> {
    let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|c| c / length);
    (length > 1e-12).then(|| rotation_of(w, [x, y, z]))
}

/// The least rotation that turns z to the unit vector `axis`.
fn turned_to(axis: Vec3<f64>) -> Mat3<f64> {
    let across = cross([0.0, 0.0, 1.0], axis);
    let sin = dot3(across, across).sqrt();
    let about_axis = if sin < 1e-10 { [1.0, 0.0, 0.0] } else { across.map(|c| c / sin) };
    about(about_axis, sin.atan2(axis[2]))
}

/// Rotation by three angles about the axes of `eulerseq`.
pub(super) fn euler(angles: Vec3<f64>, settings: &Settings) -> Mat3<f64> {
    let mut turned = Pose::IDENTITY;
    for (axis, angle) in settings.sequence.iter().zip(angles) {
        let unit = match axis.to_ascii_lowercase() {
            'x' => [1.0, 0.0, 0.0],
            'y' => [0.0, 1.0, 0.0],
            _ => [0.0, 0.0, 1.0],
        };
        let step = Pose { rotation: about(unit, angle * settings.angle), position: [0.0; 3] };
        // Small letters turn with the frame, capitals about fixed axes.
        turned = if axis.is_ascii_lowercase() { turned.times(&step) } else { step.times(&turned) };
    }
    turned.rotation
}

/// Rotation of the unit quaternion w + x i + y j + z k.
fn rotation_of(w: f64, [x, y, z]: Vec3<f64>) -> Mat3<f64> {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Rotation by `angle` [rad] about a unit vector.
pub(super) fn about(axis: Vec3<f64>, angle: f64) -> Mat3<f64> {
    let (sin, cos) = (0.5 * angle).sin_cos();
    rotation_of(cos, axis.map(|x| sin * x))
}
