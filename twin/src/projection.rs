//! The stiffness projected onto the cables: Y = K⁻¹ Jᵀ and the Delassus operator W = J Y (eq. 2).

use hysteron_fem::StiffnessFactor;

use crate::cable::{CableShape, Cables};

/// Y and W for the J and K of one moment.
#[derive(Debug, Clone)]
pub(crate) struct Projection {
    /// Displacement of the free unknowns per tension [m/N], one column per cable.
    pub columns: Vec<Vec<f64>>,
    /// W, row-major n × n, symmetric [m/N].
    pub delassus: Vec<f64>,
}

impl Projection {
    pub fn new(n_unknowns: usize, n_cables: usize) -> Self {
        Self { columns: vec![vec![0.0; n_unknowns]; n_cables], delassus: vec![0.0; n_cables * n_cables] }
    }

    /// Recomputes both.
    pub fn update(&mut self, cables: &Cables, shape: &CableShape, factor: &mut StiffnessFactor) {
        for (j, column) in self.columns.iter_mut().enumerate() {
            cables.row_into(shape, j, column);
        }
        factor.solve_many(&mut self.columns);
        let n = cables.len();
        for i in 0..n {
            for j in 0..=i {
                let w = cables.row_times(shape, i, &self.columns[j]);
                self.delassus[i * n + j] = w;
                self.delassus[j * n + i] = w;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::balance::{Balance, Control};
    use crate::newton::Newton;
    use crate::{Stepper, Target, Twin, TwinState, scenes};

    /// Change of tension in central differences [N]. Their error is of second order: a tendon of 1 N bends
    /// the body by 0.1 rad, so the relative error is about (0.1 × 1e-3)².
    const STEP: f64 = 1e-3;
    /// Relative to the largest entry; a step's residual of 1e-12 of 2 N over `STEP` adds 2e-9.
    const COMPLIANCE_ERROR: f64 = 1e-6;

    fn twin() -> Twin {
        let (mut scene, mesh) = scenes::robot();
        scene.solver.relative_residual = 1e-12;
        for tendon in &mut scene.tendons {
            tendon.tension.min = -100.0;
        }
        Twin::new(&scene, &mesh).expect("a good scene")
    }

    fn equilibrium(twin: &Twin, tensions: &[f64]) -> TwinState {
        let targets: Vec<Target> = tensions.iter().map(|t| Target::Tension(*t)).collect();
        let mut state = twin.rest();
        Stepper::new(twin).step(twin, &targets, &mut state).expect("an equilibrium");
        state
    }

    /// W of the exact tangent at a state.
    fn delassus(twin: &Twin, state: &TwinState) -> Vec<f64> {
        let targets = vec![Target::Free; twin.tendons.len()];
        let mut balance = Balance::new(twin);
        balance.evaluate(twin, &Control::new(twin, &targets), &state.positions, &state.tensions);
        let mut newton = Newton::new(twin);
        assert!(newton.linearise(twin, state, &balance));
        newton.projection.delassus
    }

    fn check_against_differences(tensions: [f64; 4]) -> f64 {
        let twin = twin();
        let w = delassus(&twin, &equilibrium(&twin, &tensions));
        let size = w.iter().fold(0.0f64, |max, w| max.max(w.abs()));
        let mut largest = 0.0f64;
        for j in 0..4 {
            let strokes = |step: f64| {
                let mut tensions = tensions;
                tensions[j] += step;
                twin.strokes_of(&equilibrium(&twin, &tensions))
            };
            let (ahead, behind) = (strokes(STEP), strokes(-STEP));
            for i in 0..4 {
                let difference = (ahead[i] - behind[i]) / (2.0 * STEP);
                largest = largest.max((difference - w[4 * i + j]).abs() / size);
            }
        }
        println!("Delassus at {tensions:?}: relative error {largest:.1e}");
        assert!(largest < COMPLIANCE_ERROR, "{largest}");
        assert!(largest > 0.0, "a difference that tests nothing");
        largest
    }

    #[test]
    fn delassus_is_compliance_at_rest() {
        check_against_differences([0.0; 4]);
    }

    #[test]
    fn delassus_is_compliance_of_bent_body() {
        check_against_differences([3.0, 1.0, 0.2, 0.5]);
    }

    #[test]
    fn delassus_is_symmetric_and_semidefinite() {
        let twin = twin();
        for tensions in [[0.0; 4], [3.0, 1.0, 0.2, 0.5]] {
            let w = nalgebra::DMatrix::from_row_slice(4, 4, &delassus(&twin, &equilibrium(&twin, &tensions)));
            assert_eq!(w, w.transpose());
            let eigenvalues = w.symmetric_eigenvalues();
            assert!(eigenvalues.min() > 0.0, "{eigenvalues}");
            // Pulling two opposite tendons only shortens the body, which is far stiffer than bending it.
            assert!(eigenvalues.max() > 10.0 * eigenvalues.min(), "{eigenvalues}");
        }
    }

    #[test]
    fn delassus_of_parallel_tendons_is_singular() {
        let (mut scene, mesh) = scenes::robot();
        scene.tendons[1] = hysteron_base::Tendon { name: "twice".into(), ..scene.tendons[0].clone() };
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let w = nalgebra::DMatrix::from_row_slice(4, 4, &delassus(&twin, &twin.rest()));
        let eigenvalues = w.symmetric_eigenvalues();
        // Round-off of the factor, relative.
        assert!(eigenvalues.min().abs() < 1e-10 * eigenvalues.max(), "{eigenvalues}");
    }
}
