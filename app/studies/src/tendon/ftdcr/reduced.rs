//! A reduced model: three segments of constant curvature with tendons that stretch and go slack.
//!
//! The unknowns are the bending vectors θ of the segments [rad]: direction times angle. A tendon at angle φ shortens by
//! Σ r (θ_x cos φ + θ_y sin φ) over the segments it passes, exactly so for parallel tendons on circular arcs, and the
//! shape minimises the convex energy Σ E I / (2 L) |θ|² + Σ max(0, stroke - shortening)² / (2 c) (Webster and Jones
//! 2010 for the arcs). It serves to find the parameters that the finite elements are too slow to be fitted with.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Unit, Vector3};

use super::recording::N_TENDONS;

/// Lengths of the segments [m].
const LENGTHS: [f64; 3] = [60.0e-3, 62.5e-3, 64.0e-3];
/// Distance of the tendons from the axis [m].
const RADIUS: f64 = 4.5e-3;
/// E I of the backbone [N m²]: spring steel of 50 GPa, radius 0.5 mm.
const BENDING: f64 = 50e9 * std::f64::consts::FRAC_PI_4 * 0.5e-3 * 0.5e-3 * 0.5e-3 * 0.5e-3;
/// Distance of the marker beyond the end [m].
pub const MARKER: f64 = 8e-3;
/// Newton's steps at most: the energy is quadratic between changes of slack.
const MAX_STEPS: usize = 60;

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

    /// The shape of least energy under these strokes [m].
    pub fn shape(&self, strokes: &[f64; N_TENDONS]) -> Shape {
        let rows = self.shortening();
        let pull = SVector::<f64, N_TENDONS>::from_fn(|k, _| strokes[k] + self.zeros[k]);
        let stiffness = Bend::from_fn(|i, _| BENDING / LENGTHS[i / 2]);
        let stretch = |bend: &Bend| (pull - rows * bend).map(|s| s.max(0.0));
        let energy = |bend: &Bend| {
            0.5 * bend.dot(&stiffness.component_mul(bend))
                + stretch(bend).norm_squared() / (2.0 * self.compliance)
        };
        let mut bend = Bend::zeros();
        for _ in 0..MAX_STEPS {
            let stretched = stretch(&bend);
            let gradient = stiffness.component_mul(&bend) - rows.transpose() * stretched / self.compliance;
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
        let (end, frame) = chain(&bend);
        let axis: Vector3<f64> = frame.column(2).into();
        let tensions = stretch(&bend) / self.compliance;
        Shape { marker: end + MARKER * axis, axis, tensions: tensions.into() }
    }
}

/// End of the arcs and the frame there.
fn chain(bend: &Bend) -> (Vector3<f64>, Matrix3<f64>) {
    let (mut end, mut frame) = (Vector3::zeros(), Rotation3::identity());
    for (segment, length) in LENGTHS.into_iter().enumerate() {
        let towards = Vector3::new(bend[2 * segment], bend[2 * segment + 1], 0.0);
        let angle = towards.norm();
        let Some(axis) = Unit::try_new(Vector3::z().cross(&towards), 1e-9) else {
            end += frame * Vector3::new(0.0, 0.0, length);
            continue;
        };
        let arc = towards * ((1.0 - angle.cos()) / (angle * angle)) + Vector3::z() * (angle.sin() / angle);
        end += frame * (length * arc);
        frame *= Rotation3::from_axis_angle(&axis, angle);
    }
    (end, frame.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRAIGHT: Reduced = Reduced { zeros: [0.0; N_TENDONS], turns: [0.0; 3], compliance: 1e-9 };

    #[test]
    fn one_pulled_tendon_bends_the_first_segment_by_its_stroke() {
        let mut strokes = [-20e-3; N_TENDONS];
        strokes[0] = 4.5e-3;
        let shape = STRAIGHT.shape(&strokes);
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
        let shape = STRAIGHT.shape(&strokes);
        // One circle over the whole length, and the marker straight on.
        let length: f64 = LENGTHS.iter().sum();
        let end = Vector3::new(length * (1.0 - 1f64.cos()), 0.0, length * 1f64.sin());
        let marker = end + MARKER * Vector3::new(1f64.sin(), 0.0, 1f64.cos());
        assert!((shape.marker - marker).norm() < 1e-5 * length, "{:?} {marker:?}", shape.marker);
    }

    #[test]
    fn even_pull_leaves_the_robot_straight() {
        let shape = Reduced { compliance: 1e-4, ..STRAIGHT }.shape(&[1e-3; N_TENDONS]);
        // Nothing but the compliance gives way: 1 mm / 0.1 mm/N.
        assert!((shape.marker - Vector3::new(0.0, 0.0, 194.5e-3)).norm() < 1e-9, "{:?}", shape.marker);
        assert!(shape.tensions.iter().all(|t| (t - 10.0).abs() < 1e-6), "{:?}", shape.tensions);
    }
}
