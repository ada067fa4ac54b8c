//! Models of inverse dynamics: which terms each variant has, their shapes and their parameters.

use std::ops::Range;

use hysteron_base::BadInput;
use hysteron_learn::ridge::NormalEquations;
use hysteron_learn::{Activation, ByParameters, Float, Mlp};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::black_box::{BlackBoxHamiltonian, BlackBoxLagrangian, FeedForward};
use super::block::{BlockMotion, Coordinate, PositionFeatures, SampleBlock, Term};
use super::factor::packed;
use super::friction::{PER_JOINT, StribeckTerm};
use super::structured::{EnergyScales, EnergyShapes, StructuredHamiltonian, StructuredLagrangian};
use super::{ArmSamples, MAX_COLUMNS, MAX_JOINTS};

/// Joints whose numbers are multiplied, at most.
const MAX_DEGREE: usize = 4;
/// Samples side by side in a regression.
const BLOCK: usize = 256;
/// Of a regression on features, some of which can depend on others: little compared with its noise.
const REGRESSION_PENALTY: f64 = 1e-9;

/// A model of inverse dynamics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// Mass matrix and potential (DeLaN).
    StructuredLagrangian,
    /// One network for the Lagrangian.
    BlackBoxLagrangian,
    /// Inverse mass matrix and potential (HNN).
    StructuredHamiltonian,
    /// One network for the Hamiltonian.
    BlackBoxHamiltonian,
    /// One network for the torques (FF-NN).
    FeedForward,
    /// Structured Lagrangian and friction (6) (DeLaN-Friction).
    Friction,
    /// Structured Lagrangian and a network for what is left (8) (DeLaN-FFNN).
    Augmented,
}

impl Variant {
    /// In the order of table 5.
    pub const ALL: [Self; 7] = [
        Self::StructuredLagrangian,
        Self::BlackBoxLagrangian,
        Self::StructuredHamiltonian,
        Self::BlackBoxHamiltonian,
        Self::FeedForward,
        Self::Friction,
        Self::Augmented,
    ];

    /// As the tables call it.
    pub fn label(self) -> &'static str {
        match self {
            Self::StructuredLagrangian => "DeLaN, structured",
            Self::BlackBoxLagrangian => "DeLaN, black box",
            Self::StructuredHamiltonian => "HNN, structured",
            Self::BlackBoxHamiltonian => "HNN, black box",
            Self::FeedForward => "FF-NN",
            Self::Friction => "DeLaN-Friction",
            Self::Augmented => "DeLaN-FFNN",
        }
    }

    /// Whether it takes momenta instead of velocities, and predicts velocities too.
    pub fn is_hamiltonian(self) -> bool {
        matches!(self, Self::StructuredHamiltonian | Self::BlackBoxHamiltonian)
    }

    fn terms(self) -> &'static [TermKind] {
        match self {
            Self::StructuredLagrangian => &[TermKind::StructuredLagrangian],
            Self::BlackBoxLagrangian => &[TermKind::BlackBoxLagrangian],
            Self::StructuredHamiltonian => &[TermKind::StructuredHamiltonian],
            Self::BlackBoxHamiltonian => &[TermKind::BlackBoxHamiltonian],
            Self::FeedForward => &[TermKind::FeedForward],
            Self::Friction => &[TermKind::StructuredLagrangian, TermKind::Friction],
            Self::Augmented => &[TermKind::StructuredLagrangian, TermKind::FeedForward],
        }
    }
}

/// Kind of a term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TermKind {
    StructuredLagrangian,
    BlackBoxLagrangian,
    StructuredHamiltonian,
    BlackBoxHamiltonian,
    FeedForward,
    Friction,
}

