//! From the tracker's frame to the robot's: a rotation and a translation, no scale, no mirror.
//!
//! Two ways to find it: points known in both frames (Kabsch's method), or directions that the tip moves in when
//! tendons are pulled (Wahba's problem, solved the same way) with its place at rest. The robot's body points along
//! +z, so that a bent tip moves towards -z: this detects a mirrored numbering of the tendons.

use crate::Pose;
use hysteron_base::BadInput;
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Smallest width of the points, of their length, that fixes the rotation about their line [-].
const FLAT: f64 = 0.02;
/// Thickness of the points, of their length, from which on they distinguish a mirror image from a rotation [-].
const THICK: f64 = 0.03;
/// Factor by which a mirror image must fit better before the data count as mirrored [-].
const MIRROR: f64 = 3.0;
/// Largest factor between the sizes of the two sets of points [-]: beyond, their units differ.
const SCALE: f64 = 2.0;
/// Largest angle between motions and directions that a rotation may leave [rad]: 15°.
const MAX_ANGLE: f64 = std::f64::consts::PI / 12.0;

/// Robot's frame from the tracker's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Registration {
    rotation: UnitQuaternion<f64>,
    translation: Vector3<f64>,
}

/// How the tip moved when something was pulled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PulledMotion {
    /// Displacement of the tip in the tracker's frame [m]. Long ones count more.
    pub in_tracker: [f64; 3],
    /// Its direction in the robot's frame, of any length [-].
    pub in_robot: [f64; 3],
}

impl PulledMotion {
    /// The motions of a robot with n >= 3 tendons at these angles about +z [rad], from the displacements of the tip
    /// in the tracker's frame when each was pulled by the same stroke from the same rest (n) [m].
    ///
    /// Each tendon bends the tip towards itself and a little down. What all have in common points down; what each has
    /// of its own points towards its tendon. The first is short, but without it a mirrored numbering would pass.
    pub fn of_tendons(displacements: &[[f64; 3]], angles: &[f64]) -> Vec<Self> {
        let n = displacements.len() as f64;
        let moved: Vec<Vector3<f64>> = displacements.iter().copied().map(Vector3::from).collect();
        let common = moved.iter().sum::<Vector3<f64>>() / n;
        let towards: Vec<Vector3<f64>> = angles.iter().map(|a| Vector3::new(a.cos(), a.sin(), 0.0)).collect();
        let centre = towards.iter().sum::<Vector3<f64>>() / n;
        let own = moved.iter().zip(&towards).map(|(moved, towards)| Self {
            in_tracker: (moved - common).into(),
            in_robot: (towards - centre).into(),
        });
        own.chain([Self { in_tracker: common.into(), in_robot: [0.0, 0.0, -1.0] }]).collect()
    }
}

impl Registration {
    /// The registration of a tracker whose frame is the robot's.
    pub fn identity() -> Self {
        Self { rotation: UnitQuaternion::identity(), translation: Vector3::zeros() }
    }

    /// From a file: `rotation` w, x, y, z [-], `translation` [m].
    ///
    /// # Errors
    /// `BadInput` if the quaternion is not of length 1 within 1e-6, or anything is not finite.
    pub fn new(rotation: [f64; 4], translation: [f64; 3]) -> Result<Self, BadInput> {
        let [w, x, y, z] = rotation;
        let q = Quaternion::new(w, x, y, z);
        let length = q.norm();
        if !length.is_finite() || (length - 1.0).abs() > 1e-6 {
            let found = format!("{rotation:?} of length {length}");
            return Err(BadInput::new("registration rotation", "a unit quaternion w, x, y, z", found));
        }
        if translation.iter().any(|x| !x.is_finite()) {
            let found = format!("{translation:?}");
            return Err(BadInput::new("registration translation", "finite numbers", found));
        }
        Ok(Self { rotation: UnitQuaternion::new_normalize(q), translation: translation.into() })
    }

    /// Rotation as a unit quaternion w, x, y, z [-].
    pub fn rotation(&self) -> [f64; 4] {
        let q = self.rotation;
        [q.w, q.i, q.j, q.k]
    }

    /// Translation: where the tracker's origin is in the robot's frame [m].
    pub fn translation(&self) -> [f64; 3] {
        self.translation.into()
    }

    /// A point of the tracker's frame [m] in the robot's [m].
    pub fn apply_to_point(&self, in_tracker: [f64; 3]) -> [f64; 3] {
        (self.rotation * Vector3::from(in_tracker) + self.translation).into()
    }

