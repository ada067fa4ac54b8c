//! The cross-section: polygons for the walls, rings of points between them, triangles.
//!
//! Main decision: no other point lies inside the circle of a hole, so its polygon is in the Delaunay
//! triangulation by itself, and the triangles to take out are those with three corners on one hole.

use std::f64::consts::TAU;

use hysteron_base::BadInput;
use hysteron_base::size::check_at_most;

use super::delaunay;

/// Most points of a section: each is compared with all triangles so far.
const MAX_POINTS: usize = 6000;

/// How fast triangles may grow away from a wall: length per length \[-\].
const GROWTH: f64 = 0.25;

/// Height of an equilateral triangle over its side.
const HEIGHT: f64 = 0.866;

/// The circles, checked: they keep clear of each other.
pub(super) struct Walls {
    /// Radius \[m\] and sides.
    pub(super) outer: (f64, usize),
    /// Radius \[m\] and sides.
    pub(super) bore: Option<(f64, usize)>,
    /// Centre \[m\], radius \[m\], angle \[rad\].
    pub(super) channels: Vec<([f64; 2], f64, f64)>,
    /// Sides of every channel.
    pub(super) channel_divisions: usize,
}

/// A triangulated cross-section at the base.
pub(super) struct TubeSection {
    /// Outer polygon, bore, channels one after the other, then the points between \[m\].
    pub(super) points: Vec<[f64; 2]>,
    /// Corners, turning left.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A wall as seen from the points between, in units of the outer radius.
struct WallCircle {
    center: [f64; 2],
    radius: f64,
    /// Length of the polygon's sides.
    side: f64,
    /// The body lies inside the circle (the outer one) and not around it.
    encloses: bool,
}

impl WallCircle {
    /// Distance of a point of the body from the wall; negative outside the body.
    fn distance(&self, p: [f64; 2]) -> f64 {
        let r = (p[0] - self.center[0]).hypot(p[1] - self.center[1]);
        if self.encloses { self.radius - r } else { r - self.radius }
    }
}

/// Triangulates the section.
///
/// # Errors
/// `BadInput` where the polygons are too coarse for the walls between them.
pub(super) fn triangulate(walls: &Walls) -> Result<TubeSection, BadInput> {
    let scale = walls.outer.0;
    let mut points = Vec::new();
    // The hole on which each point lies: 1 is the bore, then the channels; 0 for the others.
    let mut hole = Vec::new();
    let mut circles = Vec::new();
    let mut add = |hole_number: usize, center: [f64; 2], radius: f64, sides: usize, start: f64| {
        points.extend(polygon(center, radius, sides, start));
        hole.resize(points.len(), hole_number);
        let side = TAU * radius / sides as f64;
        circles.push(WallCircle { center, radius, side, encloses: hole_number == 0 });
    };
    add(0, [0.0; 2], 1.0, walls.outer.1, 0.0);
    if let Some((radius, sides)) = walls.bore {
        add(1, [0.0; 2], radius / scale, sides, 0.0);
    }
    for (k, &(center, radius, angle)) in walls.channels.iter().enumerate() {
        let sides = walls.channel_divisions;
        // A flat side, not a corner, faces the thin wall.
        let start = angle + 0.5 * TAU / sides as f64;
        add(2 + k, center.map(|v| v / scale), radius / scale, sides, start);
    }
    let area: f64 = polygon_area(walls.outer.1, scale)
        - walls.bore.map_or(0.0, |(radius, sides)| polygon_area(sides, radius))
        - walls.channels.iter().map(|c| polygon_area(walls.channel_divisions, c.1)).sum::<f64>();

    fill(walls, &circles, &mut points);
    check_at_most("tube: points of the cross-section", points.len(), MAX_POINTS)
        .map_err(|bad| bad.hint("use fewer divisions, or a longer edge"))?;
    hole.resize(points.len(), 0);

    let mut triangles = delaunay::triangulate(&points);
    triangles.retain(|t| {
        let [a, b, c] = t.map(|i| hole[i as usize]);
        a == 0 || a != b || b != c
    });
    for t in &mut triangles {
        // Start from the smallest corner: the order then depends on the triangles only.
        let first = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
        t.rotate_left(first);
    }
    triangles.sort_unstable();
    for p in &mut points {
        *p = p.map(|v| v * scale);
    }
    let covered: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| points[i as usize]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
        })
        .sum();
    if (covered - area).abs() > 1e-9 * area {
        return Err(BadInput::new(
            "tube",
            "divisions that resolve the walls",
            "walls finer than the divisions",
        )
        .hint("use more outer, bore and channel divisions"));
    }
    Ok(TubeSection { points, triangles })
}

