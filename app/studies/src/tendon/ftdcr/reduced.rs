//! A reduced model: three segments of constant curvature with tendons that stretch and go slack.
//!
//! The unknowns are the bending vectors θ of the segments [rad]: direction times angle. A tendon at angle φ shortens by
//! Σ r (θ_x cos φ + θ_y sin φ) over the segments it passes, exactly so for parallel tendons on circular arcs, and the
//! shape minimises the energy Σ E I / (2 L) |θ|² + Σ max(0, stroke - shortening)² / (2 c) (Webster and Jones 2010 for the
//! arcs) less the work of the weight. A tendon that comes from being released holds back by its play. It serves to find the
//! parameters that the finite elements are too slow to be fitted with.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector3};

use super::recording::{N_TENDONS, Row};

/// Lengths of the segments [m].
const LENGTHS: [f64; 3] = [60.0e-3, 62.5e-3, 64.0e-3];
/// Distance of the tendons from the axis [m].
const RADIUS: f64 = 4.5e-3;
/// E I of the backbone [N m²]: spring steel of 50 GPa, radius 0.5 mm.
const BENDING: f64 = 50e9 * std::f64::consts::FRAC_PI_4 * 0.5e-3 * 0.5e-3 * 0.5e-3 * 0.5e-3;
/// Parts of the length whose weight acts at the end of each segment [m].
const CARRIED: [f64; 3] =
    [0.5 * (LENGTHS[0] + LENGTHS[1]), 0.5 * (LENGTHS[1] + LENGTHS[2]), 0.5 * LENGTHS[2]];
/// Newton's steps at most: without weight the energy is quadratic between changes of slack, and the weight, whose curvature the
/// steps leave out, is a fraction of the stiffness.
const MAX_STEPS: usize = 100;
/// Angle below which series replace the quotients of an arc [rad]: their next terms are 1e-10 of the first.
const SMALL: f64 = 1e-2;

type Bend = SVector<f64, 6>;

/// The model with its parameters.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// How far the tendons have already been pulled at stroke zero [m], as [`hysteron_base::Tendon::zero`].
    pub zeros: [f64; N_TENDONS],
    /// Turn of each segment's tendons about the axis [rad].
    pub turns: [f64; 3],
    /// Compliance of a tendon [m/N].
    pub compliance: f64,
    /// Half the width of each tendon's play [m].
    pub plays: [f64; N_TENDONS],
    /// Distance of the marker beyond the end [m].
    pub marker: f64,
    /// Weight of the body per length, in the frame of the robot [N/m].
    pub weight: Vector3<f64>,
}

/// A shape of the robot.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// The marker [m].
    pub marker: Vector3<f64>,
    /// Direction of the axis at the end.
    pub axis: Vector3<f64>,
    /// Tensions [N].
    pub tensions: [f64; N_TENDONS],
}

impl Reduced {
    /// Shortening of every tendon per bending [m/rad].
    fn shortening(&self) -> SMatrix<f64, N_TENDONS, 6> {
        let mut rows = SMatrix::zeros();
        for k in 0..N_TENDONS {
            let angle = self.turns[k / 3] + std::f64::consts::TAU * (k % 3) as f64 / 3.0;
            for segment in 0..=k / 3 {
                rows[(k, 2 * segment)] = RADIUS * angle.cos();
                rows[(k, 2 * segment + 1)] = RADIUS * angle.sin();
            }
        }
        rows
    }

    /// Strokes that reach the body [m]: those of the servos less what play takes on the way.
    pub fn strokes_at_body(&self, row: &Row) -> [f64; N_TENDONS] {
        std::array::from_fn(|k| row.strokes[k] - self.plays[k] * row.directions[k])
    }

    /// The shape of least energy in a row.
    pub fn shape(&self, row: &Row) -> Shape {
        let (rows, strokes) = (self.shortening(), self.strokes_at_body(row));
        let pull = SVector::<f64, N_TENDONS>::from_fn(|k, _| strokes[k] + self.zeros[k]);
        let stiffness = Bend::from_fn(|i, _| BENDING / LENGTHS[i / 2]);
        let stretch = |bend: &Bend| (pull - rows * bend).map(|s| s.max(0.0));
        let energy = |bend: &Bend| {
            0.5 * bend.dot(&stiffness.component_mul(bend))
                + stretch(bend).norm_squared() / (2.0 * self.compliance)
                - ArcChain::new(bend).work(&self.weight)
        };
        let mut bend = Bend::zeros();
        for _ in 0..MAX_STEPS {
            let stretched = stretch(&bend);
            let gradient = stiffness.component_mul(&bend)
                - rows.transpose() * stretched / self.compliance
                - ArcChain::new(&bend).work_gradient(&self.weight);
            let mut hessian = SMatrix::<f64, 6, 6>::from_diagonal(&stiffness);
            for k in (0..N_TENDONS).filter(|&k| stretched[k] > 0.0) {
                hessian += rows.row(k).transpose() * rows.row(k) / self.compliance;
            }
            let Some(factor) = hessian.cholesky() else { break };
            let step = -factor.solve(&gradient);
            // A hundred-thousandth of a degree moves the tip by less than 0.1 µm.
            if step.amax() < 1e-7 {
                break;
            }
            let (before, slope) = (energy(&bend), gradient.dot(&step));
            let mut part = 1.0;
            while energy(&(bend + part * step)) > before + 1e-4 * part * slope && part > 1e-3 {
                part *= 0.5;
            }
            bend += part * step;
        }
        let chain = ArcChain::new(&bend);
        let axis: Vector3<f64> = chain.frames[3].column(2).into();
        let tensions = stretch(&bend) / self.compliance;
        Shape { marker: chain.ends[3] + self.marker * axis, axis, tensions: tensions.into() }
    }
}

