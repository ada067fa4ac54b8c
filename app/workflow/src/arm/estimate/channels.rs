//! Channels of the estimates, and their values row by row.

use hysteron_arm_learning::neural::ContactEstimate;

/// Channels of the estimates, for `m` motors.
pub(super) fn names(m: usize) -> Vec<String> {
    let torques = (1..=m).map(|k| format!("torque_{k}_n_m"));
    let rest = ["force_x_n", "force_y_n", "force_z_n", "contact_ratio", "healthy_ratio"];
    torques.chain(rest.map(String::from)).collect()
}

/// Their values in that order.
pub(super) fn values<'a>(torque: &'a [f64], now: &ContactEstimate) -> impl Iterator<Item = f64> + use<'a> {
    let ContactEstimate { force: [x, y, z], gate, condition } = *now;
    torque.iter().copied().chain([x, y, z, gate, condition])
}
