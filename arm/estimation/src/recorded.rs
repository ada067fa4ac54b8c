//! Recordings of arms: the names of their channels, dynamics of every row, motions under recorded torques.
//!
//! Joint k (from 1, as in [`Model::joints`]) has `q_k_rad`, `dq_k_rad_s`, `ddq_k_rad_s2` and `tau_k_n_m`, or `q_k_m`, `dq_k_m_s`,
//! `ddq_k_m_s2` and `tau_k_n` where it slides.

use hysteron_base::{BadInput, Channel, Metadata, Recording};

use hysteron_arm_dynamics::{
    Data, EndStops, JointKind, Model, Simulator, coriolis_torque, forward_dynamics,
    forward_dynamics_derivatives, frame_jacobian, frame_pose, gravity_torque, inverse_dynamics,
    inverse_dynamics_derivatives, kinetic_energy, mass_matrix, potential_energy,
};

/// A quantity that every joint has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointQuantityKind {
    /// Coordinate.
    Position,
    /// Its rate.
    Velocity,
    /// The rate of that.
    Acceleration,
    /// Torque that drives the joint.
    Torque,
    /// The coordinate that its drive is asked for.
    Goal,
    /// Current of its motor.
    Current,
    /// Supply voltage of its drive.
    Voltage,
    /// Temperature of its motor.
    Temperature,
    /// Duty cycle of its motor, with sign.
    Pwm,
}

impl JointQuantityKind {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Position,
        Self::Velocity,
        Self::Acceleration,
        Self::Torque,
        Self::Goal,
        Self::Current,
        Self::Voltage,
        Self::Temperature,
        Self::Pwm,
    ];

    /// Name of the channel of joint number `joint` (from 0), if it is of this kind.
    pub fn channel(self, kind: JointKind, joint: usize) -> String {
        let [stem, unit] = self.spelled(kind);
        format!("{stem}_{}_{unit}", joint + 1)
    }

    fn spelled(self, kind: JointKind) -> [&'static str; 2] {
        match (self, kind) {
            (Self::Position, JointKind::Revolute) => ["q", "rad"],
            (Self::Position, JointKind::Prismatic) => ["q", "m"],
            (Self::Velocity, JointKind::Revolute) => ["dq", "rad_s"],
            (Self::Velocity, JointKind::Prismatic) => ["dq", "m_s"],
            (Self::Acceleration, JointKind::Revolute) => ["ddq", "rad_s2"],
            (Self::Acceleration, JointKind::Prismatic) => ["ddq", "m_s2"],
            (Self::Torque, kind) => ["tau", torque_unit(kind)],
            (Self::Goal, JointKind::Revolute) => ["goal", "rad"],
            (Self::Goal, JointKind::Prismatic) => ["goal", "m"],
            (Self::Current, _) => ["current", "a"],
            (Self::Voltage, _) => ["voltage", "v"],
            (Self::Temperature, _) => ["temperature", "degc"],
            (Self::Pwm, _) => ["pwm", "ratio"],
        }
    }
}

fn torque_unit(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Revolute => "n_m",
        JointKind::Prismatic => "n",
    }
}

/// Name of the channel of `quantity` of joint number `joint` (from 0).
pub fn channel_name(model: &Model, quantity: JointQuantityKind, joint: usize) -> String {
    quantity.channel(model.joints()[joint].kind, joint)
}

/// `quantity` of all joints, row by row (n_samples × n); `None` where the recording has it of no joint.
///
/// # Errors
/// `BadInput` where it has it of some joints only, or of more than the model has.
pub fn joint_rows(
    model: &Model,
    recording: &Recording,
    quantity: JointQuantityKind,
) -> Result<Option<Vec<f64>>, BadInput> {
    let n = model.n_joints();
    let names: Vec<String> = (0..n).map(|joint| channel_name(model, quantity, joint)).collect();
    if names.iter().all(|name| recording.channel(name).is_none()) {
        return Ok(None);
    }
    let columns: Vec<&[f64]> = names.iter().map(|name| recording.require(name)).collect::<Result<_, _>>()?;
    let next = quantity.channel(model.joints()[n - 1].kind, n);
    if recording.channel(&next).is_some() {
        let expected = format!("{n} joints, as \"{}\" has", model.name());
        return Err(BadInput::new(next, expected, "one more"));
    }
    Ok(Some(
        (0..recording.n_samples()).flat_map(|row| columns.iter().map(move |column| column[row])).collect(),
    ))
}

