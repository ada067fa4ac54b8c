//! The built-in mesher: round bodies along z, with a bore, channels and taper.
//!
//! Main decision: the cross-section is triangulated once and carried along z; a taper scales all of it. The
//! prisms between two sections are cut into three tetrahedra each. So the same numbers give the same mesh
//! on every machine, up to the last digit of sine and cosine, and its volume is known exactly.

mod delaunay;
mod levels;
mod section;

use std::collections::BTreeMap;

use hysteron_base::BadInput;
use hysteron_base::size::{check_at_most, check_memory};

use crate::{Cells, Mesh, Result};
use section::{TubeSection, Walls};

/// A round channel along the body, for a tendon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TendonChannel {
    /// Direction from the axis, from x towards y \[rad\].
    pub angle: f64,
    /// Distance of its centre line from the axis, at the base \[m\].
    pub center_radius: f64,
    /// Radius at the base \[m\].
    pub radius: f64,
}

/// How the body is divided along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Layers {
    /// This many, each as high as its outer radius asks: all have the same shape. Every link gets one.
    Count(u32),
    /// Of equal height within a link, none higher than this \[m\].
    Height(f64),
    /// Fine near the upper end of every link, where tendons end: a corner of the profile marks such a place in the middle of a
    /// straight body too.
    Graded {
        /// No layer is higher than this \[m\].
        height: f64,
        /// Height of the three layers next to such an end, and of those on its other side \[m\]: a third of the radius of the
        /// anchor there.
        end: f64,
    },
}

/// Kind of tetrahedra.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Four nodes.
    Linear,
    /// Ten nodes, straight edges.
    Quadratic,
}

/// A body of round cross-section from z = 0 up, solid or hollow.
///
/// Circles become polygons with their vertices on the circle, as Gmsh makes them: a polygon of n sides
/// encloses sin(2π/n)·n/2π of the true area. Where the profile is constant the channels run straight along
/// z. Where it tapers the whole section is scaled by the outer radius, so bore and channels taper with it
/// and the walls keep their proportions.
#[derive(Debug, Clone, PartialEq)]
pub struct Tube {
    /// Corners (z, outer radius) from the base up, the first at z = 0: two for a tube or a cone, one more
    /// for every further link \[m\].
    pub profile: Vec<[f64; 2]>,
    /// Radius of the central bore at the base \[m\]; 0 for a solid body.
    pub bore_radius: f64,
    /// Channels in the wall.
    pub channels: Vec<TendonChannel>,
    /// Sides of the outer polygon.
    pub outer_divisions: u32,
    /// Sides of the bore's polygon; not used for a solid body.
    pub bore_divisions: u32,
    /// Sides of every channel's polygon.
    pub channel_divisions: u32,
    /// Division along z.
    pub layers: Layers,
    /// Kind of tetrahedra.
    pub order: Order,
}

const MAX_DIVISIONS: u32 = 512;
const MAX_NODES: usize = 5_000_000;
const MAX_LAYERS: usize = 20_000;
const MAX_CORNERS: usize = 1000;
const MAX_CHANNELS: usize = 64;
/// Memory per node of the mesh, its cells and what checks them, and as much again for the nodes between [bytes].
const BYTES_PER_NODE: f64 = 1500.0;

const FEWER: &str = "use fewer divisions or layers, or a longer edge";

impl Tube {
    /// Meshes the body. Groups: `base` (nodes at z = 0), `tip` (at the other end), `body` (all).
    ///
    /// Nodes are ordered section by section from the base up; with quadratic order the middles follow.
    ///
    /// # Errors
    /// `BadInput` naming the field: a length that is not positive and finite, a profile that does not rise
    /// in z, divisions outside 3 to 512, a wall (between channel, bore, surface and other channels) thinner
    /// than 1 % of the outer radius, more than 64 channels, 20 000 layers or 5 million nodes, or more than this machine
    /// can hold.
    pub fn mesh(&self) -> Result<Mesh> {
        let walls = self.check()?;
        let levels = levels::levels(&self.profile, self.layers)?;
        let section = section::triangulate(&walls)?;
        let quadratic = if self.order == Order::Quadratic { 8 } else { 1 };
        let n_nodes = section.points.len().saturating_mul(levels.len()).saturating_mul(quadratic);
        if n_nodes > MAX_NODES {
            return Err(BadInput::new("tube", format!("at most {MAX_NODES} nodes"), n_nodes.to_string())
                .hint(FEWER)
                .into());
        }
        check_memory("tube", BYTES_PER_NODE * n_nodes as f64, FEWER)?;
        let mesh = extrude(&section, &levels);
        Ok(match self.order {
            Order::Linear => mesh,
            Order::Quadratic => mesh.to_quadratic(),
        })
    }

    /// The same body with polygons of the circles' areas: their corners lie outside the circles. The second moment of area
    /// is then right to 0.02 % from 16 sides on, to 0.3 % from 8 and to 5 % from 4.
    pub fn with_circle_areas(mut self) -> Self {
        let wider = |divisions: u32| {
            let turn = std::f64::consts::TAU / f64::from(divisions.max(3));
            (turn / turn.sin()).sqrt()
        };
        for corner in &mut self.profile {
            corner[1] *= wider(self.outer_divisions);
        }
        self.bore_radius *= wider(self.bore_divisions);
        for channel in &mut self.channels {
            channel.radius *= wider(self.channel_divisions);
        }
        self
    }

