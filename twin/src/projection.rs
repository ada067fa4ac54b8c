//! The stiffness projected onto the cables: Y = K⁻¹ Jᵀ and the Delassus operator W = J Y (eq. 2), to which the
//! cables' own compliance C is added.

use hysteron_fem::StiffnessFactor;

use crate::cable::{CableShape, Cables};

/// Y and W for the J and K of one moment.
#[derive(Debug, Clone)]
pub(crate) struct Projection {
    /// Displacement of the free unknowns per tension [m/N], one column per cable.
    pub columns: Vec<Vec<f64>>,
    /// W + C, row-major n × n, symmetric [m/N].
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
        for (i, row) in cables.compliance.iter().enumerate() {
            for &(j, compliance) in row {
                self.delassus[i * n + j] += compliance;
            }
        }
    }
}
