//! Published results on recorded sets, for comparison with those measured here.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use hysteron_arm_learning::lagrangian::Variant;

/// A row of a published table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PublishedRow {
    /// Name of the model in the paper.
    pub name: Cow<'static, str>,
    /// Mean squared error of every joint [N² m²].
    pub mse: [f64; 7],
    /// (11), about one mean of all joints.
    pub pooled_r2: f64,
}

const fn row(name: &'static str, mse: [f64; 7], pooled_r2: f64) -> PublishedRow {
    PublishedRow { name: Cow::Borrowed(name), mse, pooled_r2 }
}

static HELICAL: [PublishedRow; 5] = [
    row("DeLaN, structured", [0.45, 0.96, 0.20, 1.0, 0.016, 0.021, 0.012], 0.990),
    row("DeLaN, black box", [3.1, 3.2, 1.3, 2.0, 0.023, 0.026, 1.4e-3], 0.964),
    row("FF-NN", [0.19, 0.25, 0.10, 0.061, 6.3e-3, 8.8e-3, 4.3e-4], 0.998),
    row("DeLaN-Friction", [0.42, 0.86, 0.18, 0.87, 0.016, 0.021, 0.012], 0.991),
    row("DeLaN-FFNN", [0.19, 0.22, 0.098, 0.069, 6.1e-3, 8e-3, 5e-4], 0.998),
];

// The R² of the first two are exchanged in print, as follows from their errors.
static CIRCLE_XY: [PublishedRow; 5] = [
    row("DeLaN, structured", [0.44, 1.1, 0.29, 1.3, 0.017, 0.015, 8.4e-3], 0.986),
    row("DeLaN, black box", [4.2, 2.0, 2.3, 1.9, 0.010, 0.016, 3e-3], 0.953),
    row("FF-NN", [0.20, 0.39, 0.14, 0.039, 5.2e-3, 5.3e-3, 6e-4], 0.996),
    row("DeLaN-Friction", [0.36, 0.80, 0.20, 1.4, 0.016, 0.012, 8.3e-3], 0.987),
    row("DeLaN-FFNN", [0.20, 0.33, 0.15, 0.040, 5.7e-3, 5.2e-3, 7.4e-4], 0.997),
];

/// Tables 3 and 4 on the set of this name; nothing where the paper has no such set. Its models of table 4
/// have a spiral file in their training too, which is not public.
///
/// # Reference
/// Li, Wu, Chen, Sun (2025), Physics-informed neural networks for compliant robotic manipulators dynamic modeling.
pub fn published(set: &str) -> &'static [PublishedRow] {
    match set {
        "Baxter, circle_XY_T2_r10" => &CIRCLE_XY,
        "Baxter, sin_XYZ_12_5s_T2_5_Tz_5T_r18" => &HELICAL,
        _ => &[],
    }
}

/// Table 5: normalised errors of torque, inertial, Coriolis and gravity torques of a simulated arm whose parameters are not printed.
///
/// # Reference
/// Li, Wu, Chen, Sun (2025), as [`published`].
pub fn published_parts(variant: Variant) -> [f64; 4] {
    match variant {
        Variant::StructuredLagrangian => [4.35e-7, 1.97e-6, 1.04e-5, 2.06e-7],
        Variant::BlackBoxLagrangian => [3.91e-3, 2.55e-3, 0.138, 9.99e-6],
        Variant::StructuredHamiltonian => [1.59e-6, 1.92e-4, 3.58e-4, 6.34e-7],
        Variant::BlackBoxHamiltonian => [1.99e-3, 0.680, 0.896, 1.01e-4],
        Variant::FeedForward => [5.46e-3, 0.130, 0.182, 1.75e-4],
        Variant::Friction => [9.42e-7, 5.16e-6, 2.4e-5, 2.9e-7],
        Variant::Augmented => [7.42e-7, 6.14e-6, 2.1e-5, 2.29e-7],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (11) is one minus the pooled error over the pooled spread, so the rows of one table share a spread.
    #[test]
    fn rows_of_a_table_agree_on_the_spread_of_its_torques() {
        for set in ["Baxter, circle_XY_T2_r10", "Baxter, sin_XYZ_12_5s_T2_5_Tz_5T_r18"] {
            // Those whose 1 - R² is printed to 15 % or better.
            let spreads = published(set).iter().filter(|row| row.pooled_r2 < 0.992);
            let spreads: Vec<f64> =
                spreads.map(|row| row.mse.iter().sum::<f64>() / (1.0 - row.pooled_r2)).collect();
            let [least, most] = spreads.iter().fold([f64::INFINITY, 0.0], |[a, b], s| [s.min(a), s.max(b)]);
            assert!(spreads.len() >= 3 && most / least < 1.2, "{set}: {spreads:?}");
        }
    }
}
