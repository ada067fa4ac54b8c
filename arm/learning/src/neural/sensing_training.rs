//! `SensingTask`: the network of labels as a task of the engine. Recorded samples alone, no simulation.

use hysteron_base::{BadInput, parallel, rng};
use hysteron_learn::{
    Adam, BlockKind, CardUpdates, Decay, DeviceCard, Penalty, Schedule, TapePool, TemporalForm, Training,
    TrainingTask, Transformer, TransformerShape, warm_up_cosine,
};
use rand::RngExt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::data::Trajectory;
use super::features::{FeatureLayout, InputScale};
use super::loss::{Heads, LossParts, LossWeights, Totals, length, sigmoid};
use super::observations::{IdentifiedArm, ObservedTrajectory, channels, floors, telemetry};
use super::supervised::Stretches;
use super::training::GROUP;
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::servo_force::BaselineObservers;

/// How the network of labels is trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensingOptions {
    /// Updates.
    pub updates: u64,
    /// Stretches of an update.
    pub stretches: usize,
    /// Samples of a stretch that count, after as many as fill the network's window.
    pub span: usize,
    /// Numbers of a token within the network.
    pub width: usize,
    /// Layers.
    pub layers: usize,
    /// Tokens that a layer looks back on, the current one among them.
    pub tokens: usize,
    /// Weights of the losses; those of poses do not count.
    pub loss: LossWeights,
    /// Full step size, and updates until it is reached.
    pub learning_rate: (f64, u64),
    /// Part of the moving average of the weights that each update replaces.
    pub ema: f32,
    /// Updates between two validations.
    pub epoch: u64,
    /// Of initial weights and batches.
    pub seed: u64,
}

impl SensingOptions {
    /// A small network that looks back for a second, trained for some minutes.
    pub fn small(updates: u64, contact: f64, seed: u64) -> Self {
        Self {
            updates,
            stretches: 32,
            span: 32,
            width: 32,
            layers: 2,
            tokens: 33,
            loss: LossWeights {
                force: 10.0,
                force_bend: 0.15,
                loaded: 3.0,
                gate: 3.0,
                condition: 3.0,
                contact,
                ..LossWeights::PUBLISHED
            },
            learning_rate: (2e-3, (updates / 10).clamp(1, 500)),
            ema: 5e-3,
            epoch: 100,
            seed,
        }
    }

    /// The network for these motors.
    pub fn shape(&self, features: &FeatureLayout) -> TransformerShape {
        TransformerShape {
            width: self.width,
            layers: self.layers,
            feed_forward: 2 * self.width,
            latent: self.width,
            tokens: self.tokens,
            block: BlockKind::GatedPreNorm,
            ..TransformerShape::published(
                channels(features),
                &Heads::sizes(features),
                TemporalForm::Streaming,
            )
        }
    }

    /// # Errors
    /// `BadInput` naming the option that is out of range.
    pub fn check(&self) -> Result<(), BadInput> {
        self.loss.check()?;
        let counts = [
            ("updates", self.updates, 10_000_000),
            ("stretches", self.stretches as u64, 4096),
            ("span", self.span as u64, 100_000),
            ("epoch", self.epoch, 1_000_000),
        ];
        match counts.into_iter().find(|(_, value, most)| !(1..=*most).contains(value)) {
            Some((name, value, most)) => Err(BadInput::new(name, format!("1 to {most}"), value.to_string())),
            None => Ok(()),
        }
    }
}

/// Momentum observers of the arm, identified on trajectories without contact at every sample and without a fault.
///
/// # Errors
/// `BadInput` where there is none, or where it has no PWM.
pub fn identified_observers(
    model: &Model,
    (features, period): (&FeatureLayout, f64),
    training: &[Trajectory],
) -> Result<BaselineObservers, BadInput> {
    let is_free = |one: &&Trajectory| {
        one.is_healthy != Some(false) && one.force.iter().all(|force| *force == Some([0.0; 3]))
    };
    let free: Vec<_> = training.iter().filter(is_free).collect();
    if free.is_empty() {
        let expected = "one or more without contact, with healthy motors";
        return Err(BadInput::new("training recordings", expected, "none")
            .hint("--free names the recordings without contact"));
    }
    let free = free.into_iter().map(|one| telemetry(features, period, one));
    BaselineObservers::identify(model, &free.collect::<Result<Vec<_>, _>>()?)
}

/// Training task of the network of labels: options, features and trajectories.
pub struct SensingTask<'a> {
    options: &'a SensingOptions,
    features: FeatureLayout,
    scale: InputScale,
    training: Vec<ObservedTrajectory<'a>>,
    validation: Vec<ObservedTrajectory<'a>>,
    /// Training trajectories by their labels: contacts, absence of contact, healthy and degraded motors; as many stretches from each.
    pools: Vec<Vec<usize>>,
    tapes: TapePool<f32>,
    /// Device that computes updates in place of the processor.
    card: Option<DeviceCard>,
}

