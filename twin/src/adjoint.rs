//! Exact derivatives of the tip at an equilibrium, by three adjoint solves.
//!
//! With K the exact tangent (the geometric stiffness of body and cables included), J and C of the cables h whose
//! stroke is held, and the weights p of one coordinate of the tip, the solution of
//!
//! [ K  -Jᵀ ] [z]   [p]
//! [-J  -C  ] [μ] = [0]
//!
//! gives the derivatives of that coordinate: by a stroke of a held cable -μ, a tension of another cable, strokes
//! held, its row times z. K is never assembled: along a direction it is the difference of the residual. The factor
//! of the step, which is older and leaves the geometric terms out, makes a preconditioner of the same form.

use hysteron_fem::vectors::axpy;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::equilibrium_residual::{EquilibriumResidual, StepTargets, move_nodes};
use crate::gmres::gmres;
use crate::model::Twin;
use crate::quasi_newton::QuasiNewton;
use crate::state::TwinState;

/// Residual that is left: a tenth of a per cent in the derivatives.
const ENOUGH: f64 = 1e-3;
/// Most directions of a solve with the factor in use, and with a new one: beyond a limit point the tangent has negative
/// eigenvalues, each of which takes some.
const MAX_DIRECTIONS: [usize; 2] = [24, 80];
/// Largest displacement of a difference, over the length of the body: truncation of 1e-9, round-off of 1e-10.
const DIFFERENCE: f64 = 1e-6;

/// Derivatives of one coordinate of the tip by all forces and strokes.
#[derive(Debug, Clone)]
pub(crate) struct TipAdjoint {
    /// Force on each free unknown (n_unknowns) [m/N].
    pub of_force: Vec<f64>,
    /// Stroke of each held cable (n_held) [-].
    pub of_stroke: Vec<f64>,
}

/// Solves for the three coordinates of the tip at the equilibrium `state` of `control`, the cables `held` keeping their
/// strokes and the others their tensions. `None` where two of them pull the same way, or without a solution.
pub(crate) fn tip_adjoints(
    twin: &Twin,
    control: &StepTargets,
    state: &TwinState,
    held: &[usize],
    quasi_newton: &mut QuasiNewton,
) -> Option<[TipAdjoint; 3]> {
    let mut balance = EquilibriumResidual::new(twin);
    balance.evaluate(twin, control, &state.positions, &state.tensions);
    for most in MAX_DIRECTIONS {
        quasi_newton.projection(twin, state, &balance)?;
        let mut system = System::new(twin, control, state, held, quasi_newton, balance.clone())?;
        let solved = [0, 1, 2].map(|c| system.adjoint(c, most));
        if let [Some(x), Some(y), Some(z)] = solved {
            return Some([x, y, z]);
        }
        quasi_newton.invalidate();
    }
    None
}

/// The system, and its preconditioner. Vectors hold the free unknowns, then the held cables times `unit`.
struct System<'a> {
    twin: &'a Twin,
    control: &'a StepTargets,
    state: &'a TwinState,
    held: &'a [usize],
    quasi_newton: &'a mut QuasiNewton,
    /// With the shape of the cables at `state`.
    balance: EquilibriumResidual,
    /// For differences.
    moved: EquilibriumResidual,
    /// W + C of the held cables, of the old factor.
    among: Cholesky<f64, Dyn>,
    /// Displacement per tension that makes both parts of a vector alike [m/N].
    unit: f64,
    length: f64,
}

impl<'a> System<'a> {
    fn new(
        twin: &'a Twin,
        control: &'a StepTargets,
        state: &'a TwinState,
        held: &'a [usize],
        quasi_newton: &'a mut QuasiNewton,
        balance: EquilibriumResidual,
    ) -> Option<Self> {
        let (projection, n) = (quasi_newton.last_projection(), twin.cables.len());
        let w = |a: usize, b: usize| projection.delassus[held[a] * n + held[b]];
        let among = DMatrix::from_fn(held.len(), held.len(), w).cholesky()?;
        let square = |j: &usize| projection.columns[*j].iter().map(|c| c * c).sum::<f64>();
        let unit = (held.iter().map(square).sum::<f64>() / held.len().max(1) as f64).sqrt();
        let unit = if unit > 0.0 { unit } else { 1.0 };
        let extent = |c: usize| {
            let along = twin.body.rest.iter().map(|node| node[c]);
            along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
        };
        let length = (0..3).map(extent).fold(0.0, f64::max);
        let moved = balance.clone();
        Some(Self { twin, control, state, held, quasi_newton, balance, moved, among, unit, length })
    }

