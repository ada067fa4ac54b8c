//! The auxiliary tendons of CoReAct: short virtual cables along the body, generated from a layout.

use hysteron_base::{AuxiliaryLayout, Tendon};

/// Tendons of the layout, segment by segment: in each, `cables_per_segment` straight cables of two
/// points, evenly spaced around the axis, every further segment turned by `plane_step`.
///
/// # Reference
/// CoReAct paper, section V-A b: 18 segments of 4 mm, two cables each in alternating planes, radius 6.0 mm.
pub fn auxiliary_tendons(layout: &AuxiliaryLayout) -> Vec<Tendon> {
    let mut tendons = Vec::new();
    for segment in 0..layout.segments {
        let z = layout.start + segment as f64 * layout.segment_length;
        for cable in 0..layout.cables_per_segment {
            let around = std::f64::consts::TAU * cable as f64 / layout.cables_per_segment as f64;
            let angle = layout.first_plane + segment as f64 * layout.plane_step + around;
            let point = |z: f64| [layout.radius * angle.cos(), layout.radius * angle.sin(), z];
            tendons.push(Tendon {
                name: format!("aux_{:02}", tendons.len() + 1),
                points: vec![point(z), point(z + layout.segment_length)],
                fixed: Vec::new(),
                drive: layout.drive,
                tension: layout.tension,
                stroke: layout.stroke,
                attach_within: layout.attach_within,
                ring: 0.0,
                anchor: layout.anchor,
                compliance: 0.0,
                zero: 0.0,
            });
        }
    }
    tendons
}