impl<'a> SensingTask<'a> {
    /// From trajectories to train on, and others to keep the best weights by; `model` is an arm as `observed_arm` gives it.
    ///
    /// # Errors
    /// `BadInput` for an option out of range, recordings without PWM, or without any label.
    pub fn new(
        options: &'a SensingOptions,
        model: &Model,
        (features, known, period): (&FeatureLayout, &IdentifiedArm, f64),
        sets: [&'a [Trajectory]; 2],
    ) -> Result<Self, BadInput> {
        options.check()?;
        let observed = |set: &'a [Trajectory]| {
            let one = |one: &'a Trajectory| ObservedTrajectory::new(model, (features, known, period), one);
            parallel::try_map(set, one)
        };
        let (training, validation) = (observed(sets[0])?, observed(sets[1])?);
        let scale = InputScale::with_floors(
            &floors(features),
            training.iter().flat_map(|one| one.rows.chunks_exact(channels(features))),
        )?;
        let is_contact = |force: &Option<[f64; 3]>| force.is_some_and(|f| length(&f) > options.loss.contact);
        let of = |is: &dyn Fn(&Trajectory) -> bool| -> Vec<usize> {
            let long = |k: &usize| training[*k].trajectory.len() > options.span;
            (0..training.len()).filter(long).filter(|k| is(training[*k].trajectory)).collect()
        };
        let mut pools = vec![
            of(&|one| one.force.iter().any(is_contact)),
            of(&|one| one.force.iter().any(Option::is_some) && !one.force.iter().any(is_contact)),
        ];
        let degraded = of(&|one| one.is_healthy == Some(false));
        // One condition alone teaches nothing.
        if !degraded.is_empty() {
            pools.extend([of(&|one| one.is_healthy == Some(true)), degraded]);
        }
        pools.retain(|pool| !pool.is_empty());
        if pools.is_empty() {
            let expected = "labels of force or of a degraded motor";
            return Err(BadInput::new("training recordings", expected, "none"));
        }
        Ok(Self {
            options,
            features: *features,
            scale,
            training,
            validation,
            pools,
            tapes: TapePool::default(),
            card: None,
        })
    }

    /// Updates are computed on a card, where there is one.
    pub fn on(self, card: Option<DeviceCard>) -> Self {
        Self { card, ..self }
    }

    /// How the network's inputs are scaled.
    pub fn scale(&self) -> &InputScale {
        &self.scale
    }