    /// The solution for coordinate `c` of the tip; `None` where `most` directions are not enough.
    fn adjoint(&mut self, c: usize, most: usize) -> Option<TipAdjoint> {
        let right = self.precondition(self.twin.tip_weights(c), &vec![0.0; self.held.len()]);
        let (mut z, left) = gmres(self.twin.body.isa, &right, (ENOUGH, most), |v| self.apply(v));
        let of_stroke =
            z.split_off(self.twin.body.n_unknowns()).into_iter().map(|mu| -mu / self.unit).collect();
        (left <= ENOUGH).then_some(TipAdjoint { of_force: z, of_stroke })
    }

    /// The old solution for a force and strokes.
    fn precondition(&mut self, mut force: Vec<f64>, strokes: &[f64]) -> Vec<f64> {
        self.quasi_newton.solve(&mut force);
        let (cables, shape) = (&self.twin.cables, &self.balance.shape);
        let stroke_residual = DVector::from_fn(self.held.len(), |a, _| {
            -(strokes[a] + cables.row_times(shape, self.held[a], &force))
        });
        let tensions = self.among.solve(&stroke_residual);
        let projection = self.quasi_newton.last_projection();
        for (tension, &j) in tensions.iter().zip(self.held) {
            axpy(self.twin.body.isa, *tension, &projection.columns[j], &mut force);
        }
        force.extend(tensions.iter().map(|tension| self.unit * tension));
        force
    }

    /// The system, preconditioned, along a direction.
    fn apply(&mut self, v: &[f64]) -> Vec<f64> {
        let n = self.twin.body.n_unknowns();
        let (displacement, tensions) = v.split_at(n);
        let mut all = vec![0.0; self.twin.cables.len()];
        for (&j, tension) in self.held.iter().zip(tensions) {
            all[j] = tension / self.unit;
        }
        let mut force = self.stiffness_times(displacement);
        let (cables, shape) = (&self.twin.cables, &self.balance.shape);
        let mut nodal = vec![[0.0; 4]; self.state.positions.len()];
        cables.add_forces(shape, &all, &mut nodal);
        for (force, nodal) in force.as_chunks_mut::<3>().0.iter_mut().zip(&nodal) {
            for c in 0..3 {
                force[c] -= nodal[c];
            }
        }
        let stroke = |&j: &usize| -(cables.row_times(shape, j, displacement) + cables.stretch(j, &all));
        let strokes: Vec<f64> = self.held.iter().map(stroke).collect();
        self.precondition(force, &strokes)
    }

    /// K times a displacement, by a central difference of the residual.
    fn stiffness_times(&mut self, displacement: &[f64]) -> Vec<f64> {
        let longest = displacement.iter().fold(0.0f64, |max, d| max.max(d.abs()));
        if longest == 0.0 {
            return vec![0.0; displacement.len()];
        }
        let step = DIFFERENCE * self.length / longest;
        let mut positions = self.state.positions.clone();
        move_nodes(&mut positions, step, displacement);
        self.moved.evaluate(self.twin, self.control, &positions, &self.state.tensions);
        let mut change = self.moved.residual.clone();
        move_nodes(&mut positions, -2.0 * step, displacement);
        self.moved.evaluate(self.twin, self.control, &positions, &self.state.tensions);
        for (change, behind) in change.iter_mut().zip(&self.moved.residual) {
            *change = (*change - behind) / (2.0 * step);
        }
        change
    }
}

#[cfg(test)]
mod tests {
    use crate::friction_points::FrictionPoints;
    use crate::{Stepper, Target, Twin, TwinState, scenes};

    /// One per cent of the largest entry.
    const EXACT: f64 = 0.01;
    /// Change of a stroke in central differences [m]: a thousandth of the bend, so second order is 1e-6 of the
    /// derivative.
    const STEP: f64 = 2e-6;

    fn targets(strokes: &[f64]) -> Vec<Target> {
        strokes.iter().map(|stroke| Target::Stroke(*stroke)).collect()
    }

    /// The equilibrium under `strokes` after `from`.
    fn after(twin: &Twin, from: &TwinState, strokes: &[f64]) -> TwinState {
        let mut stepper = Stepper::new(twin);
        stepper.restore(twin, from).expect("a state of the twin");
        stepper.step(twin, &targets(strokes)).expect("an equilibrium");
        stepper.state().clone()
    }