    fn check(&self) -> std::result::Result<Walls, BadInput> {
        let positive = |field: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                return Ok(());
            }
            Err(BadInput::new(format!("tube: {field}"), "a positive length", mm(value)))
        };
        let divisions = |field: &str, value: u32| {
            if (3..=MAX_DIVISIONS).contains(&value) {
                return Ok(value as usize);
            }
            Err(BadInput::new(format!("tube: {field}"), format!("3 to {MAX_DIVISIONS}"), value.to_string()))
        };
        let [first, _, ..] = self.profile[..] else {
            return Err(BadInput::new(
                "tube: profile",
                "at least two corners (z, radius)",
                self.profile.len().to_string(),
            ));
        };
        check_at_most("tube: profile", self.profile.len(), MAX_CORNERS)?;
        check_at_most("tube: channels", self.channels.len(), MAX_CHANNELS)?;
        if first[0] != 0.0 {
            return Err(BadInput::new("tube: profile 0: z", "0 mm, the base", mm(first[0])));
        }
        for (k, pair) in self.profile.windows(2).enumerate() {
            positive(&format!("profile {}: z above the corner before", k + 1), pair[1][0] - pair[0][0])?;
        }
        for (k, corner) in self.profile.iter().enumerate() {
            positive(&format!("profile {k}: radius"), corner[1])?;
        }
        let radius = first[1];
        let n_outer = divisions("outer_divisions", self.outer_divisions)?;
        let thinnest = radius / 100.0;
        let wall = |field: String, thickness: f64| {
            // Not a number fails here too.
            if thickness >= thinnest {
                return Ok(());
            }
            Err(BadInput::new(field, format!("a wall of at least {}", mm(thinnest)), mm(thickness))
                .hint("move the channel, make it smaller, or use more outer divisions"))
        };
        // The flat of the outer polygon lies inside the circle.
        let outside = radius * (std::f64::consts::PI / n_outer as f64).cos();
        let bore = if self.bore_radius == 0.0 {
            None
        } else {
            positive("bore_radius", self.bore_radius)?;
            wall("tube: bore_radius".into(), outside - self.bore_radius)?;
            Some((self.bore_radius, divisions("bore_divisions", self.bore_divisions)?))
        };
        let mut channels: Vec<([f64; 2], f64, f64)> = Vec::new();
        for (k, channel) in self.channels.iter().enumerate() {
            divisions("channel_divisions", self.channel_divisions)?;
            positive(&format!("channel {k}: radius"), channel.radius)?;
            let at = channel.center_radius;
            if !(at.is_finite() && at >= 0.0) {
                return Err(BadInput::new(
                    format!("tube: channel {k}: center_radius"),
                    "a length of at least 0 mm",
                    mm(at),
                ));
            }
            if !channel.angle.is_finite() {
                return Err(BadInput::new(
                    format!("tube: channel {k}: angle"),
                    "a finite angle",
                    channel.angle.to_string(),
                ));
            }
            wall(format!("tube: channel {k}: to the surface"), outside - at - channel.radius)?;
            if bore.is_some() {
                wall(format!("tube: channel {k}: to the bore"), at - channel.radius - self.bore_radius)?;
            }
            let center = [at * channel.angle.cos(), at * channel.angle.sin()];
            for (other, (c, r, _)) in channels.iter().enumerate() {
                let distance = (c[0] - center[0]).hypot(c[1] - center[1]);
                wall(format!("tube: channel {k}: to channel {other}"), distance - r - channel.radius)?;
            }
            channels.push((center, channel.radius, channel.angle));
        }
        Ok(Walls {
            outer: (radius, n_outer),
            bore,
            channels,
            channel_divisions: self.channel_divisions as usize,
        })
    }
}

/// Stacks the section and cuts the prisms between.
///
/// The diagonal of every side runs from the lower node of smaller rank to the upper one of greater rank.
/// The rank is the number in the section, counted backwards in every other layer: so the faces match, and
/// the diagonals zigzag instead of winding round the body, which would couple bending and torsion.
fn extrude(section: &TubeSection, levels: &[[f64; 2]]) -> Mesh {
    let n = section.points.len();
    let nodes: Vec<[f64; 3]> = levels
        .iter()
        .flat_map(|&[z, scale]| section.points.iter().map(move |p| [p[0] * scale, p[1] * scale, z]))
        .collect();
    let mut cells = Vec::with_capacity(3 * section.triangles.len() * (levels.len() - 1));
    for layer in 0..levels.len() - 1 {
        let low = (layer * n) as u32;
        let high = low + n as u32;
        for triangle in &section.triangles {
            let mut v = *triangle;
            v.sort_unstable();
            if layer % 2 == 1 {
                v.reverse();
            }
            let [a, b, c] = v;
            let start = triangle.iter().position(|&i| i == a).unwrap_or(0);
            let turns_left = triangle[(start + 1) % 3] == b;
            for mut tet in [
                [low + a, low + b, low + c, high + c],
                [low + a, high + b, low + b, high + c],
                [low + a, high + a, high + b, high + c],
            ] {
                if !turns_left {
                    tet.swap(0, 1);
                }
                cells.push(tet);
            }
        }
    }
    let n_all = nodes.len() as u32;
    let groups = BTreeMap::from([
        ("base".to_owned(), (0..n as u32).collect()),
        ("body".to_owned(), (0..n_all).collect()),
        ("tip".to_owned(), (n_all - n as u32..n_all).collect()),
    ]);
    Mesh { nodes, cells: Cells::Tet4(cells), groups }
}

fn mm(metres: f64) -> String {
    format!("{} mm", ((metres * 1e9).round() / 1e6).clamp(-f64::MAX, f64::MAX))
}
