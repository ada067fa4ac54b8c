//! An elastic tendon through guides with friction: every guide has a memory of the tendon slid through it.
//!
//! Segment i lies between guides i and i+1 (guide 0 is the pulley, guide m the fixed distal end). With u_j the tendon that
//! has slid through guide j towards the pulley, its tension is T_i = k_i max(0, l_i - l0_i + u_i - u_{i+1}). A guide
//! sticks while |T_{j-1} - T_j| is below F + tanh(μθ_j/2)(T_{j-1} + T_j), otherwise the difference is that bound with the
//! sign of the slip. Given the statuses of all guides this is one tridiagonal system; the statuses come from an active
//! set that begins with the last ones, and from `policies.rs` where that cycles. Friction that gives way before it slides has
//! no statuses, but a share of its bound for every slip; Newton's method finds the slips (`sliding.rs`).

use crate::friction::capstan_factor;
use crate::policy::GuideChoices;
use crate::presliding::{FrictionLaw, GuideStrains};
use hysteron_base::BadInput;

/// Parameters of a tendon and its guides.
#[derive(Debug, Clone, PartialEq)]
pub struct TendonSpec {
    /// Length of each segment at rest, from the pulley to the distal end (n_segments) [m].
    pub rest_lengths: Vec<f64>,
    /// Axial stiffness E A [N].
    pub axial_stiffness: f64,
    /// Coefficient of friction μ at the guides [-].
    pub friction: f64,
    /// Friction of each guide without tension, F > 0: without it a slack tendon would have no definite place [N].
    pub friction_force: f64,
    /// How it approaches its bound.
    pub law: FrictionLaw,
}

/// Status of a guide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Guide {
    /// It holds the tendon.
    #[default]
    Sticks,
    /// The tendon slides towards the pulley.
    Pulls,
    /// The tendon slides towards the distal end.
    Releases,
}

/// A tendon and its memory.
#[derive(Debug, Clone, PartialEq)]
pub struct TendonModel {
    /// Its parameters.
    pub spec: TendonSpec,
    /// Stiffness of each segment (n_segments) [N/m].
    pub(crate) stiffness: Vec<f64>,
    /// Tendon slid through each guide towards the pulley, that at the pulley first and 0 at the distal end
    /// (n_segments + 1) [m].
    pub slips: Vec<f64>,
    /// Tension of each segment (n_segments) [N].
    pub tensions: Vec<f64>,
    /// Last status of each guide; the first and the last entry mean nothing (n_segments + 1).
    pub guides: Vec<Guide>,
    /// How far friction that gives way has been strained at each guide (n_segments + 1) [-].
    pub(crate) elements: Vec<GuideStrains>,
    /// Work done on the guides so far: heat, and the elastic energy of friction that gives way [J].
    pub dissipated: f64,
}

/// A state that a tendon would take, and scratch. Belongs to one tendon.
#[derive(Debug, Clone, Default)]
pub struct TendonTrial {
    /// As in [`TendonModel`].
    pub slips: Vec<f64>,
    /// As in [`TendonModel`].
    pub tensions: Vec<f64>,
    /// As in [`TendonModel`].
    pub guides: Vec<Guide>,
    /// ∂T/∂l for the present statuses (n_segments × n_segments, by rows), written by [`TendonTrial::tangent`] [N/m].
    pub tangent: Vec<f64>,
    /// Whether the last solution needed more than the simple active set.
    pub has_cycled: bool,
    pub(crate) is_taut: Vec<bool>,
    /// tanh(μθ/2) of each guide.
    pub(crate) factors: Vec<f64>,
    /// Factors of T_{j-1} and T_j in the row of guide j, zero where it sticks.
    pub(crate) row: Vec<[f64; 2]>,
    pub(crate) upper: Vec<f64>,
    /// 1 - upper, with 1 where nothing floats; the first one is that of the pulley.
    pub(crate) defect: Vec<f64>,
    pub(crate) pivot: Vec<f64>,
    pub(crate) right: Vec<f64>,
    pub(crate) policy: Vec<GuideChoices>,
    /// Slips at the beginning of an iteration, and how they change in it.
    pub(crate) start: Vec<f64>,
    pub(crate) change: Vec<f64>,
}

/// More active sets than any increment has needed by far.
const MAX_ACTIVE_SETS: usize = 10;
/// Rounding of a stretch over the lengths it comes from.
pub(crate) const ROUNDING: f64 = 1e-13;

