//! The bodies of the arm: Newton and Euler's equations in the frame of the base, projected by Kane's partial velocities.
//!
//! For body i with centre c_i, joint j ≤ i turns it about a_j through o_j: ∂v_i/∂q̇_j = a_j × (c_i − o_j), ∂ω_i/∂q̇_j = a_j. Then
//! M_jk = Σ_i m_i ∂v_i/∂q̇_j · ∂v_i/∂q̇_k + a_j · I_i a_k, and the bias is what Newton's and Euler's equations ask for without
//! joint accelerations. No spatial algebra and no recursion over forces: `hysteron-arm-dynamics` has those.
//!
//! # Reference
//! Kane, Levinson (1985), Dynamics: Theory and Applications, chapter 6.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// Joints of the arm, without the gripper.
pub const N_JOINTS: usize = 4;

/// A rigid body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmBody {
    /// [kg].
    pub mass: f64,
    /// Centre of mass in the frame of its link [m].
    pub centre: Vector3<f64>,
    /// Moments about the centre, in the axes of its link [kg m²].
    pub inertia: Matrix3<f64>,
}

/// A revolute joint and the link that it moves. At zero all links have the axes of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmLink {
    /// Where the joint is in the frame of the link before [m].
    pub origin: Vector3<f64>,
    /// Axis of rotation, of length 1 [-].
    pub axis: Unit<Vector3<f64>>,
    /// Least and greatest angle [rad].
    pub range: [f64; 2],
    /// Body that it moves.
    pub body: ArmBody,
}

/// The bodies of an arm.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyChain {
    /// From the base outwards.
    pub links: [ArmLink; N_JOINTS],
    /// Where forces act and payloads are held, in the frame of the last link [m].
    pub tip: Vector3<f64>,
    /// [m/s²].
    pub gravity: Vector3<f64>,
}

/// The arm at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Configuration {
    /// M [kg m²].
    pub mass: [[f64; N_JOINTS]; N_JOINTS],
    /// Torques of a motion without acceleration: C q̇ + g [N m].
    pub bias: [f64; N_JOINTS],
    /// Tip in the frame of the base [m].
    pub tip: Vector3<f64>,
    /// ∂tip/∂q, one for each joint [m].
    pub tip_rates: [Vector3<f64>; N_JOINTS],
    /// Kinetic and potential energy [J].
    pub energy: [f64; 2],
}

impl ArmBody {
    /// A cube of uniform density.
    pub fn cube(mass: f64, side: f64, centre: Vector3<f64>) -> Self {
        Self { mass, centre, inertia: Matrix3::identity() * (mass * side * side / 6.0) }
    }

    /// Both bodies as one.
    pub fn with(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        let centre = (self.centre * self.mass + other.centre * other.mass) / mass;
        let moved = |body: &Self| {
            let d = body.centre - centre;
            body.inertia + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * body.mass
        };
        Self { mass, centre, inertia: moved(self) + moved(other) }
    }
}

impl BodyChain {
    /// The same with another body on the last link.
    pub fn with_payload(&self, payload: &ArmBody) -> Self {
        let mut all = self.clone();
        let last = &mut all.links[N_JOINTS - 1].body;
        *last = last.with(payload);
        all
    }

    /// Equations of motion at `q` [rad] and `dq` [rad/s].
    pub fn at(&self, q: &[f64; N_JOINTS], dq: &[f64; N_JOINTS]) -> Configuration {
        let mut turned = Matrix3::identity();
        let (mut place, mut before) = (Vector3::zeros(), Vector3::zeros());
        let (mut spin, mut spin_rate) = (Vector3::zeros(), Vector3::zeros());
        // An arm that falls freely feels no gravity: the base accelerates upwards instead.
        let mut acceleration = -self.gravity;
        let mut velocity = Vector3::zeros();
        let mut axes = [Vector3::zeros(); N_JOINTS];
        let mut origins = [Vector3::zeros(); N_JOINTS];
        let mut mass = [[0.0; N_JOINTS]; N_JOINTS];
        let mut bias = [0.0; N_JOINTS];
        let mut energy = [0.0; 2];
        for (i, link) in self.links.iter().enumerate() {
            let arm = turned * link.origin;
            place = before + arm;
            velocity += spin.cross(&arm);
            acceleration += spin_rate.cross(&arm) + spin.cross(&spin.cross(&arm));
            let axis = turned * link.axis.into_inner();
            (axes[i], origins[i]) = (axis, place);
            spin_rate += spin.cross(&axis) * dq[i];
            spin += axis * dq[i];
            turned *= Rotation3::from_axis_angle(&link.axis, q[i]).into_inner();
            let body = &link.body;
            let to_centre = turned * body.centre;
            let centre = place + to_centre;
            let inertia = turned * body.inertia * turned.transpose();
            let turning = spin.cross(&to_centre);
            let centre_velocity = velocity + turning;
            let force = (acceleration + spin_rate.cross(&to_centre) + spin.cross(&turning)) * body.mass;
            let momentum = inertia * spin;
            let moment = inertia * spin_rate + spin.cross(&momentum);
            energy[0] += 0.5 * (body.mass * centre_velocity.norm_squared() + spin.dot(&momentum));
            energy[1] -= body.mass * self.gravity.dot(&centre);
            let mut rates = [Vector3::zeros(); N_JOINTS];
            for j in 0..=i {
                rates[j] = axes[j].cross(&(centre - origins[j]));
                bias[j] += rates[j].dot(&force) + axes[j].dot(&moment);
                let turned_axis = inertia * axes[j];
                for k in 0..=j {
                    mass[j][k] += body.mass * rates[j].dot(&rates[k]) + turned_axis.dot(&axes[k]);
                }
            }
            before = place;
        }
        for j in 0..N_JOINTS {
            for k in 0..j {
                mass[k][j] = mass[j][k];
            }
        }
        let tip = place + turned * self.tip;
        let tip_rates = std::array::from_fn(|j| axes[j].cross(&(tip - origins[j])));
        Configuration { mass, bias, tip, tip_rates, energy }
    }
}

impl Configuration {
    /// Jᵀ F: what a force at the tip does to the joints [N m].
    pub fn torques_of(&self, force: &Vector3<f64>) -> [f64; N_JOINTS] {
        self.tip_rates.map(|rate| rate.dot(force))
    }

    /// Velocity of the tip [m/s].
    pub fn tip_velocity(&self, dq: &[f64; N_JOINTS]) -> Vector3<f64> {
        self.tip_rates.iter().zip(dq).map(|(rate, dq)| rate * *dq).sum()
    }
}