fn needed(model: &Model, recording: &Recording, quantity: JointQuantityKind) -> Result<Vec<f64>, BadInput> {
    joint_rows(model, recording, quantity)?
        .ok_or_else(|| BadInput::new(channel_name(model, quantity, 0), "this channel", "none"))
}

/// Columns of a table that is filled row by row.
struct DynamicsColumns {
    names: Vec<String>,
    values: Vec<Vec<f64>>,
}

impl DynamicsColumns {
    fn push(&mut self, row: &[f64]) {
        for (column, value) in self.values.iter_mut().zip(row) {
            column.push(*value);
        }
    }

    fn recording(self, of: &Recording, model: &Model, mut meta: Metadata) -> Result<Recording, BadInput> {
        let channels =
            self.names.into_iter().zip(self.values).map(|(name, values)| Channel::new(name, values));
        model.describe(&mut meta.extra);
        Recording::new(of.time().to_vec(), channels.collect(), of.gap().to_vec(), meta)
    }
}

/// Outputs of [`dynamics_of_rows`] in addition to torques or accelerations.
#[derive(Debug, Clone, Copy)]
pub struct DynamicsOutput {
    /// Frame whose position and Jacobian are wanted, by its number in [`Model::frames`].
    pub frame: usize,
    /// All derivatives too: of the torques by q and q̇ (M is that by q̈), or of the accelerations by q, q̇ and τ.
    pub derivatives: bool,
}

/// For every row of states: mass matrix, Coriolis torque, gravity with springs, viscous damping, torque or acceleration, pose and
/// Jacobian of a frame, energies. Torques are those of the drives: damping and springs of the joints are in them, dry friction is not.
///
/// `meta` is its provenance; the robot and its joints are added. `states` has coordinates and speeds of all joints, and accelerations (for inverse dynamics) or torques (for forward
/// dynamics).
///
/// # Errors
/// `BadInput` naming the channel that is missing, or the row whose result is not finite.
pub fn dynamics_of_rows(
    model: &Model,
    states: &Recording,
    DynamicsOutput { frame, derivatives }: DynamicsOutput,
    meta: Metadata,
) -> Result<Recording, BadInput> {
    let n = model.n_joints();
    let (q, dq) = (
        needed(model, states, JointQuantityKind::Position)?,
        needed(model, states, JointQuantityKind::Velocity)?,
    );
    let accelerations = joint_rows(model, states, JointQuantityKind::Acceleration)?;
    let torques = joint_rows(model, states, JointQuantityKind::Torque)?;
    let (input, is_inverse) = match (&accelerations, &torques) {
        (Some(rows), None) => (rows, true),
        (None, Some(rows)) => (rows, false),
        (found, _) => {
            let found = if found.is_some() { "both" } else { "neither" };
            let expected = "accelerations (ddq_1_rad_s2, …) or torques (tau_1_n_m, …)";
            return Err(BadInput::new("states", expected, found));
        }
    };
    let mut columns = table(model, is_inverse, derivatives);
    let mut data = Data::new(model, 0.0);
    let dampings: Vec<f64> = model.joints().iter().map(|joint| joint.drive.damping).collect();
    let (mut mass, mut jacobian) = (vec![0.0; n * n], vec![0.0; 6 * n]);
    let [mut by_q, mut by_dq, mut by_given] = [0; 3].map(|_| vec![0.0; n * n]);
    let [mut result, mut coriolis, mut gravity, mut damped, mut driving] = [0; 5].map(|_| vec![0.0; n]);
    let mut row = Vec::with_capacity(columns.names.len());
    for (s, ((q, dq), input)) in q.chunks(n).zip(dq.chunks(n)).zip(input.chunks(n)).enumerate() {
        damped.iter_mut().zip(dq.iter().zip(&dampings)).for_each(|(torque, (dq, d))| *torque = d * dq);
        if is_inverse {
            inverse_dynamics(model, &mut data, [q, dq, input], &[], &mut result);
            result.iter_mut().zip(&damped).for_each(|(tau, damped)| *tau += damped);
        } else {
            driving
                .iter_mut()
                .zip(input.iter().zip(&damped))
                .for_each(|(left, (tau, damped))| *left = tau - damped);
            forward_dynamics(model, &mut data, [q, dq, &driving], &[], &mut result);
        }
        let pose = frame_pose(model, &data, frame);
        frame_jacobian(model, &data, frame, &mut jacobian);
        mass_matrix(model, &mut data, q, &mut mass);
        coriolis_torque(model, &mut data, [q, dq], &mut coriolis);
        gravity_torque(model, &mut data, q, &mut gravity);
        row.clear();
        for part in [q, dq, input, &result, &coriolis, &gravity, &damped, &mass, &pose.position, &jacobian] {
            row.extend_from_slice(part);
        }
        row.push(kinetic_energy(model, &mut data, q, dq));
        row.push(potential_energy(model, &mut data, q));
        if derivatives {
            let by = [&mut by_q[..], &mut by_dq, &mut by_given];
            if is_inverse {
                inverse_dynamics_derivatives(model, &mut data, [q, dq, input], &[], by);
                dampings.iter().enumerate().for_each(|(j, d)| by_dq[n * j + j] += d);
                row.extend([&by_q, &by_dq].into_iter().flatten());
            } else {
                forward_dynamics_derivatives(model, &mut data, [q, dq, &driving], &[], &mut result, by);
                for (k, by_dq) in by_dq.iter_mut().enumerate() {
                    *by_dq -= by_given[k] * dampings[k % n];
                }
                row.extend([&by_q, &by_dq, &by_given].into_iter().flatten());
            }
        }
        if let Some(at) = row.iter().position(|x| !x.is_finite()) {
            let place = format!("row {}: {}", s + 1, columns.names[at]);
            return Err(BadInput::new(place, "a finite result", row[at].to_string())
                .hint("is a body without inertia, or a state far out of range?"));
        }
        columns.push(&row);
    }
    columns.recording(states, model, meta)
}