    /// Error of ∂y/∂s at the equilibrium of `stepper`, over its largest entry, against tips brought to balance again.
    fn error(stepper: &mut Stepper, twin: &Twin, strokes: &[f64]) -> f64 {
        let found = stepper.tip_response(twin, FrictionPoints::AsTheyAre).expect("a tangent").per_stroke;
        let size = found.iter().flatten().fold(0.0f64, |size, value| size.max(value.abs()));
        let mut largest = 0.0f64;
        for k in 0..strokes.len() {
            let tip = |by: f64| {
                let mut moved = strokes.to_vec();
                moved[k] += by;
                twin.tip_of(&after(twin, stepper.state(), &moved))
            };
            let (ahead, behind) = (tip(STEP), tip(-STEP));
            for c in 0..3 {
                largest = largest.max(((ahead[c] - behind[c]) / (2.0 * STEP) - found[c][k]).abs() / size);
            }
        }
        assert!(largest > 0.0, "a difference that tests nothing");
        largest
    }

    /// Goes to `bend` and then fifty steps of 10 µm, without a new factor on the way; then back by `back`.
    fn fifty_steps(twin: &Twin, bend: [f64; 4], back: f64) -> (Stepper, Vec<f64>) {
        let mut stepper = Stepper::new(twin);
        let longest = bend.iter().fold(0.0f64, |longest, stroke| longest.max(stroke.abs()));
        let part = |part: f64| bend.map(|stroke| part * stroke).to_vec();
        for k in 1..=8 {
            stepper.step(twin, &targets(&part(f64::from(k) / 8.0))).expect("an equilibrium");
        }
        let mut refactorisations = 0;
        stepper.fast_iteration().disable_refactorisation();
        let mut strokes = part(1.0);
        for k in 1..=50 {
            strokes = part(1.0 + f64::from(k) * 1e-5 / longest);
            refactorisations +=
                stepper.step(twin, &targets(&strokes)).expect("an equilibrium").refactorisations;
        }
        assert_eq!(refactorisations, 0, "a new factor");
        if back > 0.0 {
            strokes.iter_mut().for_each(|stroke| *stroke -= back);
            stepper.step(twin, &targets(&strokes)).expect("an equilibrium");
        }
        (stepper, strokes)
    }

    #[test]
    fn derivatives_are_those_of_the_tip_at_strong_bends_with_an_old_factor() {
        let (mut scene, mesh) = scenes::robot();
        scene.tracker.turn = [0.1, -0.2, 0.3];
        for bend in [[1e-3, 0.5e-3, 0.2e-3, 0.3e-3], [4e-3, 1e-3, -3e-3, 1e-3], [6e-3, 3e-3, -8e-3, -4e-3]] {
            let twin = Twin::new(&scene, &mesh).expect("a good scene");
            let (mut stepper, strokes) = fifty_steps(&twin, bend, 0.0);
            let error = error(&mut stepper, &twin, &strokes);
            assert!(error < EXACT, "{bend:?}: {error:.1e}");
        }
    }

    #[test]
    fn where_friction_sticks_derivatives_are_those_of_what_sticks() {
        let (mut scene, mesh) = scenes::robot();
        scene.tendons.iter_mut().for_each(|tendon| tendon.compliance = 2e-4);
        scene.friction = Some(scenes::STUCK);
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let (mut stepper, strokes) = fifty_steps(&twin, [3e-3, 1e-3, -2e-3, 1e-3], 3e-5);
        let further: Vec<f64> = strokes.iter().map(|stroke| stroke - STEP).collect();
        let ahead = after(&twin, stepper.state(), &further);
        assert_eq!(ahead.slip, stepper.state().slip, "a point has slipped: what sticks is not tested");
        let error = error(&mut stepper, &twin, &strokes);
        assert!(error < EXACT, "{error:.1e}");
    }

    #[test]
    fn derivatives_of_a_chain_are_those_of_its_tip() {
        let (mut scene, mesh) =
            scenes::robot_with(hysteron_base::MaterialLaw::Corotational, hysteron_fem::Order::Linear, 24);
        scene.tracker.turn = [0.1, -0.2, 0.3];
        scene.tendons.iter_mut().for_each(|tendon| tendon.compliance = 2e-4);
        for friction in [None, Some(scenes::STUCK)] {
            scene.friction = friction;
            let twin = Twin::new(&scene, &mesh).expect("a good scene");
            let chain = crate::chain::Chain::new(&twin).expect("a chain");
            let twin = twin.with_chain(chain);
            let mut stepper = Stepper::new(&twin);
            let mut strokes = Vec::new();
            for k in 1..=20 {
                strokes = [3e-3, 1e-3, -2e-3, 1e-3].map(|stroke| f64::from(k) / 20.0 * stroke).to_vec();
                stepper.step(&twin, &targets(&strokes)).expect("an equilibrium");
            }
            strokes.iter_mut().for_each(|stroke| *stroke -= 3e-5);
            stepper.step(&twin, &targets(&strokes)).expect("an equilibrium");
            let error = error(&mut stepper, &twin, &strokes);
            assert!(error < EXACT, "{error:.1e}");
        }
    }
}