impl TendonModel {
    /// A tendon at rest: no slip, no tension.
    ///
    /// # Errors
    /// `BadInput` naming the number that cannot be.
    pub fn new(spec: TendonSpec) -> Result<Self, BadInput> {
        let positive = |place: &str, x: f64| match x.is_finite() && x > 0.0 {
            true => Ok(()),
            false => Err(BadInput::new(place, "a finite number > 0", format!("{x:?}"))),
        };
        if spec.rest_lengths.len() < 2 {
            let found = format!("{} of them", spec.rest_lengths.len());
            return Err(BadInput::new("tendon.rest_lengths", "at least 2 segments", found));
        }
        for (i, &length) in spec.rest_lengths.iter().enumerate() {
            positive(&format!("tendon.rest_lengths[{i}]"), length)?;
        }
        positive("tendon.axial_stiffness", spec.axial_stiffness)?;
        positive("tendon.friction_force", spec.friction_force)
            .map_err(|bad| bad.hint("use a few millinewtons for a smooth guide"))?;
        if spec.law != FrictionLaw::Coulomb {
            positive("tendon.law", spec.law.presliding())?;
        }
        if !(spec.friction.is_finite() && spec.friction >= 0.0) {
            return Err(BadInput::new("tendon.friction", "a finite number >= 0", spec.friction.to_string()));
        }
        Ok(Self::of_valid(spec))
    }

    /// The same from numbers that are known to be valid, as those of a file that has been checked.
    pub fn of_valid(spec: TendonSpec) -> Self {
        let n = spec.rest_lengths.len();
        let stiffness = spec.rest_lengths.iter().map(|length| spec.axial_stiffness / length).collect();
        Self {
            spec,
            stiffness,
            slips: vec![0.0; n + 1],
            tensions: vec![0.0; n],
            guides: vec![Guide::Sticks; n + 1],
            elements: vec![GuideStrains::default(); n + 1],
            dissipated: 0.0,
        }
    }

    /// Number of segments.
    pub fn n_segments(&self) -> usize {
        self.stiffness.len()
    }

    /// A trial of this tendon, at its present state. The only allocation.
    pub fn trial(&self) -> TendonTrial {
        let n = self.n_segments();
        TendonTrial {
            slips: self.slips.clone(),
            tensions: self.tensions.clone(),
            guides: self.guides.clone(),
            tangent: vec![0.0; n * n],
            has_cycled: false,
            is_taut: self.tensions.iter().map(|&tension| tension > 0.0).collect(),
            factors: vec![0.0; n + 1],
            row: vec![[0.0; 2]; n + 1],
            upper: vec![0.0; n + 1],
            defect: vec![1.0; n + 1],
            pivot: vec![1.0; n + 1],
            right: vec![0.0; n + 1],
            policy: vec![GuideChoices::default(); n + 1],
            start: vec![0.0; n + 1],
            change: vec![0.0; n + 1],
        }
    }

    /// Makes `trial` the present state.
    pub fn commit(&mut self, trial: &TendonTrial) {
        for j in 1..self.n_segments() {
            let slip = trial.slips[j] - self.slips[j];
            self.dissipated += (trial.tensions[j - 1] - trial.tensions[j]) * slip;
            self.spec.law.strain(&mut self.elements[j], slip);
        }
        self.slips.copy_from_slice(&trial.slips);
        self.tensions.copy_from_slice(&trial.tensions);
        self.guides.copy_from_slice(&trial.guides);
    }

    /// Energy stored in the segments [J].
    pub fn stored_energy(&self) -> f64 {
        self.tensions.iter().zip(&self.stiffness).map(|(tension, k)| 0.5 * tension * tension / k).sum()
    }

    /// Tensions and slips for segments of `lengths` (n_segments) [m], guides that turn the tendon by `wraps`
    /// (n_segments + 1; first and last unused) [rad], and `stroke`, the tendon pulled at the pulley [m].
    /// Starts from the statuses in `trial` and measures slip from the present state.
    pub fn solve(&self, lengths: &[f64], wraps: &[f64], stroke: f64, trial: &mut TendonTrial) {
        let m = self.n_segments();
        for j in 1..m {
            trial.factors[j] = capstan_factor(self.spec.friction, wraps[j]);
        }
        trial.slips[0] = stroke;
        trial.slips[m] = 0.0;
        trial.has_cycled = false;
        if self.spec.law != FrictionLaw::Coulomb {
            self.solve_sliding(lengths, trial);
            return;
        }
        for round in 0..2 {
            for _ in 0..MAX_ACTIVE_SETS {
                self.solve_statuses(lengths, trial);
                if !self.update_statuses(lengths, trial) {
                    return;
                }
            }
            if round == 0 {
                trial.has_cycled = true;
                self.solve_by_policies(lengths, trial);
            }
        }
        // States equal to rounding: those of the policies are kept.
        self.solve_by_policies(lengths, trial);
    }

    /// l_i - l0_i + u_i - u_{i+1} [m].
    pub(crate) fn stretch(&self, lengths: &[f64], slips: &[f64], i: usize) -> f64 {
        lengths[i] - self.spec.rest_lengths[i] + slips[i] - slips[i + 1]
    }