/// In which units networks see motions and give torques.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Of q̇, or of p [rad/s or m/s, or their momenta].
    pub speeds: Vec<f64>,
    /// Of q̈.
    pub accelerations: Vec<f64>,
    /// Of τ [N m or N].
    pub torques: Vec<f64>,
    /// d_i of the Cholesky factor: √(σ_τ/σ_q̈), or its inverse for an inverse mass.
    pub factor: Vec<f64>,
    /// Of energies [J].
    pub energy: f64,
}

impl Scales {
    /// SI units: what is published.
    pub fn ones(n_joints: usize) -> Self {
        let ones = vec![1.0; n_joints];
        Self {
            speeds: ones.clone(),
            accelerations: ones.clone(),
            torques: ones.clone(),
            factor: ones,
            energy: 1.0,
        }
    }

    /// Standard deviations of these samples; with products as inputs the mean mass matrix gives the scale of its factor, for spreads make that much too
    /// large on an arm whose gravity is large compared with its inertia.
    pub fn of(samples: &ArmSamples, variant: Variant, inputs: InputForm) -> Self {
        let floor = |values: Vec<f64>| values.into_iter().map(|v| v.max(1e-9)).collect::<Vec<_>>();
        let torques = floor(samples.deviations(&samples.tau));
        let accelerations = floor(samples.deviations(&samples.ddq));
        let ratio = torques.iter().zip(&accelerations).map(|(t, a)| (t / a).sqrt());
        let (speeds, factor) = if variant.is_hamiltonian() {
            (floor(samples.deviations(&samples.momenta[0])), ratio.map(|d| 1.0 / d).collect())
        } else {
            (floor(samples.deviations(&samples.dq)), ratio.collect())
        };
        let energy = torques.iter().copied().fold(0.0, f64::max);
        let spreads = Self { speeds, accelerations, torques, factor, energy };
        match inputs {
            InputForm::SinesAndCosines => spreads,
            InputForm::Products(_) => spreads.with_mean_inertia(samples, variant, inputs),
        }
    }

    /// d_i = √h_ii, where h is the mean mass matrix: the slopes of τ on q̈ in a regression on q̈ and on the features of `inputs`, which take gravity away.
    /// A slope that is not positive leaves d_i as it was.
    fn with_mean_inertia(mut self, samples: &ArmSamples, variant: Variant, inputs: InputForm) -> Self {
        let n = samples.n_joints;
        let mut block = SampleBlock::<f64>::new(inputs.features(coordinates(&samples.lengths())));
        let width = 1 + block.n_features() + n;
        let mut sums = NormalEquations::new(width, n);
        let motion = [&samples.q[..], &samples.dq, &samples.ddq];
        let rows: Vec<usize> = (0..samples.len()).collect();
        let mut columns = Vec::new();
        for rows in rows.chunks(BLOCK) {
            block.gather(motion, rows.iter().copied());
            columns.clear();
            for (features, a) in block.features.chunks_exact(block.n_features()).zip(block.a.chunks_exact(n))
            {
                columns.push(1.0);
                columns.extend_from_slice(features);
                columns.extend_from_slice(a);
            }
            sums.add(&columns, &samples.tau[rows[0] * n..][..rows.len() * n]);
        }
        let weights = sums.solve(REGRESSION_PENALTY);
        for (i, d) in self.factor.iter_mut().enumerate() {
            let inertia = weights[(width - n + i) * n + i];
            if inertia > 0.0 {
                *d = if variant.is_hamiltonian() { inertia.sqrt().recip() } else { inertia.sqrt() };
            }
        }
        self
    }
}

/// Everything that fixes a model but its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkShape {
    /// Which terms it has.
    pub variant: Variant,
    /// Units of every hidden layer, the same in all networks.
    pub hidden: Vec<usize>,
    /// Between layers.
    pub activation: Activation,
    /// ε of (9), over d_i².
    pub epsilon: f64,
    /// Units.
    pub scales: Scales,
    /// For every joint: none for an angle, else the length that counts as one [m].
    pub lengths: Vec<Option<f64>>,
    /// Form of the positions as inputs of networks.
    #[serde(default)]
    pub inputs: InputForm,
    /// Dense columns of the mass matrix's factor next to its triangle: squares in the kinetic energy beyond
    /// one for each joint.
    #[serde(default)]
    pub squares: usize,
}

