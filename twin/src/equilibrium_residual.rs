//! The equations of a step: the residual of a configuration, and the targets of a command.

use hysteron_base::{Material, MaterialLaw};

use crate::cable::{CableShape, Cables};
use crate::model::{Target, Twin};

/// Targets of a step: for every cable a stroke, and the bounds of its tension. A prescribed tension is a pair
/// of equal bounds.
#[derive(Debug, Clone)]
pub(crate) struct StepTargets {
    pub strokes: Vec<f64>,
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
    /// Part of the constant loads that is applied.
    pub load: f64,
}

impl StepTargets {
    pub fn new(twin: &Twin, targets: &[Target]) -> Self {
        let n = twin.cables.len();
        let mut control = Self { strokes: vec![0.0; n], lower: vec![0.0; n], upper: vec![0.0; n], load: 1.0 };
        control.set(twin, targets);
        control
    }

    /// Replaces the targets of the tendons; those of friction points stay.
    pub fn set(&mut self, twin: &Twin, targets: &[Target]) {
        for (j, target) in targets.iter().enumerate() {
            let bounds = twin.tendons[j].tension;
            let (stroke, lower, upper) = match *target {
                Target::Stroke(stroke) => (stroke + twin.tendons[j].zero, bounds.min, bounds.max),
                Target::Tension(tension) => (0.0, tension, tension),
                Target::Free => {
                    let least = bounds.clamp(0.0);
                    (0.0, least, least)
                }
            };
            (self.strokes[j], self.lower[j], self.upper[j]) = (stroke, lower, upper);
        }
    }

    /// Replaces all by part `t` of the way between two others, a prescribed tension included; other bounds are those of `to`.
    pub fn set_part(&mut self, from: &Self, to: &Self, t: f64) {
        let mix = |a: f64, b: f64| a + t * (b - a);
        self.load = mix(from.load, to.load);
        for j in 0..to.strokes.len() {
            self.strokes[j] = mix(from.strokes[j], to.strokes[j]);
            (self.lower[j], self.upper[j]) = (to.lower[j], to.upper[j]);
            if to.is_tension(j) && t < 1.0 {
                self.lower[j] = mix(from.lower[j], to.lower[j]);
                self.upper[j] = self.lower[j];
            }
        }
    }

    /// Energy of cable `j` that stretches by `compliance` × T, with a missing stroke: the largest
    /// T × `missing` - ½ `compliance` T² over its tensions [J].
    pub fn stroke_penalty(&self, j: usize, stroke_residual: f64, compliance: f64, strongest: f64) -> f64 {
        let upper = self.upper[j].min(strongest.max(self.lower[j]));
        let lower = self.lower[j].max(-strongest.max(-self.upper[j]));
        if compliance > 0.0 {
            let tension = (stroke_residual / compliance).clamp(lower, upper);
            return tension * (stroke_residual - 0.5 * compliance * tension);
        }
        (lower * stroke_residual).max(upper * stroke_residual)
    }

    /// True where the tension, not the stroke, is prescribed.
    pub fn is_tension(&self, j: usize) -> bool {
        self.lower[j] == self.upper[j]
    }
}

/// Forces and strokes at some configuration; scratch.
#[derive(Debug, Clone)]
pub(crate) struct EquilibriumResidual {
    /// Internal forces [N], model order.
    internal: Vec<[f64; 4]>,
    /// Forces of cables and loads [N], model order.
    applied: Vec<[f64; 4]>,
    pub shape: CableShape,
    /// Internal minus applied forces on the free unknowns [N].
    pub residual: Vec<f64>,
    /// Norm of `residual` over that of the applied forces [-].
    pub relative: f64,
    /// Missing stroke of each cable, u - s - C T [m]; zero where the tension is prescribed.
    pub stroke_residual: Vec<f64>,
    /// Largest violated stroke condition [m].
    pub violation: f64,
    /// True if no element is inverted.
    pub is_upright: bool,
    /// Size of a section of the body, by its volume [m²].
    section: f64,
}

/// A residual is small when the forces of a mean strain of this size are.
const NEGLIGIBLE_STRAIN: f64 = 1e-7;
/// Mean strain whose forces are round-off: residuals at rest are 2e-16, at strong bending ten times more. Of the stiffest
/// mode: rounded positions change volumes too, and those forces grow with λ + 2 μ, beyond all bounds as ν nears 1/2.
const ROUND_OFF: f64 = 4e-15;

/// Stress below which forces count as none [Pa]: never so little that the accuracy asked for would be below round-off.
fn least_stress(material: &Material, relative_residual: f64) -> f64 {
    let Material { youngs_modulus, poisson_ratio, .. } = *material;
    // λ + 2 μ
    let wave_modulus =
        youngs_modulus * (1.0 - poisson_ratio) / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
    (NEGLIGIBLE_STRAIN * youngs_modulus).max(ROUND_OFF / relative_residual * wave_modulus)
}

