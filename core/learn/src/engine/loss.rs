//! Losses that more than one network is trained by.

/// Mean of some values; zero of none.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Mean squared error of outputs against targets (the same number each); writes its gradient.
///
/// # Panics
/// If the gradient has another length than the outputs.
pub fn mean_squared_error(found: &[f32], targets: &[f32], gradient: &mut [f32]) -> f64 {
    assert_eq!(found.len(), gradient.len(), "outputs and gradient");
    let scale = 1.0 / found.len() as f32;
    let mut squares = 0.0;
    for ((found, target), gradient) in found.iter().zip(targets).zip(gradient) {
        squares += f64::from((found - target).powi(2));
        *gradient = 2.0 * scale * (found - target);
    }
    squares * f64::from(scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradient_is_that_of_the_mean_of_squares() {
        let mut gradient = [0.0; 2];
        assert_eq!(mean_squared_error(&[1.0, 4.0], &[0.0, 2.0], &mut gradient), 2.5);
        assert_eq!(gradient, [1.0, 2.0]);
    }
}