    /// A pose of the tracker's frame in the robot's.
    pub fn apply(&self, pose: &Pose) -> Pose {
        let [w, x, y, z] = pose.orientation;
        let q = self.rotation.into_inner() * Quaternion::new(w, x, y, z);
        Pose { position: self.apply_to_point(pose.position), orientation: [q.w, q.i, q.j, q.k], ..*pose }
    }

    /// The rotation that turns the one into the other, and by how much [rad].
    pub fn angle_to(&self, other: &Self) -> f64 {
        self.rotation.angle_to(&other.rotation)
    }

    /// From the same points in both frames (n_points, n_points) [m], at least three. Also returns the root mean
    /// square distance that is left (fiducial registration error) [m].
    ///
    /// # Errors
    /// `BadInput` if the points lie on a line, differ in number or unit, or are mirrored.
    pub fn from_points(in_tracker: &[[f64; 3]], in_robot: &[[f64; 3]]) -> Result<(Self, f64), BadInput> {
        let place = "registration points";
        let n = in_tracker.len();
        if n != in_robot.len() || n < 3 {
            let found = format!("{n} and {}", in_robot.len());
            return Err(BadInput::new(place, "3 or more, as many in either frame", found));
        }
        let vectors = |points: &[[f64; 3]]| points.iter().map(|&p| Vector3::from(p)).collect::<Vec<_>>();
        let (mut p, mut q) = (vectors(in_tracker), vectors(in_robot));
        if let Some(i) = (0..n).find(|&i| !(p[i].norm_squared() + q[i].norm_squared()).is_finite()) {
            return Err(BadInput::new(format!("{place}: pair {}", i + 1), "finite numbers", "others"));
        }
        let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / n as f64;
        let (p_mean, q_mean) = (mean(&p), mean(&q));
        p.iter_mut().for_each(|p| *p -= p_mean);
        q.iter_mut().for_each(|q| *q -= q_mean);
        let (p_size, q_size) = (extents(&p), extents(&q));
        for (size, name) in [(p_size, "in the tracker's frame"), (q_size, "in the robot's frame")] {
            if size[1] <= FLAT * size[0] {
                let found = format!("{:.3} mm by {:.3} mm {name}", size[0] * 1e3, size[1] * 1e3);
                return Err(BadInput::new(place, "points that do not lie on a line", found)
                    .hint("add a point off the line through the others"));
            }
        }
        let ratio = p_size[0] / q_size[0];
        if !(1.0 / SCALE..=SCALE).contains(&ratio) {
            let expected = "points as far apart in one frame as in the other";
            return Err(BadInput::new(place, expected, format!("{ratio:.3} times as far in the tracker's"))
                .hint("check that both are given in the same unit, and in the same order"));
        }

        let fit = RotationFit::new(p.iter().zip(&q).map(|(p, q)| q * p.transpose()).sum());
        let left = |rotation: &Matrix3<f64>| {
            let squares = p.iter().zip(&q).map(|(p, q)| (q - rotation * p).norm_squared());
            (squares.sum::<f64>() / n as f64).sqrt()
        };
        let (error, mirrored) = (left(&fit.rotation), left(&fit.mirror));
        if p_size[2].min(q_size[2]) > THICK * p_size[0] && error > MIRROR * mirrored {
            let found = format!("a mirror image: {:.3} mm left, {:.3} as such", error * 1e3, mirrored * 1e3);
            return Err(BadInput::new(place, "points that a rotation brings together", found)
                .hint("check the signs of the axes, and that both frames are right-handed"));
        }
        if p_size[1] <= error {
            let found = format!("{:.3} mm left of {:.3} mm", error * 1e3, p_size[1] * 1e3);
            return Err(BadInput::new(place, "points that a rotation brings together", found)
                .hint("check the order of the points"));
        }
        Ok((fit.registration(p_mean, q_mean), error))
    }