/// Form of the positions as inputs of networks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InputForm {
    /// sin q, cos q of every joint, as published.
    #[default]
    SinesAndCosines,
    /// Their products over up to so many joints too, and a linear path past the hidden layers. The potential of a chain of turning joints is
    /// a sum of such products, and so are the Jacobians of its bodies.
    Products(usize),
}

impl InputForm {
    /// Products over up to so many joints; sines and cosines alone of none.
    pub fn of(joints: usize) -> Self {
        if joints == 0 { Self::SinesAndCosines } else { Self::Products(joints) }
    }

    fn features(self, coordinates: Vec<Coordinate>) -> PositionFeatures {
        let degree = match self {
            Self::SinesAndCosines => 1,
            Self::Products(degree) => degree,
        };
        PositionFeatures::new(coordinates, degree)
    }
}

impl NetworkShape {
    /// # Errors
    /// `BadInput` for counts and numbers out of their ranges.
    pub fn check(&self) -> Result<(), BadInput> {
        let n = self.n_joints();
        if n == 0 || n > MAX_JOINTS {
            return Err(BadInput::new("network: joints", format!("1 to {MAX_JOINTS}"), n.to_string()));
        }
        if self.squares > MAX_COLUMNS - n {
            let expected = format!("0 to {} squares of {n} joints", MAX_COLUMNS - n);
            return Err(BadInput::new("network: squares", expected, self.squares.to_string()));
        }
        if !(self.epsilon > 0.0 && self.epsilon.is_finite()) {
            return Err(BadInput::new("network: epsilon", "a number > 0", self.epsilon.to_string()));
        }
        let scales = &self.scales;
        let sets = [&scales.speeds, &scales.accelerations, &scales.torques, &scales.factor];
        if sets.iter().any(|set| set.len() != n || set.iter().any(|v| !(*v > 0.0 && v.is_finite()))) {
            let found: Vec<String> = sets.iter().flat_map(|set| set.iter()).map(f64::to_string).collect();
            let expected = format!("4 times {n} numbers > 0");
            return Err(BadInput::new("network: scales", expected, found.join(", ")));
        }
        if let InputForm::Products(degree) = self.inputs
            && !(1..=MAX_DEGREE).contains(&degree)
        {
            let expected = format!("products over 1 to {MAX_DEGREE} joints");
            return Err(BadInput::new("network: inputs", expected, degree.to_string()));
        }
        self.mlp(self.features().len(), 1).check()
    }

    /// Joints.
    pub fn n_joints(&self) -> usize {
        self.lengths.len()
    }

    /// Outputs of a sample: torques, and the velocities of a Hamiltonian.
    pub fn n_outputs(&self) -> usize {
        if self.variant.is_hamiltonian() { 2 * self.n_joints() } else { self.n_joints() }
    }

    /// Parameters of all terms.
    pub fn n_parameters(&self) -> usize {
        self.layout().last().map_or(0, |(_, range)| range.end)
    }

    /// Parameters to begin with.
    pub fn initial_parameters(&self, seed: u64) -> Vec<f64> {
        let n = self.n_joints();
        // A small last layer: H begins as nearly diagonal and torques as nearly zero.
        let begin = |mlp: &Mlp, name: &str, gain: f64| {
            mlp.initial_parameters(seed, &format!("lagrangian/{name}"), gain)
        };
        let energies = || {
            let shapes = self.energies();
            [begin(&shapes.mass, "mass", 0.1), begin(&shapes.potential, "potential", 0.1)].concat()
        };
        let terms = self.layout().into_iter().map(|(kind, _)| match kind {
            TermKind::StructuredLagrangian | TermKind::StructuredHamiltonian => energies(),
            TermKind::BlackBoxLagrangian | TermKind::BlackBoxHamiltonian => {
                begin(&self.energy(), "energy", 1.0)
            }
            TermKind::FeedForward => begin(&self.torque(), "torque", 0.1),
            TermKind::Friction => [0.0, 0.0, 0.0, 0.0].repeat(n),
        });
        terms.collect::<Vec<_>>().concat()
    }