/// Force below which forces on a twin's body count as none [N].
pub(crate) fn least_force(twin: &Twin) -> f64 {
    let volume: f64 = twin.body.nodal_volumes.iter().sum();
    // The accuracy asked for may change between steps.
    least_stress(&twin.body.material, twin.accuracy.relative_residual) * volume.powf(2.0 / 3.0)
}

impl EquilibriumResidual {
    pub fn new(twin: &Twin) -> Self {
        let body = &twin.body;
        let volume: f64 = body.nodal_volumes.iter().sum();
        Self {
            internal: vec![[0.0; 4]; body.n_nodes()],
            applied: vec![[0.0; 4]; body.n_nodes()],
            shape: twin.cables.shape(),
            residual: vec![0.0; body.n_unknowns()],
            relative: f64::INFINITY,
            stroke_residual: vec![0.0; twin.cables.len()],
            violation: f64::INFINITY,
            is_upright: true,
            section: volume.powf(2.0 / 3.0),
        }
    }

    /// Evaluates everything at nodes `x` and tensions `t`.
    pub fn evaluate(&mut self, twin: &Twin, control: &StepTargets, x: &[[f64; 4]], t: &[f64]) {
        self.is_upright = twin.body.internal_force_into(x, &mut self.internal);
        twin.cables.measure(x, &mut self.shape);
        for (applied, load) in self.applied.iter_mut().zip(&twin.loads) {
            *applied = load.map(|force| control.load * force);
        }
        for couple in &twin.couples {
            couple.add_forces(x, control.load, &mut self.applied);
        }
        twin.cables.add_forces(&self.shape, t, &mut self.applied);
        let (mut out_of_balance, mut applied) = (0.0, 0.0);
        let free = self.internal.iter().zip(&self.applied);
        for (residual, (inner, outer)) in self.residual.as_chunks_mut::<3>().0.iter_mut().zip(free) {
            for c in 0..3 {
                residual[c] = inner[c] - outer[c];
                out_of_balance += residual[c] * residual[c];
                applied += outer[c] * outer[c];
            }
        }
        // The accuracy asked for may change between steps.
        let least = least_stress(&twin.body.material, twin.accuracy.relative_residual) * self.section;
        self.relative = out_of_balance.sqrt() / applied.sqrt().max(least);
        self.violation = compare_strokes(&twin.cables, control, &self.shape, t, &mut self.stroke_residual);
    }

    /// Measures the cables only, at nodes `x`.
    pub fn evaluate_strokes(&mut self, twin: &Twin, control: &StepTargets, x: &[[f64; 4]], t: &[f64]) {
        twin.cables.measure(x, &mut self.shape);
        self.violation = compare_strokes(&twin.cables, control, &self.shape, t, &mut self.stroke_residual);
    }

    /// Potential energy of body, loads and cables at nodes `x`, for which strokes were evaluated [J], each
    /// cable as a stroke penalty that slips at its bounds: sup T (u - s) - ½ c T² over the tensions it can
    /// have, at most `strongest`. Its minimisers are the stable equilibria. `None` where forces have no
    /// potential, and with friction, where the cables of a tendon stretch together.
    pub fn potential(
        &self,
        twin: &Twin,
        control: &StepTargets,
        x: &[[f64; 4]],
        strongest: f64,
    ) -> Option<f64> {
        let has_no_potential =
            twin.body.material.law == MaterialLaw::CorotationalEdges || !twin.couples.is_empty();
        if has_no_potential || !twin.friction.is_empty() {
            return None;
        }
        let mut energy = twin.body.energy(x);
        for (node, load) in x.iter().zip(&twin.loads) {
            for c in 0..3 {
                energy -= control.load * load[c] * node[c];
            }
        }
        let stroke_residual =
            control.strokes.iter().zip(&self.shape.strokes).map(|(asked, stroke)| asked - stroke);
        let compliance = |j| twin.cables.own_compliance(j);
        let penalty =
            |(j, stroke_residual)| control.stroke_penalty(j, stroke_residual, compliance(j), strongest);
        Some(energy + stroke_residual.enumerate().map(penalty).sum::<f64>())
    }

    /// True at an equilibrium: forces and strokes meet the accuracy asked for, and no element is inverted.
    pub fn is_met(&self, twin: &Twin) -> bool {
        self.is_upright && self.is_balanced(twin)
    }

    /// True when forces and strokes meet the accuracy asked for, be elements inverted or not.
    pub fn is_balanced(&self, twin: &Twin) -> bool {
        self.relative <= twin.accuracy.relative_residual && self.violation <= twin.accuracy.stroke
    }