fn polygon(center: [f64; 2], radius: f64, sides: usize, start: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..sides).map(move |k| {
        let angle = start + TAU * k as f64 / sides as f64;
        [center[0] + radius * angle.cos(), center[1] + radius * angle.sin()]
    })
}

/// Area of the polygon with its corners on the circle \[m²\].
fn polygon_area(sides: usize, radius: f64) -> f64 {
    0.5 * sides as f64 * radius * radius * (TAU / sides as f64).sin()
}

/// Adds points between the walls: rings around the channels, then rings around the axis, each point where
/// the local size leaves room for it.
fn fill(walls: &Walls, circles: &[WallCircle], points: &mut Vec<[f64; 2]>) {
    let size = |p: [f64; 2]| {
        circles.iter().map(|c| c.side + GROWTH * c.distance(p).max(0.0)).fold(f64::INFINITY, f64::min)
    };
    let mut candidates = Vec::new();
    let n_round = if walls.bore.is_some() { 2 } else { 1 };
    for channel in &circles[n_round..] {
        let mut radius = channel.radius;
        for ring in 1..=3 {
            radius += HEIGHT * (channel.side + GROWTH * (radius - channel.radius));
            let here = channel.side + GROWTH * (radius - channel.radius);
            let sides = (TAU * radius / here).round().max(3.0) as usize;
            let towards = channel.center[1].atan2(channel.center[0]);
            let start = towards + if ring % 2 == 1 { 0.0 } else { 0.5 * TAU / sides as f64 };
            candidates.extend(polygon(channel.center, radius, sides, start));
        }
    }
    candidates.extend(rings(walls, circles));
    for p in candidates {
        let here = size(p);
        let clear = circles.iter().all(|c| c.distance(p) > 0.6 * here);
        let apart = || points.iter().all(|q| (p[0] - q[0]).hypot(p[1] - q[1]) > 0.75 * here);
        if clear && apart() {
            points.push(p);
        }
        if points.len() > MAX_POINTS {
            return;
        }
    }
}

/// Points on circles around the axis, evenly spaced in units of the local size.
fn rings(walls: &Walls, circles: &[WallCircle]) -> Vec<[f64; 2]> {
    const STEPS: usize = 1024;
    let outer = &circles[0];
    let bore = walls.bore.map(|_| &circles[1]);
    let inner = bore.map_or(0.0, |c| c.radius);
    let size = |r: f64| {
        let from_bore = bore.map_or(f64::INFINITY, |c| c.side + GROWTH * (r - c.radius));
        (outer.side + GROWTH * (1.0 - r)).min(from_bore)
    };
    // Number of ring spacings between the surface and every radius.
    let radius = |k: usize| 1.0 - (1.0 - inner) * k as f64 / STEPS as f64;
    let mut spacings = vec![0.0];
    for k in 0..STEPS {
        let middle = 0.5 * (radius(k) + radius(k + 1));
        spacings.push(spacings[k] + (radius(k) - radius(k + 1)) / (HEIGHT * size(middle)));
    }
    let total = spacings[STEPS];
    let n_spacings = (total.round() as usize).max(1);
    let symmetry = symmetry(walls);
    let mut out = Vec::new();
    for ring in 1..n_spacings {
        let target = total * ring as f64 / n_spacings as f64;
        let r = radius(spacings.partition_point(|s| *s < target).min(STEPS));
        let sides = symmetry * ((TAU * r / size(r) / symmetry as f64).round() as usize).max(1);
        let start = if ring % 2 == 1 { 0.5 * TAU / sides as f64 } else { 0.0 };
        out.extend(polygon([0.0; 2], r, sides, start));
    }
    if bore.is_none() {
        out.push([0.0; 2]);
    }
    out
}

/// The largest number up to 6 that divides the divisions and the number of channels.
fn symmetry(walls: &Walls) -> usize {
    let bore = walls.bore.map_or(0, |b| b.1);
    (1..=6)
        .rev()
        .find(|s| {
            walls.outer.1.is_multiple_of(*s)
                && bore.is_multiple_of(*s)
                && walls.channels.len().is_multiple_of(*s)
        })
        .unwrap_or(1)
}
