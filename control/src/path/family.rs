//! Curves with a name, centred and in the plane (x, y).
//!
//! Smooth ones are polygons of `FINE` sides a turn: of a circle they cut off 3e-7 of its radius.

use super::outline::OutlinePoint;
use std::f64::consts::TAU;

/// Sides of a polygon for a smooth turn.
const FINE: usize = 4096;

/// A circle of this diameter, from (d / 2, 0) counter-clockwise.
pub(super) fn circle(diameter: f64) -> Vec<OutlinePoint> {
    closed(1, |u| [0.5 * diameter * (TAU * u).cos(), 0.5 * diameter * (TAU * u).sin()])
}

/// A square on its corner; both diagonals have this length. From (d / 2, 0) counter-clockwise.
pub(super) fn diamond(diagonal: f64) -> Vec<OutlinePoint> {
    let r = 0.5 * diagonal;
    vec![[r, 0.0, 0.0], [0.0, r, 0.0], [-r, 0.0, 0.0], [0.0, -r, 0.0]]
}

/// A square with sides along the axes. From its corner at the top right counter-clockwise.
pub(super) fn square(side: f64) -> Vec<OutlinePoint> {
    let r = 0.5 * side;
    vec![[r, r, 0.0], [-r, r, 0.0], [-r, -r, 0.0], [r, -r, 0.0]]
}

/// An ellipse of this length and `aspect` times that height, lying. From (length / 2, 0) counter-clockwise.
pub(super) fn ellipse(length: f64, aspect: f64) -> Vec<OutlinePoint> {
    closed(1, |u| [0.5 * length * (TAU * u).cos(), 0.5 * aspect * length * (TAU * u).sin()])
}

/// The rose r = d/2 cos kθ, whose petals reach out to a circle of this diameter: k of them where k is odd, else 2k.
/// From (d / 2, 0).
pub(super) fn rose(diameter: f64, k: u32) -> Vec<OutlinePoint> {
    let turn = if k.is_multiple_of(2) { TAU } else { 0.5 * TAU };
    closed(k, |u| {
        let (sin, cos) = (turn * u).sin_cos();
        let r = 0.5 * diameter * (f64::from(k) * turn * u).cos();
        [r * cos, r * sin]
    })
}

/// x = w/2 sin(2π n_x u + φ), y = h/2 sin(2π n_y u) for u from 0 to 1.
pub(super) fn lissajous(width: f64, height: f64, cycles: [u32; 2], phase: f64) -> Vec<OutlinePoint> {
    let [nx, ny] = cycles.map(f64::from);
    closed(cycles[0].max(cycles[1]), |u| {
        [0.5 * width * (TAU * nx * u + phase).sin(), 0.5 * height * (TAU * ny * u).sin()]
    })
}

/// The lemniscate of Bernoulli, lying, of this width; from its centre up to the right.
pub(super) fn figure_eight(width: f64) -> Vec<OutlinePoint> {
    closed(2, |u| {
        let (sin, cos) = (TAU * (u - 0.25)).sin_cos();
        let r = 0.5 * width / (1.0 + sin * sin);
        [r * cos, -r * sin * cos]
    })
}

/// A spiral of even distances (Archimedes) from the centre out to half this diameter.
pub(super) fn spiral(diameter: f64, turns: f64) -> Vec<OutlinePoint> {
    let n = (FINE as f64 * turns).ceil().max(64.0) as usize;
    let point = |i: usize| {
        let u = i as f64 / n as f64;
        let (sin, cos) = (TAU * turns * u).sin_cos();
        [0.5 * diameter * u * cos, 0.5 * diameter * u * sin, 0.0]
    };
    (0..=n).map(point).collect()
}

fn closed(turns: u32, at: impl Fn(f64) -> [f64; 2]) -> Vec<OutlinePoint> {
    let n = FINE * turns as usize;
    let point = |i: usize| {
        let [x, y] = at(i as f64 / n as f64);
        [x, y, 0.0]
    };
    (0..n).map(point).collect()
}