    pub(crate) fn features(&self) -> PositionFeatures {
        self.inputs.features(coordinates(&self.lengths))
    }

    fn mlp(&self, inputs: usize, outputs: usize) -> Mlp {
        let skip = self.inputs != InputForm::SinesAndCosines;
        Mlp { inputs, hidden: self.hidden.clone(), outputs, activation: self.activation, skip }
    }

    fn energies(&self) -> EnergyShapes {
        let features = self.features().len();
        EnergyShapes {
            mass: self.mlp(features, packed(self.n_joints(), self.squares)),
            potential: self.mlp(features, 1),
        }
    }

    /// Whether a network sees the products of every two momenta: with products of sines and cosines a Hamiltonian's does, for its kinetic
    /// energy ½ pᵀH⁻¹p is a sum of them times what depends on q alone.
    fn has_products_of_momenta(&self) -> bool {
        self.variant == Variant::BlackBoxHamiltonian && self.inputs != InputForm::SinesAndCosines
    }

    /// The network of a black box's energy: of the features and velocities or momenta.
    fn energy(&self) -> Mlp {
        let n = self.n_joints();
        let products = if self.has_products_of_momenta() { n * (n + 1) / 2 } else { 0 };
        self.mlp(self.features().len() + n + products, 1)
    }

    /// The network of torques: of the features, velocities and accelerations.
    fn torque(&self) -> Mlp {
        self.mlp(self.features().len() + 2 * self.n_joints(), self.n_joints())
    }

    /// Ranges of the parameters of every term.
    pub(crate) fn layout(&self) -> Vec<(TermKind, Range<usize>)> {
        let n = self.n_joints();
        let mut start = 0;
        self.variant
            .terms()
            .iter()
            .map(|kind| {
                let len = match kind {
                    TermKind::StructuredLagrangian | TermKind::StructuredHamiltonian => {
                        let shapes = self.energies();
                        shapes.mass.n_parameters() + shapes.potential.n_parameters()
                    }
                    TermKind::BlackBoxLagrangian | TermKind::BlackBoxHamiltonian => {
                        self.energy().n_parameters()
                    }
                    TermKind::FeedForward => self.torque().n_parameters(),
                    TermKind::Friction => PER_JOINT * n,
                };
                start += len;
                (*kind, start - len..start)
            })
            .collect()
    }

    fn energy_scales(&self) -> EnergyScales {
        let Scales { factor, energy, .. } = &self.scales;
        EnergyScales { factor: factor.clone(), potential: *energy, epsilon: self.epsilon }
    }

    /// The term of a structured Lagrangian.
    pub(crate) fn structured<T: Float>(&self) -> StructuredLagrangian<T> {
        StructuredLagrangian::new(&self.energies(), &self.energy_scales())
    }

    pub(crate) fn term<T: Float>(&self, kind: TermKind) -> Box<dyn Term<T>> {
        let Scales { speeds, accelerations, torques, energy, .. } = &self.scales;
        match kind {
            TermKind::StructuredLagrangian => Box::new(self.structured()),
            TermKind::StructuredHamiltonian => {
                Box::new(StructuredHamiltonian::new(&self.energies(), &self.energy_scales()))
            }
            TermKind::BlackBoxLagrangian => {
                Box::new(BlackBoxLagrangian::new(&self.energy(), speeds, *energy))
            }
            TermKind::BlackBoxHamiltonian => {
                let momenta = (&speeds[..], self.has_products_of_momenta());
                Box::new(BlackBoxHamiltonian::new(&self.energy(), momenta, *energy))
            }
            TermKind::FeedForward => {
                Box::new(FeedForward::new(&self.torque(), [speeds, accelerations, torques]))
            }
            TermKind::Friction => Box::new(StribeckTerm::new(speeds, torques)),
        }
    }
}