    /// True when all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.relative.is_finite() && !self.violation.is_nan()
    }
}

/// Writes the missing stroke of each cable, u - s - C T [m], zero where the tension is prescribed; returns the largest violated
/// stroke condition [m].
pub(crate) fn compare_strokes(
    cables: &Cables,
    control: &StepTargets,
    shape: &CableShape,
    t: &[f64],
    residuals: &mut [f64],
) -> f64 {
    let mut violation = 0.0;
    for j in 0..t.len() {
        if control.is_tension(j) {
            residuals[j] = 0.0;
            // A prescribed tension is a condition on T itself, met once the bounds are.
            if t[j] != control.lower[j] {
                violation = f64::INFINITY;
            }
            continue;
        }
        let stroke_residual = control.strokes[j] - shape.strokes[j] - cables.stretch(j, t);
        residuals[j] = stroke_residual;
        let slack = t[j] <= control.lower[j] && stroke_residual <= 0.0;
        let slips = t[j] >= control.upper[j] && stroke_residual >= 0.0;
        let violated = if slack || slips { 0.0 } else { stroke_residual.abs() };
        // NaN must not pass as zero, and stays.
        if violated > violation || violated.is_nan() {
            violation = violated;
        }
    }
    violation
}

/// x += factor × displacement of the free unknowns.
pub(crate) fn move_nodes(x: &mut [[f64; 4]], factor: f64, displacement: &[f64]) {
    for (node, moved) in x.iter_mut().zip(displacement.as_chunks::<3>().0) {
        for c in 0..3 {
            node[c] += factor * moved[c];
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::scenes;

    #[test]
    fn residual_is_gradient_of_potential() {
        let (mut scene, mesh) = scenes::robot();
        scene.gravity = [1.0, 2.0, -3.0];
        scene.tendons[3].compliance = 1e-3;
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        // Pulled, released, driven by tension: as far off, each cable has the tension of its side. The last stretches.
        let targets =
            [Target::Stroke(2e-3), Target::Stroke(-2e-3), Target::Tension(1.5), Target::Stroke(1e-3)];
        let control = StepTargets::new(&twin, &targets);
        let (strongest, mut tensions) = (3.0, [3.0, 0.0, 1.5, 0.0]);
        let mut rng = hysteron_base::rng(1, "potential");
        let mut x = twin.body.rest.clone();
        for node in &mut x[..twin.body.n_free] {
            for c in 0..3 {
                node[c] += rng.random_range(-1e-4..1e-4);
            }
        }
        let direction: Vec<f64> = (0..twin.body.n_unknowns()).map(|_| rng.random_range(-1.0..1.0)).collect();
        let mut balance = EquilibriumResidual::new(&twin);
        balance.evaluate_strokes(&twin, &control, &x, &tensions);
        tensions[3] = balance.stroke_residual[3] / twin.tendons[3].compliance;
        assert!(tensions[3] > 0.1 && tensions[3] < strongest, "{tensions:?}");
        // Central differences: third derivatives are those over element sizes of 3 mm, (h / 3 mm)² = 1e-7;
        // round-off of 0.1 J over 2 h is 1e-11 N.
        let h = 1e-6;
        let mut potential = |factor: f64| {
            let mut x = x.clone();
            move_nodes(&mut x, factor, &direction);
            balance.evaluate(&twin, &control, &x, &tensions);
            balance.potential(&twin, &control, &x, strongest).expect("a potential")
        };
        let difference = (potential(h) - potential(-h)) / (2.0 * h);
        balance.evaluate(&twin, &control, &x, &tensions);
        let analytic: f64 = balance.residual.iter().zip(&direction).map(|(r, d)| r * d).sum();
        let error = (difference - analytic).abs();
        assert!(error < 1e-5 * analytic.abs(), "{difference} and {analytic}");
        assert!(error > 0.0 && analytic.abs() > 1.0, "a difference that tests nothing");
    }

    #[test]
    fn slack_that_is_not_a_number_is_no_slack() {
        let (scene, mesh) = scenes::robot();
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let control = StepTargets::new(&twin, &[Target::Stroke(-1e-3); 4]);
        let mut balance = EquilibriumResidual::new(&twin);
        let mut x = twin.body.rest.clone();
        balance.evaluate_strokes(&twin, &control, &x, &[0.0; 4]);
        assert_eq!(balance.violation, 0.0);
        // Only the first cable's points.
        for node in x.iter_mut().filter(|node| node[0] > 4e-3) {
            node[2] = f64::NAN;
        }
        balance.evaluate_strokes(&twin, &control, &x, &[0.0; 4]);
        assert!(balance.violation.is_nan() && !balance.is_finite() && !balance.is_met(&twin));
    }
}