    fn batch(&self, update: u64) -> LabelBatch<'_, 'a> {
        let mut stream = rng(self.options.seed, &format!("sensing/{update}"));
        let span = self.options.span;
        let stretches: Vec<(&ObservedTrajectory<'a>, usize)> = (0..self.options.stretches)
            .map(|k| {
                let pool = &self.pools[k % self.pools.len()];
                let one = &self.training[pool[stream.random_range(0..pool.len())]];
                (one, stream.random_range(0..one.trajectory.len() - span))
            })
            .collect();
        let rows = stretches.iter().map(|(one, start)| (one.trajectory, *start..start + span));
        let totals = Totals::of_rows(rows);
        LabelBatch { task: self, stretches, totals, heads: Heads::new(&self.features) }
    }

    /// Force and gate over all labelled samples of a trajectory, and its condition, with their numbers of samples.
    ///
    /// The condition counts by its squared error (Brier): by its cross-entropy, one trajectory of which the network is sure and wrong
    /// outweighs every force.
    fn losses(&self, network: &Transformer<f32>, observed: &ObservedTrajectory<'_>) -> (LossParts, Totals) {
        let trajectory = observed.trajectory;
        let sensed = super::sensing::outputs(network, &self.scale, observed);
        let heads = Heads::new(&self.features);
        let one = Totals { poses: 1.0, forces: 1.0, conditions: 1.0 };
        let (mut parts, mut brier) = (LossParts::default(), 0.0);
        let mut unused = vec![0.0; network.shape().outputs()];
        for (row, outputs) in sensed.chunks_exact(unused.len()).enumerate() {
            parts.add(&self.options.loss.labels((trajectory, row), &heads, outputs, &one, &mut unused));
            if let Some(is_healthy) = trajectory.is_healthy {
                brier += (sigmoid(outputs[heads.condition]) - f64::from(u8::from(is_healthy))).powi(2);
            }
        }
        parts.condition = self.options.loss.condition * brier;
        (parts, Totals::of_rows([(trajectory, 0..trajectory.len())].into_iter()))
    }
}

/// Batch of an update: stretches by their trajectories and first samples, and the divisors of their losses.
struct LabelBatch<'t, 'a> {
    task: &'t SensingTask<'a>,
    stretches: Vec<(&'t ObservedTrajectory<'a>, usize)>,
    totals: Totals,
    heads: Heads,
}

impl LabelBatch<'_, '_> {
    /// Writes the network's input of a stretch at a step to `to` (channels).
    fn token(&self, (one, start): (&ObservedTrajectory<'_>, usize), step: isize, to: &mut [f32]) {
        let own = one.row(start as isize + step);
        let scaled = own.iter().enumerate().map(|(k, x)| self.task.scale.at(k, *x).0 as f32);
        to.iter_mut().zip(scaled).for_each(|(to, x)| *to = x);
    }

    /// The loss by the outputs at a step of a stretch; adds its derivatives.
    fn loss(
        &self,
        (one, start): (&ObservedTrajectory<'_>, usize),
        step: usize,
        outputs: &mut [f64],
        by_outputs: &mut [f64],
    ) -> LossParts {
        one.complete(start + step, outputs);
        let at = (one.trajectory, start + step);
        let parts = self.task.options.loss.labels(at, &self.heads, outputs, &self.totals, by_outputs);
        one.turn_gradient(start + step, by_outputs);
        parts
    }

    /// One update by the fused passes.
    fn learn(&self, training: &mut Training<Transformer<f32>>) -> hysteron_learn::Result<f64> {
        let (network, span) = (training.model(), self.task.options.span);
        let found: Vec<_> = self
            .stretches
            .par_chunks(GROUP)
            .map(|group| {
                let mut gradient = self.task.tapes.zeros(network);
                let mut parts = LossParts::default();
                let token = |step: isize, row: usize, to: &mut [f32]| self.token(group[row], step, to);
                let weigh = |step: usize, row: usize, outputs: &mut [f64], by_outputs: &mut [f64]| {
                    parts.add(&self.loss(group[row], step, outputs, by_outputs));
                };
                let stretches = Stretches { shape: network.shape(), rows: group.len(), span };
                stretches.pass((network, &self.task.tapes), token, weigh, &mut gradient);
                (parts.sum(), gradient)
            })
            .collect();
        let loss = found.iter().map(|(loss, _)| loss).sum();
        let gradient = self.task.tapes.sum(found.into_iter().map(|(_, gradient)| gradient));
        training.update(loss, &gradient)?;
        self.task.tapes.give_back(gradient);
        Ok(loss)
    }

    /// The same on a card.
    fn learn_on(
        &self,
        updates: &mut CardUpdates,
        training: &Training<Transformer<f32>>,
    ) -> hysteron_learn::Result<f64> {
        let (shape, span) = (training.model().shape(), self.task.options.span);
        let mut parts = LossParts::default();
        let token = |step: isize, row: usize, to: &mut [f32]| self.token(self.stretches[row], step, to);
        let weigh = |step: usize, row: usize, outputs: &mut [f64], by_outputs: &mut [f64]| {
            parts.add(&self.loss(self.stretches[row], step, outputs, by_outputs));
        };
        let stretches = Stretches { shape, rows: self.stretches.len(), span };
        let by_outputs = stretches.pass_on_card(updates, token, weigh)?;
        let loss = parts.sum();
        updates.update(training, loss, &by_outputs)?;
        Ok(loss)
    }
}

impl TrainingTask<Transformer<f32>> for SensingTask<'_> {
    type Error = hysteron_learn::Error;

    fn schedule(&self) -> Schedule {
        let epochs = self.options.updates.div_ceil(self.options.epoch) as usize;
        let adam = Adam {
            learning_rate: self.options.learning_rate.0,
            weight_decay: 1e-3,
            penalty: Penalty::Decoupled,
            clip_norm: Some(1.0),
            ..Adam::default()
        };
        Schedule { epochs, patience: epochs, adam, decay: Decay::Cosine, ema: Some(self.options.ema) }
    }

    fn epoch(
        &mut self,
        training: &mut Training<Transformer<f32>>,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> hysteron_learn::Result<Option<f64>> {
        let (of, first) = (self.options.updates, training.steps());
        let n = self.options.epoch.min(of - first);
        let (full, warm_up) = self.options.learning_rate;
        let mut on_card = self.card.as_ref().map(|card| card.updates(training)).transpose()?;
        let mut sum = 0.0;
        for update in first..first + n {
            training.set_learning_rate(full * warm_up_cosine(update, warm_up, of));
            let batch = self.batch(update);
            sum += match &mut on_card {
                Some(updates) => batch.learn_on(updates, training)?,
                None => batch.learn(training)?,
            };
            if !on_step((update + 1 - first) as usize, n as usize) {
                return Ok(None);
            }
        }
        on_card.map_or(Ok(()), |updates| updates.finish(training))?;
        Ok(Some(sum / n.max(1) as f64))
    }

    /// The loss on whole validation trajectories; both conditions count the same.
    fn validate(&mut self, model: &Transformer<f32>) -> hysteron_learn::Result<f64> {
        let all = parallel::map(&self.validation, |one| self.losses(model, one));
        let (mut loss, mut forces, mut by_condition) = (0.0, 0.0, [[0.0; 2]; 2]);
        for (one, (parts, totals)) in self.validation.iter().zip(&all) {
            loss += parts.force + parts.gate;
            forces += one.trajectory.force.iter().flatten().count() as f64;
            if let Some(is_healthy) = one.trajectory.is_healthy {
                let own = &mut by_condition[usize::from(is_healthy)];
                own[0] += parts.condition;
                own[1] += totals.conditions;
            }
        }
        let condition = by_condition.iter().map(|[sum, n]| 0.5 * sum / n.max(1.0)).sum::<f64>();
        Ok(loss / f64::max(forces, 1.0) + condition)
    }
}