/// Form in which every joint's coordinate enters, from its standard deviation [m]; an angle where there is
/// none.
fn coordinates(lengths: &[Option<f64>]) -> Vec<Coordinate> {
    lengths.iter().map(|length| length.map_or(Coordinate::Angle, Coordinate::Length)).collect()
}

/// A term and the range of its parameters.
type PlacedTerm<T> = (TermKind, Range<usize>, Box<dyn Term<T>>);

/// Scratch with which one thread evaluates a model on blocks of samples.
pub(crate) struct Evaluator<T> {
    terms: Vec<PlacedTerm<T>>,
    pub block: SampleBlock<T>,
    /// Of every term, [row][output].
    pub parts: Vec<Vec<T>>,
    /// Their sum.
    pub outputs: Vec<T>,
    n_outputs: usize,
    w: Vec<T>,
}

/// Targets that predictions are compared with.
pub(crate) struct Targets<'a> {
    /// [sample][output]: torques, and velocities of a Hamiltonian.
    pub values: [&'a [f64]; 2],
    /// Of every squared error of an output.
    pub weights: &'a [f64],
    /// λ of (10).
    pub penalty: f64,
}

impl Targets<'_> {
    /// Calls `work` with every error of outputs ([row][output]) and its weight.
    fn errors<T: Float>(&self, n: usize, outputs: &[T], rows: &[usize], mut work: impl FnMut(f64, f64)) {
        for (outputs, row) in outputs.chunks_exact(self.weights.len()).zip(rows) {
            let kinds = outputs.chunks_exact(n).zip(self.values).zip(self.weights.chunks_exact(n));
            for ((outputs, values), weights) in kinds {
                let targets = &values[row * n..][..n];
                for ((y, target), weight) in outputs.iter().zip(targets).zip(weights) {
                    work(y.to_f64() - target, *weight);
                }
            }
        }
    }
}

impl<T: Float> Evaluator<T> {
    pub fn new(shape: &NetworkShape) -> Self {
        let terms: Vec<_> =
            shape.layout().into_iter().map(|(kind, range)| (kind, range, shape.term(kind))).collect();
        Self {
            parts: vec![Vec::new(); terms.len()],
            terms,
            block: SampleBlock::new(shape.features()),
            outputs: Vec::new(),
            n_outputs: shape.n_outputs(),
            w: Vec::new(),
        }
    }

    /// An evaluator of these parameters alone: faster where samples come one at a time.
    pub fn prepared(shape: &NetworkShape, parameters: &[T]) -> Self {
        let mut own = Self::new(shape);
        own.terms.iter_mut().for_each(|(_, range, term)| term.prepare(&parameters[range.clone()]));
        own
    }