/// The arcs one after the other.
struct ArcChain {
    bend: Bend,
    /// Base and ends of the segments [m].
    ends: [Vector3<f64>; 4],
    /// Frames there.
    frames: [Matrix3<f64>; 4],
}

impl ArcChain {
    fn new(bend: &Bend) -> Self {
        let mut chain = Self { bend: *bend, ends: [Vector3::zeros(); 4], frames: [Matrix3::identity(); 4] };
        for (k, length) in LENGTHS.into_iter().enumerate() {
            let [x, y] = chain.towards(k);
            let (sine, cosine) = quotients(x.hypot(y));
            let arc = length * Vector3::new(x * cosine, y * cosine, sine);
            chain.ends[k + 1] = chain.ends[k] + chain.frames[k] * arc;
            let turn = Rotation3::new(Vector3::new(-y, x, 0.0));
            chain.frames[k + 1] = chain.frames[k] * turn.matrix();
        }
        chain
    }

    fn towards(&self, segment: usize) -> [f64; 2] {
        [self.bend[2 * segment], self.bend[2 * segment + 1]]
    }

    /// Work of the weight [J] on the way from the base.
    fn work(&self, weight: &Vector3<f64>) -> f64 {
        CARRIED.iter().zip(&self.ends[1..]).map(|(length, end)| length * weight.dot(end)).sum()
    }

    /// Its derivative by the bending [J/rad].
    fn work_gradient(&self, weight: &Vector3<f64>) -> Bend {
        let mut gradient = Bend::zeros();
        for (k, length) in LENGTHS.into_iter().enumerate() {
            let frame = self.frames[k];
            let [x, y] = self.towards(k);
            let angle = x.hypot(y);
            let (_, cosine) = quotients(angle);
            let [d_sine, d_cosine] = slopes(angle);
            let local = frame.transpose() * weight;
            // Weight of all that moves with the end, and its moment about it, seen from the base of the segment.
            let carried: f64 = CARRIED[k..].iter().sum();
            let moment = (k + 1..3).fold(Vector3::zeros(), |sum, j| {
                sum + CARRIED[j] * (frame.transpose() * (self.ends[j + 1] - self.ends[k + 1])).cross(&local)
            });
            for c in 0..2 {
                let mut along = Vector3::new(x, y, 0.0) * (d_cosine * [x, y][c]);
                along[c] += cosine;
                along[2] += d_sine * [x, y][c];
                let axis = if c == 0 { Vector3::y() } else { -Vector3::x() };
                let turning = turning(&Vector3::new(-y, x, 0.0), &axis);
                gradient[2 * k + c] = carried * length * local.dot(&along) + turning.dot(&moment);
            }
        }
        gradient
    }
}

/// sin a / a and (1 - cos a) / a².
fn quotients(a: f64) -> (f64, f64) {
    if a < SMALL {
        (1.0 - a * a / 6.0 + a.powi(4) / 120.0, 0.5 - a * a / 24.0 + a.powi(4) / 720.0)
    } else {
        (a.sin() / a, (1.0 - a.cos()) / (a * a))
    }
}

/// Derivatives of the [`quotients`] by a, over a.
fn slopes(a: f64) -> [f64; 2] {
    if a < SMALL {
        [-1.0 / 3.0 + a * a / 30.0, -1.0 / 12.0 + a * a / 180.0]
    } else {
        [(a * a.cos() - a.sin()) / a.powi(3), (a * a.sin() - 2.0 + 2.0 * a.cos()) / a.powi(4)]
    }
}