    /// From motions of the tip, at least two in different directions, and the place of its rest in both frames [m].
    /// Also returns the root mean square angle that is left, each motion counted by its squared length [rad].
    ///
    /// # Errors
    /// `BadInput` if the motions are parallel, mirrored, or leave more than 15°.
    pub fn from_motions(
        motions: &[PulledMotion],
        rest_in_tracker: [f64; 3],
        rest_in_robot: [f64; 3],
    ) -> Result<(Self, f64), BadInput> {
        let place = "registration motions";
        let mut pairs = Vec::with_capacity(motions.len());
        for (i, motion) in motions.iter().enumerate() {
            let (p, q) = (Vector3::from(motion.in_tracker), Vector3::from(motion.in_robot));
            let usable = |length: f64| length > 0.0 && length.is_finite();
            if !(usable(p.norm()) && usable(q.norm())) {
                let found = format!("{:?} m and {:?}", motion.in_tracker, motion.in_robot);
                return Err(BadInput::new(format!("{place}: motion {}", i + 1), "a motion", found));
            }
            pairs.push((p, q.normalize()));
        }
        let (p, q): (Vec<_>, Vec<_>) = pairs.iter().map(|(p, q)| (p.normalize(), *q)).unzip();
        for (directions, name) in [(&p, "in the tracker's frame"), (&q, "in the robot's frame")] {
            let size = extents(directions);
            if size[1] <= FLAT * size[0] {
                let found = format!("{} parallel {name}", motions.len());
                return Err(BadInput::new(place, "motions in two directions or more", found)
                    .hint("pull tendons that bend the robot in different planes"));
            }
        }
        if [rest_in_tracker, rest_in_robot].iter().flatten().any(|x| !x.is_finite()) {
            return Err(BadInput::new("registration rest", "finite numbers", "others"));
        }

        // A length enters twice, since the noise of a direction falls with it: q |p| pᵀ.
        let fit = RotationFit::new(pairs.iter().map(|(p, q)| q * p.norm() * p.transpose()).sum());
        let total: f64 = pairs.iter().map(|(p, _)| p.norm_squared()).sum();
        let left = |rotation: &Matrix3<f64>| {
            let angles = pairs.iter().map(|(p, q)| p.norm_squared() * (rotation * p).angle(q).powi(2));
            (angles.sum::<f64>() / total).sqrt()
        };
        // Each pair alone, since a short motion can detect a mirror image as well as a long one.
        let worst =
            |rotation: &Matrix3<f64>| pairs.iter().map(|(p, q)| (rotation * p).angle(q)).fold(0.0, f64::max);
        let error = left(&fit.rotation);
        if worst(&fit.rotation) > std::f64::consts::FRAC_PI_2 && worst(&fit.mirror) < MAX_ANGLE {
            return Err(BadInput::new(place, "motions that a rotation explains", "a mirror image")
                .hint("the tendons may be numbered the other way round"));
        }
        if error > MAX_ANGLE || worst(&fit.rotation) > std::f64::consts::FRAC_PI_2 {
            let found = format!("{:.1} deg left", error.max(worst(&fit.rotation)).to_degrees());
            return Err(BadInput::new(place, "motions that a rotation explains within 15 deg", found)
                .hint("check which tendon is which, and that the robot moved freely"));
        }
        Ok((fit.registration(rest_in_tracker.into(), rest_in_robot.into()), error))
    }
}

/// The rotation R, and the best mirror image, that make tr(Rᵀ B) largest, B = Σ q pᵀ.
struct RotationFit {
    rotation: Matrix3<f64>,
    mirror: Matrix3<f64>,
}

impl RotationFit {
    /// # Reference
    /// Kabsch (1976); Markley (1988). B = U S Vᵀ gives R = U diag(1, 1, det U det V) Vᵀ.
    fn new(b: Matrix3<f64>) -> Self {
        let svd = b.svd(true, true);
        let (u, v_t) = match (svd.u, svd.v_t) {
            (Some(u), Some(v_t)) => (u, v_t),
            // Never: both were asked for.
            _ => (Matrix3::identity(), Matrix3::identity()),
        };
        let sign = (u.determinant() * v_t.determinant()).signum();
        let with = |last: f64| u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, last)) * v_t;
        Self { rotation: with(sign), mirror: with(-sign) }
    }

    /// With the translation that brings `p` to `q`.
    fn registration(&self, p: Vector3<f64>, q: Vector3<f64>) -> Registration {
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(self.rotation));
        let rotation = UnitQuaternion::new_normalize(rotation.into_inner());
        Registration { rotation, translation: q - rotation * p }
    }
}

/// Root mean square extents along the principal axes through the origin, largest first.
fn extents(vectors: &[Vector3<f64>]) -> [f64; 3] {
    let moment: Matrix3<f64> = vectors.iter().map(|v| v * v.transpose()).sum();
    let mut values: [f64; 3] = (moment / vectors.len().max(1) as f64).symmetric_eigenvalues().into();
    values.sort_by(|a, b| b.total_cmp(a));
    values.map(|value| value.max(0.0).sqrt())
}

#[cfg(test)]
mod tests;
