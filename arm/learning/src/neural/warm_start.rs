//! The beginning of a training: torques by inverse dynamics of filtered poses, all samples at once and without a loop.

use hysteron_actuator::filter::LowPass;
use hysteron_base::BadInput;
use hysteron_learn::{Float, TapePool, TemporalForm, Transformer};

use super::data::Trajectory;
use super::features::InputScale;
use super::loss::{Heads, LossParts, LossWeights, Totals, huber};
use super::simulation::ArmSimulation;
use super::supervised::Stretches;
use hysteron_arm_dynamics::{Data, inverse_dynamics};

/// Rows of a trajectory that are learned from together.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch<'a> {
    pub trajectory: &'a Trajectory,
    /// Torques of all its rows (rows × m), where they are learned.
    pub torques: Option<&'a [f64]>,
    pub start: usize,
}

/// Weight of the torques' error [1/(N m)], and error up to which it counts by its square [N m].
const TORQUE: (f64, f64) = (20.0, 0.1);
/// Steps of the streaming form that count, after as many as it takes to fill its window.
pub(super) const SPAN: usize = 24;

/// Steps of a stretch that count.
pub(super) fn span(form: TemporalForm) -> usize {
    match form {
        TemporalForm::Window => 1,
        TemporalForm::Streaming => SPAN,
    }
}

/// The loss of some stretches with recorded inputs; adds its gradient. `n_torques` is how many torques there are over all stretches of
/// the update.
pub(super) fn gradient<T: Float>(
    (network, tapes): (&Transformer<T>, &TapePool<T>),
    (simulation, scale): (&ArmSimulation, &InputScale),
    stretches: &[Stretch<'_>],
    (weights, totals, n_torques): (&LossWeights, &Totals, f64),
    gradient: &mut [Vec<T>],
) -> (LossParts, f64) {
    let span = span(network.shape().form);
    let heads = Heads::new(simulation.features());
    let m = simulation.features().motors();
    let (mut parts, mut torque_loss) = (LossParts::default(), 0.0);
    let token = |step: isize, row: usize, to: &mut [T]| {
        let raw = stretches[row].trajectory.inputs_at(stretches[row].start as isize + step);
        to.iter_mut().zip(raw).enumerate().for_each(|(k, (to, x))| *to = T::of(scale.at(k, *x).0));
    };
    let weigh = |step: usize, row: usize, found: &mut [f64], by_outputs: &mut [f64]| {
        let stretch = &stretches[row];
        let sample = stretch.start + step;
        if let Some(torques) = stretch.torques.filter(|_| !stretch.trajectory.gap[sample]) {
            for k in 0..m {
                let limit = simulation.limit(k);
                let share = (found[k] / limit).tanh();
                let (value, slope) = huber(limit * share - torques[sample * m + k], TORQUE.1);
                torque_loss += TORQUE.0 / n_torques * value;
                by_outputs[k] += TORQUE.0 / n_torques * slope * (1.0 - share * share);
            }
        }
        parts.add(&weights.labels((stretch.trajectory, sample), &heads, found, totals, by_outputs));
    };
    let stretches = Stretches { shape: network.shape(), rows: stretches.len(), span };
    stretches.pass((network, tapes), token, weigh, gradient);
    (parts, torque_loss)
}

/// Torques that would have moved the simulated arm as recorded (rows × m) [N m], from poses filtered without delay below `cutoff`
/// [Hz]: what a network is first brought to.
///
/// # Errors
/// `BadInput` where the trajectory is too short for the filter, or the cut-off is not below half the rate.
pub fn torques_of(
    trajectory: &Trajectory,
    simulation: &ArmSimulation,
    cutoff: f64,
) -> Result<Vec<f64>, BadInput> {
    let features = simulation.features();
    let (m, n, rows) = (features.motors(), features.joints, trajectory.len());
    let options = simulation.options();
    let filter = LowPass::new(2, cutoff, 1.0 / options.period)?;
    let mut motion = [(); 3].map(|()| vec![0.0; rows * m]);
    for motor in 0..m {
        let measured: Vec<f64> = trajectory.states.iter().skip(motor).step_by(2 * m).copied().collect();
        let smooth = filter.zero_phase(&measured);
        for i in 0..rows {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(rows - 1));
            let span = (after - before) as f64 * options.period;
            motion[0][i * m + motor] = smooth[i];
            motion[1][i * m + motor] = (smooth[after] - smooth[before]) / span;
            let inner = i.clamp(1, rows - 2);
            motion[2][i * m + motor] = (smooth[inner + 1] - 2.0 * smooth[inner] + smooth[inner - 1])
                / (options.period * options.period);
        }
    }
    let mut data = Data::new(simulation.model(), 0.0);
    let mut torques = vec![0.0; rows * m];
    for (i, tau) in torques.chunks_exact_mut(m).enumerate() {
        let [q, dq, ddq] = [0, 1, 2].map(|k: usize| &motion[k][i * m..][..m]);
        inverse_dynamics(simulation.model(), &mut data, [&q[..n], &dq[..n], &ddq[..n]], &[], &mut tau[..n]);
        for k in 0..m {
            tau[k] += options.damping * dq[k];
            if k >= n {
                tau[k] += options.armature * ddq[k];
            }
            tau[k] = tau[k].clamp(-simulation.limit(k), simulation.limit(k));
        }
    }
    Ok(torques)
}