/// Angular velocity of a frame whose rotation vector changes: the left Jacobian of the rotations.
fn turning(vector: &Vector3<f64>, change: &Vector3<f64>) -> Vector3<f64> {
    let a = vector.norm();
    let (_, cosine) = quotients(a);
    let cubic = if a < SMALL { 1.0 / 6.0 - a * a / 120.0 } else { (a - a.sin()) / a.powi(3) };
    let once = vector.cross(change);
    change + cosine * once + cubic * vector.cross(&once)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARKER: f64 = 8e-3;
    const STRAIGHT: Reduced = Reduced {
        zeros: [0.0; N_TENDONS],
        turns: [0.0; 3],
        compliance: 1e-9,
        plays: [0.0; N_TENDONS],
        marker: MARKER,
        weight: Vector3::new(0.0, 0.0, 0.0),
    };

    fn pulled(strokes: [f64; N_TENDONS]) -> Row {
        Row::new(strokes, [0.0; 3])
    }

    #[test]
    fn one_pulled_tendon_bends_the_first_segment_by_its_stroke() {
        let mut strokes = [-20e-3; N_TENDONS];
        strokes[0] = 4.5e-3;
        let shape = STRAIGHT.shape(&pulled(strokes));
        // Stroke over radius is one radian; the tendon stretches by c T = 1e-9 m/N times 10 N.
        assert!((shape.axis - Vector3::new(1f64.sin(), 0.0, 1f64.cos())).norm() < 1e-5, "{:?}", shape.axis);
        // T r = E I θ / L.
        let tension = BENDING / LENGTHS[0] / RADIUS;
        assert!((shape.tensions[0] - tension).abs() < 1e-4 * tension, "{:?}", shape.tensions);
        assert_eq!(shape.tensions[1..], [0.0; N_TENDONS - 1]);
    }

    #[test]
    fn tendon_of_the_last_segment_bends_all_alike() {
        let mut strokes = [-20e-3; N_TENDONS];
        strokes[6] = 4.5e-3;
        let shape = STRAIGHT.shape(&pulled(strokes));
        // One circle over the whole length, and the marker straight on.
        let length: f64 = LENGTHS.iter().sum();
        let end = Vector3::new(length * (1.0 - 1f64.cos()), 0.0, length * 1f64.sin());
        let marker = end + MARKER * Vector3::new(1f64.sin(), 0.0, 1f64.cos());
        assert!((shape.marker - marker).norm() < 1e-5 * length, "{:?} {marker:?}", shape.marker);
    }

    #[test]
    fn even_pull_leaves_the_robot_straight() {
        let shape = Reduced { compliance: 1e-4, ..STRAIGHT }.shape(&pulled([1e-3; N_TENDONS]));
        // Nothing but the compliance gives way: 1 mm / 0.1 mm/N.
        assert!((shape.marker - Vector3::new(0.0, 0.0, 194.5e-3)).norm() < 1e-9, "{:?}", shape.marker);
        assert!(shape.tensions.iter().all(|t| (t - 10.0).abs() < 1e-6), "{:?}", shape.tensions);
    }

    #[test]
    fn a_light_weight_bends_as_the_moments_say() {
        // Slack tendons; sideways, so little that the arcs stay small.
        let weight = Vector3::new(1e-3, -2e-3, 0.0);
        let shape = Reduced { weight, ..STRAIGHT }.shape(&pulled([-20e-3; N_TENDONS]));
        let at_end = [LENGTHS[0], LENGTHS[0] + LENGTHS[1], LENGTHS.iter().sum()];
        // E I θ / L of a segment is the moment about its middle, for an arc moves what follows as a hinge there does.
        let angle = |k: usize| {
            let middle = at_end[k] - 0.5 * LENGTHS[k];
            let moment: f64 = (k..3).map(|j| CARRIED[j] * (at_end[j] - middle)).sum();
            moment * LENGTHS[k] / BENDING
        };
        let expected = weight * (0..3).map(angle).sum::<f64>();
        // What is left out goes with the square of the angles.
        let off = shape.axis - (Vector3::z() + expected);
        assert!(
            off.norm() < expected.norm_squared() && expected.norm() > 1e-3,
            "{:?} {expected:?}",
            shape.axis
        );
    }

    #[test]
    fn work_of_the_weight_has_its_gradient() {
        let weight = Vector3::new(0.3, -0.5, -0.7);
        for size in [1e-3, 9e-3, 0.4, 2.0] {
            let bend = size * Bend::new(0.6, -0.3, 0.2, 0.9, -0.7, 0.1);
            let gradient = ArcChain::new(&bend).work_gradient(&weight);
            for c in 0..6 {
                let step = 1e-5 * Bend::ith(c, 1.0);
                let [up, down] = [bend + step, bend - step].map(|bend| ArcChain::new(&bend).work(&weight));
                // Rounding of 0.1 J over the step, and its square.
                assert!((gradient[c] - (up - down) / 2e-5).abs() < 1e-10, "{size} {c}");
            }
        }
    }

    #[test]
    fn play_holds_back_by_its_half_width() {
        let with_play = Reduced { plays: [0.5e-3; N_TENDONS], ..STRAIGHT };
        let mut row = pulled([-20e-3; N_TENDONS]);
        (row.strokes[0], row.directions[0]) = (5e-3, 1.0);
        let mut less = row.clone();
        (less.strokes[0], less.directions[0]) = (4.5e-3, 0.0);
        // Rounding of strokes.
        assert!((with_play.shape(&row).marker - with_play.shape(&less).marker).norm() < 1e-12);
    }
}