/// Number of columns of [`dynamics_of_rows`] for `n` joints, time and gaps included.
pub fn columns_of_dynamics(n: usize, derivatives: bool, is_inverse: bool) -> usize {
    let matrices = match (derivatives, is_inverse) {
        (false, _) => 1,
        (true, true) => 3,
        (true, false) => 4,
    };
    // q, q̇, the input and the result, Coriolis, gravity, damping; the Jacobian; position, energies, time, gaps.
    7 * n + matrices * n * n + 6 * n + 7
}

/// Names of the columns of [`dynamics_of_rows`].
fn table(model: &Model, is_inverse: bool, derivatives: bool) -> DynamicsColumns {
    let n = model.n_joints();
    let kind = |joint: usize| model.joints()[joint].kind;
    let (input, result) = match is_inverse {
        true => (JointQuantityKind::Acceleration, JointQuantityKind::Torque),
        false => (JointQuantityKind::Torque, JointQuantityKind::Acceleration),
    };
    let mut names = Vec::new();
    for quantity in [JointQuantityKind::Position, JointQuantityKind::Velocity, input, result] {
        names.extend((0..n).map(|joint| channel_name(model, quantity, joint)));
    }
    for stem in ["coriolis", "gravity", "damping"] {
        names.extend((0..n).map(|joint| format!("{stem}_{}_{}", joint + 1, torque_unit(kind(joint)))));
    }
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let unit = match (kind(i), kind(j)) {
            (JointKind::Revolute, JointKind::Revolute) => "kg_m2",
            (JointKind::Prismatic, JointKind::Prismatic) => "kg",
            _ => "kg_m",
        };
        names.push(format!("mass_{}_{}_{unit}", i + 1, j + 1));
    }
    names.extend(["x", "y", "z"].map(|axis| format!("frame_{axis}_m")));
    for (row, what) in ["vx", "vy", "vz", "wx", "wy", "wz"].iter().enumerate() {
        let unit = |joint| match (row < 3, kind(joint)) {
            (true, JointKind::Revolute) => "m",
            (false, JointKind::Prismatic) => "rad_per_m",
            _ => "ratio",
        };
        names.extend((0..n).map(|joint| format!("jacobian_{what}_{}_{}", joint + 1, unit(joint))));
    }
    names.extend(["kinetic_energy_j", "potential_energy_j"].map(str::to_owned));
    if derivatives {
        names.extend(derivative_names(model, is_inverse));
    }
    DynamicsColumns { values: vec![Vec::new(); names.len()], names }
}