    /// Coefficients of the row of guide j: a T_{j-1} - b T_j = f.
    pub(crate) fn demand(&self, guide: Guide, factor: f64) -> (f64, f64, f64) {
        match guide {
            Guide::Sticks => (0.0, 0.0, 0.0),
            Guide::Pulls => (1.0 - factor, 1.0 + factor, self.spec.friction_force),
            Guide::Releases => (1.0 + factor, 1.0 - factor, -self.spec.friction_force),
        }
    }

    /// Solves the tridiagonal system of the present statuses; keeps its factor for the tangent.
    fn solve_statuses(&self, lengths: &[f64], trial: &mut TendonTrial) {
        let m = self.n_segments();
        let k = |i: usize, is_taut: &[bool]| if is_taut[i] { self.stiffness[i] } else { 0.0 };
        for j in 1..m {
            let (a, b, f) = self.demand(trial.guides[j], trial.factors[j]);
            let (left, right) = (a * k(j - 1, &trial.is_taut), b * k(j, &trial.is_taut));
            // diagonal u_j - left u_{j-1} - right u_{j+1} = left c_{j-1} - right c_j - f
            let c = |i: usize| lengths[i] - self.spec.rest_lengths[i];
            // left + right - left upper_{j-1}, without its cancellation.
            let pivot = right + left * trial.defect[j - 1];
            if pivot > 0.0 {
                trial.row[j] = [left, right];
                trial.defect[j] = left * trial.defect[j - 1] / pivot;
                trial.pivot[j] = pivot;
                trial.upper[j] = right / pivot;
                let previous = if j == 1 { trial.slips[0] } else { trial.right[j - 1] };
                trial.right[j] = (left * (c(j - 1) + previous) - right * c(j) - f) / pivot;
            } else {
                // It sticks, or nothing taut touches it.
                trial.row[j] = [0.0; 2];
                trial.defect[j] = 1.0;
                trial.pivot[j] = 1.0;
                trial.upper[j] = 0.0;
                trial.right[j] = self.slips[j];
                trial.guides[j] = Guide::Sticks;
            }
        }
        for j in (1..m).rev() {
            trial.slips[j] = trial.right[j] + trial.upper[j] * trial.slips[j + 1];
        }
    }

    /// Sets tensions, and statuses as the last solution asks; whether any changed.
    fn update_statuses(&self, lengths: &[f64], trial: &mut TendonTrial) -> bool {
        let m = self.n_segments();
        let mut has_changed = false;
        for i in 0..m {
            let stretch = self.stretch(lengths, &trial.slips, i);
            let is_taut = stretch > 0.0;
            has_changed |= is_taut != trial.is_taut[i] && stretch.abs() > ROUNDING * lengths[i];
            trial.is_taut[i] = is_taut;
            trial.tensions[i] = if is_taut { self.stiffness[i] * stretch } else { 0.0 };
        }
        for j in 1..m {
            let factor = trial.factors[j];
            let (before, after) = (trial.tensions[j - 1], trial.tensions[j]);
            let slip = trial.slips[j] - self.slips[j];
            let rounding = ROUNDING * (lengths[j - 1] + lengths[j]);
            let next = match trial.guides[j] {
                Guide::Sticks => {
                    let bound = self.spec.friction_force + factor * (before + after);
                    let room = ROUNDING * self.spec.axial_stiffness;
                    match before - after {
                        difference if difference > bound + room => Guide::Pulls,
                        difference if -difference > bound + room => Guide::Releases,
                        _ => Guide::Sticks,
                    }
                }
                Guide::Pulls if slip < -rounding => Guide::Sticks,
                Guide::Releases if slip > rounding => Guide::Sticks,
                same => same,
            };
            has_changed |= next != trial.guides[j];
            trial.guides[j] = next;
        }
        has_changed
    }
}

impl TendonTrial {
    /// Writes ∂T/∂l for the present statuses, with the pulled length and the wrap angles held.
    ///
    /// `tendon` must be the one that was solved last with this trial. Not symmetric where guides slip.
    pub fn tangent(&mut self, tendon: &TendonModel) {
        let m = tendon.n_segments();
        for column in 0..m {
            // Change of each slip per length of segment `column`: the factor of `solve_statuses` again.
            for j in 1..m {
                let [left, right] = self.row[j];
                let own = if j == column + 1 { left } else { 0.0 } - if j == column { right } else { 0.0 };
                let previous = if j == 1 { 0.0 } else { left * self.right[j - 1] };
                self.right[j] = (own + previous) / self.pivot[j];
            }
            let mut after = 0.0;
            for i in (0..m).rev() {
                let before = if i == 0 { 0.0 } else { self.right[i] + self.upper[i] * after };
                let k = if self.is_taut[i] { tendon.stiffness[i] } else { 0.0 };
                let own = if i == column { 1.0 } else { 0.0 };
                self.tangent[i * m + column] = k * (own + before - after);
                after = before;
            }
        }
    }
}