    /// Outputs of these rows of a motion.
    pub fn evaluate<'a>(
        &mut self,
        parameters: &[T],
        motion: impl Into<BlockMotion<'a>>,
        rows: impl Iterator<Item = usize> + Clone,
    ) {
        self.block.gather(motion, rows);
        let len = self.block.n_rows * self.n_outputs;
        self.outputs.clear();
        self.outputs.resize(len, T::default());
        for ((_, range, term), part) in self.terms.iter_mut().zip(&mut self.parts) {
            part.resize(len, T::default());
            term.outputs(&parameters[range.clone()], &self.block, part);
            for (sum, v) in self.outputs.iter_mut().zip(&*part) {
                *sum += *v;
            }
        }
    }

    /// Whether a term is the network for what rigid bodies do not explain.
    pub fn kinds(&self) -> impl Iterator<Item = TermKind> {
        self.terms.iter().map(|(kind, ..)| *kind)
    }

    /// The gradient of `per_row` times the loss of these rows goes `into` one of all parameters; gives that part of the loss. Follows
    /// [`Evaluator::evaluate`] of the same rows.
    ///
    /// The loss of a row is Σ_j W_j (e_j² + λ ε̂_j²), (10).
    pub fn add_loss(
        &mut self,
        parameters: &[T],
        targets: &Targets<'_>,
        rows: &[usize],
        per_row: f64,
        mut into: ByParameters<'_, T>,
    ) -> f64 {
        let mut loss = 0.0;
        let w = &mut self.w;
        w.clear();
        targets.errors(self.block.n_joints, &self.outputs, rows, |error, weight| {
            loss += per_row * weight * error * error;
            w.push(T::of(2.0 * per_row * weight * error));
        });
        let is_augmented = self.terms.len() > 1 && targets.penalty > 0.0;
        for ((kind, range, term), part) in self.terms.iter_mut().zip(&self.parts) {
            let (parameters, into) = (&parameters[range.clone()], into.from(range.start));
            if is_augmented && *kind == TermKind::FeedForward {
                let weights = targets.weights.iter().cycle();
                let mut w = self.w.clone();
                for ((w, y), weight) in w.iter_mut().zip(part).zip(weights) {
                    loss += per_row * targets.penalty * weight * y.to_f64().powi(2);
                    *w += T::of(2.0 * per_row * targets.penalty * weight) * *y;
                }
                term.derivatives(parameters, &self.block, &w, into);
            } else {
                term.derivatives(parameters, &self.block, &self.w, into);
            }
        }
        loss
    }

    /// Σ_j W_j e_j² of these rows, which [`Evaluator::evaluate`] has been through.
    pub fn squared_error(&self, targets: &Targets<'_>, rows: &[usize]) -> f64 {
        let mut sum = 0.0;
        targets
            .errors(self.block.n_joints, &self.outputs, rows, |error, weight| sum += weight * error * error);
        sum
    }

    /// Residuals of a row: errors of outputs, and the penalised torques of the network for what rigid bodies do not explain.
    pub fn n_residuals(&self, penalty: f64) -> usize {
        self.n_outputs + if self.is_penalised(penalty) { self.block.n_joints } else { 0 }
    }

    fn is_penalised(&self, penalty: f64) -> bool {
        penalty > 0.0
            && self.terms.iter().any(|(kind, ..)| *kind == TermKind::FeedForward)
            && self.terms.len() > 1
    }

    /// Writes the derivatives of the residuals √W_j e_j, then √(λ W_j) ε̂_j, of every row: [row][residual][parameter]. Follows
    /// [`Evaluator::evaluate`] of the same rows.
    pub fn jacobian(&mut self, parameters: &[T], weights: &[f64], penalty: f64, jacobian: &mut [T]) {
        let (n, m) = (self.block.n_joints, self.n_outputs);
        let k = self.n_residuals(penalty);
        let width = parameters.len();
        jacobian.fill(T::default());
        self.w.resize(self.block.n_rows * m, T::default());
        for residual in 0..k {
            let is_error = residual < m;
            let j = if is_error { residual } else { residual - m };
            let factor = if is_error { weights[j] } else { penalty * weights[j] };
            self.w.fill(T::default());
            self.w.iter_mut().skip(j).step_by(m).for_each(|w| *w = T::of(factor.sqrt()));
            debug_assert!(is_error || m == n, "only models of torques are augmented");
            for (kind, range, term) in &mut self.terms {
                if is_error || *kind == TermKind::FeedForward {
                    let values = &mut jacobian[residual * width..];
                    let mut into = ByParameters::Rows { values, width: k * width, start: 0 };
                    term.derivatives(
                        &parameters[range.clone()],
                        &self.block,
                        &self.w,
                        into.from(range.start),
                    );
                }
            }
        }
    }
}
