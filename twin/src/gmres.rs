//! Linear systems whose matrix is close to one that has a factor: minimal residuals over a Krylov space.
//!
//! Written here: a handful of directions, products that are differences of the residual, and the vectors of `base`; a crate
//! would bring its own matrix type for less than these lines.
//!
//! # Reference
//! Saad, Schultz (1986), GMRES: a generalized minimal residual algorithm for solving nonsymmetric linear systems,
//! SIAM J.
//! Sci. Stat. Comput. 7.

use hysteron_base::lanes::Isa;
use hysteron_fem::vectors::{axpy, dot};
use nalgebra::{DMatrix, DVector};

/// Part of a new direction that counts as nothing new: the space is complete.
const COMPLETE: f64 = 1e-8;

/// Solves A x = `right` from zero, A close to one, until the residual is `enough` of the right side or the space has
/// `most` directions. Returns x and the residual reached, over that of the right side [-].
pub(crate) fn gmres(
    isa: Isa,
    right: &[f64],
    (enough, most): (f64, usize),
    mut apply: impl FnMut(&[f64]) -> Vec<f64>,
) -> (Vec<f64>, f64) {
    let norm = |v: &[f64]| dot(isa, v, v).sqrt();
    let size = norm(right);
    let mut solution = vec![0.0; right.len()];
    if !(size > 0.0 && size.is_finite()) {
        return (solution, if size == 0.0 { 0.0 } else { f64::INFINITY });
    }
    let mut basis: Vec<Vec<f64>> = vec![right.iter().map(|c| c / size).collect()];
    let mut images: Vec<Vec<f64>> = Vec::new();
    let (mut weights, mut left) = (DVector::zeros(0), 1.0);
    while images.len() < most {
        let mut image = apply(&basis[basis.len() - 1]);
        images.push(image.clone());
        let gram = DMatrix::from_fn(images.len(), images.len(), |a, b| dot(isa, &images[a], &images[b]));
        let along = DVector::from_fn(images.len(), |a, _| dot(isa, &images[a], right));
        let Some(factor) = gram.cholesky() else { break };
        weights = factor.solve(&along);
        left = (1.0 - weights.dot(&along) / (size * size)).max(0.0).sqrt();
        if left <= enough {
            break;
        }
        for v in &basis {
            let along = dot(isa, &image, v);
            axpy(isa, -along, v, &mut image);
        }
        let rest = norm(&image);
        if rest < COMPLETE || !rest.is_finite() {
            break;
        }
        image.iter_mut().for_each(|c| *c /= rest);
        basis.push(image);
    }
    for (weight, v) in weights.iter().zip(&basis) {
        axpy(isa, *weight, v, &mut solution);
    }
    (solution, left)
}

#[cfg(test)]
mod tests {
    use super::gmres;
    use hysteron_base::lanes::Isa;
    use nalgebra::{DMatrix, DVector};
    use rand::RngExt;

    #[test]
    fn system_close_to_one_is_solved() {
        let (n, mut rng) = (40, hysteron_base::rng(1, "gmres"));
        let matrix =
            DMatrix::from_fn(n, n, |a, b| f64::from(u8::from(a == b)) + 0.05 * rng.random_range(-1.0..1.0));
        let right = DVector::from_fn(n, |_, _| rng.random_range(-1.0..1.0));
        let apply = |v: &[f64]| (&matrix * DVector::from_column_slice(v)).as_slice().to_vec();
        let (x, left) = gmres(Isa::detect(), right.as_slice(), (1e-6, 20), apply);
        let missed = (&matrix * DVector::from_vec(x) - &right).norm() / right.norm();
        // The residual is known from a difference of squares: half of the digits.
        assert!(missed < 1.1e-6 && (missed - left).abs() < 1e-7, "{missed:e} {left:e}");
        assert!(missed > 0.0, "a system that tests nothing");
    }
}