/// As `tau_1_by_q_2_n_m_per_rad`: what the torque of joint 1 gains by the coordinate of joint 2.
fn derivative_names(model: &Model, is_inverse: bool) -> Vec<String> {
    let n = model.n_joints();
    let coordinate = |joint: usize| JointQuantityKind::Position.spelled(model.joints()[joint].kind)[1];
    let torque = |joint: usize| torque_unit(model.joints()[joint].kind);
    let name = |by: &str, i: usize, j: usize| match (is_inverse, by) {
        (true, "q") => format!("tau_{}_by_q_{}_{}_per_{}", i + 1, j + 1, torque(i), coordinate(j)),
        (true, _) => format!("tau_{}_by_dq_{}_{}_s_per_{}", i + 1, j + 1, torque(i), coordinate(j)),
        (false, "q") => format!("ddq_{}_by_q_{}_{}_s2_per_{}", i + 1, j + 1, coordinate(i), coordinate(j)),
        (false, "dq") => format!("ddq_{}_by_dq_{}_{}_s_per_{}", i + 1, j + 1, coordinate(i), coordinate(j)),
        (false, _) => format!("ddq_{}_by_tau_{}_{}_s2_per_{}", i + 1, j + 1, coordinate(i), torque(j)),
    };
    let by: &[&str] = if is_inverse { &["q", "dq"] } else { &["q", "dq", "tau"] };
    let pairs = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    by.iter().flat_map(|by| pairs().map(|(i, j)| name(by, i, j))).collect()
}

/// Motion from rest at `start` [rad or m] under recorded torques, each of which holds until the next row; dry friction,
/// damping and ends of ranges are those of the model. `meta` is its provenance; the robot and its joints are added.
///
/// # Errors
/// `BadInput` for a missing channel, a start that has not n finite numbers, or a motion that is not finite any more.
pub fn motion_under_torques(
    model: &Model,
    torques: &Recording,
    start: &[f64],
    substeps: usize,
    meta: Metadata,
) -> Result<Recording, BadInput> {
    let n = model.n_joints();
    if start.len() != n || start.iter().any(|q| !q.is_finite()) {
        return Err(BadInput::new("start", format!("{n} finite coordinates"), format!("{start:?}")));
    }
    let tau = needed(model, torques, JointQuantityKind::Torque)?;
    let mut names = Vec::new();
    for quantity in [JointQuantityKind::Position, JointQuantityKind::Velocity, JointQuantityKind::Torque] {
        names.extend((0..n).map(|joint| channel_name(model, quantity, joint)));
    }
    names.extend(["kinetic_energy_j", "potential_energy_j"].map(str::to_owned));
    let mut columns = DynamicsColumns { values: vec![Vec::new(); names.len()], names };
    let (mut q, mut dq, mut data) = (start.to_vec(), vec![0.0; n], Data::new(model, 0.0));
    let (time, mut last) = (torques.time(), 0.0);
    let mut simulator = None;
    for (s, tau) in tau.chunks(n).enumerate() {
        let energies = [kinetic_energy(model, &mut data, &q, &dq), potential_energy(model, &mut data, &q)];
        columns.push(&[&q[..], &dq, tau, &energies].concat());
        let Some(next) = time.get(s + 1) else { break };
        let period = next - time[s];
        // Rows of one rate keep their simulator.
        if simulator.is_none() || (period - last).abs() > 1e-9 * period {
            simulator = Some(Simulator::new(model, period, substeps, EndStops::Rigid));
            last = period;
        }
        if let Some(simulator) = &mut simulator {
            simulator.step([&mut q, &mut dq], tau, &[]);
        }
        if let Some(joint) = (0..n).find(|joint| !(q[*joint].is_finite() && dq[*joint].is_finite())) {
            let place = format!("row {}: joint {}", s + 1, model.joints()[joint].name);
            return Err(BadInput::new(place, "a motion that stays finite", "one that does not")
                .hint("more substeps, or smaller torques"));
        }
    }
    columns.recording(torques, model, meta)
}
