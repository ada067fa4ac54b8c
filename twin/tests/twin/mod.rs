mod adapt;
mod anchor;
mod bad_input;
mod campaign;
mod chain;
mod command;
mod coreact;
mod delassus;
mod determinism;
mod elastica;
mod equilibrium;
mod fit;
mod fixed;
mod follower;
mod friction;
mod incompressible;
mod inverted;
mod layout;
mod limit;
mod locking;
mod reach;
mod ring;
mod scale;
pub mod scenes;
mod slack;
mod sliver;
mod state;
mod synthetic;
mod tendon;
mod tip_response;
mod work;

use hysteron_fem::Mesh;
use hysteron_twin::{ReachReport, Result, StepReport, Stepper, Target, TipGoal, Twin, TwinState};
use rand_chacha::ChaCha8Rng;

/// A tolerance, or zero when `TOL_SCALE=0` asks for the residuals.
pub fn tolerance(value: f64) -> f64 {
    let scale = std::env::var("TOL_SCALE").ok().and_then(|text| text.parse().ok()).unwrap_or(1.0);
    scale * value
}

/// Fails unless `found` and `expected` agree within `tol`.
#[track_caller]
pub fn assert_close(what: &str, found: f64, expected: f64, tol: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= tolerance(tol),
        "{what}: found {found:.12e}, expected {expected:.12e}: error {error:.2e} > {tol:.2e}"
    );
}

/// Distance of two points [m].
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

/// Stroke targets for all tendons.
pub fn strokes(values: &[f64]) -> Vec<Target> {
    values.iter().map(|stroke| Target::Stroke(*stroke)).collect()
}

/// Tension targets for all tendons.
pub fn tensions(values: &[f64]) -> Vec<Target> {
    values.iter().map(|tension| Target::Tension(*tension)).collect()
}

/// A robot, its solver and its present state.
pub struct Robot {
    pub twin: Twin,
    pub stepper: Stepper,
    pub state: TwinState,
}

impl Robot {
    pub fn new((scene, mesh): &(hysteron_base::Scene, Mesh)) -> Self {
        Self::of(Twin::new(scene, mesh).expect("a good scene"))
    }

    pub fn of(twin: Twin) -> Self {
        let (stepper, state) = (Stepper::new(&twin), twin.rest());
        Self { twin, stepper, state }
    }

    /// A step that must succeed and be as accurate as it reports.
    #[track_caller]
    pub fn go(&mut self, targets: &[Target]) -> StepReport {
        let report = self.try_step(targets).expect("an equilibrium");
        check_report(&self.twin, &report);
        report
    }

    /// A step from `state`, which a test may have set.
    pub fn try_step(&mut self, targets: &[Target]) -> Result<StepReport> {
        self.restore()?;
        let result = self.stepper.step(&self.twin, targets);
        self.state.clone_from(self.stepper.state());
        result
    }

    /// As [`Robot::try_step`], to a goal.
    pub fn reach(&mut self, goal: &TipGoal, targets: &[Target]) -> Result<ReachReport> {
        self.restore()?;
        let result = self.stepper.reach(&self.twin, goal, targets);
        self.state.clone_from(self.stepper.state());
        result
    }

    /// Puts the stepper where `state` is.
    pub fn restore(&mut self) -> Result<()> {
        if self.state == *self.stepper.state() {
            Ok(())
        } else {
            self.stepper.restore(&self.twin, &self.state)
        }
    }

    pub fn strokes(&self) -> Vec<f64> {
        self.twin.strokes_of(&self.state)
    }

    pub fn tip(&self) -> [f64; 3] {
        self.twin.tip_of(&self.state)
    }
}

/// A stepper at `state`.
pub fn stepper_at(twin: &Twin, state: &TwinState) -> Stepper {
    let mut stepper = Stepper::new(twin);
    stepper.restore(twin, state).expect("a state of the twin");
    stepper
}

/// The equilibrium under `targets` after `state`.
pub fn after(twin: &Twin, state: &TwinState, targets: &[Target]) -> TwinState {
    let mut stepper = stepper_at(twin, state);
    stepper.step(twin, targets).expect("an equilibrium");
    stepper.state().clone()
}

/// Every step that succeeds is as accurate as was asked.
#[track_caller]
pub fn check_report(twin: &Twin, report: &StepReport) {
    assert!(report.relative_residual <= twin.accuracy.relative_residual, "{report:?}");
    assert!(report.stroke_error <= twin.accuracy.stroke, "{report:?}");
}

/// Random numbers of one test; `SEED=2` asks for others.
pub fn rng(name: &str) -> ChaCha8Rng {
    let seed = std::env::var("SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    hysteron_base::rng(seed, name)
}
