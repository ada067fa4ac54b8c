//! Carriers of the points of a tendon: an element, a ring of body points, or an anchor.

use hysteron_base::{BadInput, Tendon};
use hysteron_fem::{Anchor, Embedding, FemModel, axes_across};
use nalgebra::Vector3;

use crate::Result;
use crate::cable::CablePoint;

/// Points on the circle that carries a cable point; a mesh with finer elements gains nothing by more.
const RING_POINTS: usize = 16;

/// Least share of an anchor's bump that must lie in the body [-]. A point on a flat surface has a half, on an edge a
/// quarter; one in a channel that is as wide as the anchor has nothing.
const LEAST_SHARE: f64 = 0.05;

/// Distance of the nodes that stand for an anchor in the stiffness, over its radius [-]: some thirty to a
/// hundred of a whole one, as many as a ring has.
const CORE_SPACING: f64 = 0.5;

/// Sum of the weights of free nodes below which a point lies in the clamp [-]: round-off of barycentric coordinates.
const HELD: f64 = 1e-9;

/// Carriers of point `k` of a tendon; a force on one element sinks in the deeper the finer the mesh, on a ring or an anchor
/// of given size it does not.
pub(crate) fn carried_tendon_point(
    body: &FemModel,
    tendon: &Tendon,
    k: usize,
    place: &str,
) -> Result<CablePoint> {
    match tendon.anchor {
        Some(radius) => carried_by_anchor(body, tendon, k, radius, place),
        None if tendon.ring == 0.0 => {
            carried(body, tendon.points[k], tendon.attach_within, place).map(CablePoint::Carried)
        }
        None => carried_by_ring(body, tendon, k, place).map(CablePoint::Carried),
    }
}

/// The body within `radius` of the point. A point in the clamp stays there: the base pulls at the clamp alone.
fn carried_by_anchor(
    body: &FemModel,
    tendon: &Tendon,
    k: usize,
    radius: f64,
    place: &str,
) -> Result<CablePoint> {
    let anchor = Anchor { center: tendon.points[k], radius, along: direction(tendon, k).into() };
    let carriers = anchor.carriers(body);
    let share = carriers.as_ref().map_or(0.0, |carriers| carriers.volume / anchor.whole_volume());
    let carriers = carriers.filter(|_| share >= LEAST_SHARE).ok_or_else(|| {
        let mm = anchor.center.map(|c| 1e3 * c);
        let expected =
            format!("a point with at least {:.0} % of its anchor in the body", 100.0 * LEAST_SHARE);
        let found = format!("{:.1} % at ({:.3}, {:.3}, {:.3}) mm", 100.0 * share, mm[0], mm[1], mm[2]);
        BadInput::new(place, expected, found)
            .hint("anchor_radius_mm must be larger than the radius of the channel around the tendon")
    })?;
    let point = Embedding::new(body, anchor.center);
    let free = point.nodes.iter().zip(&point.weights).filter(|(node, _)| (**node as usize) < body.n_free);
    if free.map(|(_, weight)| weight.abs()).sum::<f64>() < HELD {
        return Ok(CablePoint::Carried(held(body, point)));
    }
    let core = carriers.thinned(body, CORE_SPACING * radius);
    Ok(CablePoint::Anchored { carriers: carriers.embedding, core })
}

/// A point of the clamp without the round-off of its free nodes.
fn held(body: &FemModel, point: Embedding) -> Embedding {
    let carriers = point.nodes.into_iter().zip(point.weights);
    let (nodes, weights) = carriers.filter(|(node, _)| *node as usize >= body.n_free).unzip();
    Embedding { nodes, weights, distance: 0.0 }
}

/// The mean of a circle of radius `tendon.ring` around the point, across the tendon.
fn carried_by_ring(body: &FemModel, tendon: &Tendon, k: usize, place: &str) -> Result<Embedding> {
    let point = tendon.points[k];
    let along = direction(tendon, k);
    let [across, other] = axes_across(&along);
    let mut ring = Embedding { nodes: Vec::new(), weights: Vec::new(), distance: 0.0 };
    for i in 0..RING_POINTS {
        let angle = std::f64::consts::TAU * i as f64 / RING_POINTS as f64;
        let offset = tendon.ring * (angle.cos() * across + angle.sin() * other);
        let on_ring = Vector3::from(point) + offset;
        let carrier = Embedding::new(body, on_ring.into());
        for (node, weight) in carrier.nodes.into_iter().zip(carrier.weights) {
            let share = weight / RING_POINTS as f64;
            match ring.nodes.iter().position(|&known| known == node) {
                Some(known) => ring.weights[known] += share,
                None => {
                    ring.nodes.push(node);
                    ring.weights.push(share);
                }
            }
        }
        ring.distance = ring.distance.max(carrier.distance);
    }
    check_distance(point, ring.distance, tendon.attach_within, place)?;
    Ok(ring)
}

/// Unit vector along a tendon at its point `k`.
fn direction(tendon: &Tendon, k: usize) -> Vector3<f64> {
    let at = |k: usize| Vector3::from(tendon.points[k]);
    (at((k + 1).min(tendon.points.len() - 1)) - at(k.saturating_sub(1))).normalize()
}

/// The element that carries a point, which may lie so far outside the body [m].
pub(crate) fn carried(body: &FemModel, point: [f64; 3], within: f64, place: &str) -> Result<Embedding> {
    let embedding = Embedding::new(body, point);
    check_distance(point, embedding.distance, within, place)?;
    Ok(embedding)
}

fn check_distance(point: [f64; 3], distance: f64, within: f64, place: &str) -> Result<()> {
    if distance <= within {
        return Ok(());
    }
    let mm = point.map(|c| 1e3 * c);
    Err(BadInput::new(
        place,
        format!("a point of the body, or at most {} mm outside it", shown_mm(within)),
        format!("({:.3}, {:.3}, {:.3}) mm, {:.3} mm outside", mm[0], mm[1], mm[2], 1e3 * distance),
    )
    .hint(
        "check the mesh's unit and origin; in a channel, set ring_mm to a little more than its radius; an eyelet or \
         pulley outside the body is { at_mm = [x, y, z], fixed = true }",
    )
    .into())
}

/// A length in millimetres without the noise of the conversion.
pub(crate) fn shown_mm(metres: f64) -> f64 {
    (1e6 * 1e3 * metres).round() / 1e6
}
