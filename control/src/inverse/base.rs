//! The part of a controller below its network: a map of the path to strokes that is fitted in closed form, and the data as the
//! network sees them.

use hysteron_fit::folds;
use hysteron_learn::{Normaliser, RadialBasis, RadialSamples, RadialSetting, WeightFormat};

use super::fit::ControllerParts;
use super::loss::TrajectoryArrays;
use super::path_point::PathPoint;
use super::recurrent_options::{BaseMap, RecurrentOptions};
use super::smooth::{Smoothed, smoothed};
use super::{
    Check, Dataset, Demonstration, FeatureSpec, Features, InverseDesign, StaticRegression, TipWorkspace,
};
use crate::Result;

/// Middles of the kernel's functions.
const N_CENTRES: usize = 200;
/// Samples of all training trajectories that a kernel is fitted to, spread evenly.
const MAX_SAMPLES: usize = 6000;
/// Widths to choose from, see [`RadialSetting`].
const WIDTHS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// Penalties to choose from.
const PENALTIES: [f64; 5] = [1e-8, 1e-6, 1e-4, 1e-2, 1.0];
/// Parts of the training trajectories that are left out in turn; blocks of the only one.
const PARTS: usize = 4;

/// The map, and the data as a network above it sees them.
pub(super) struct FittedBase {
    spec: FeatureSpec,
    regression: StaticRegression,
    kernel: Option<RadialBasis>,
    /// Of the training; the kernel's part of each trajectory is by one that was fitted to others.
    pub training: Vec<Raw>,
    pub validation: Vec<Raw>,
    pub inputs: Normaliser,
    workspace: TipWorkspace,
    /// Root mean square error of each stroke in validation [mm].
    pub errors_mm: Vec<f64>,
    delay_s: f64,
}

impl FittedBase {
    pub fn new(data: &Dataset, options: &RecurrentOptions) -> Result<Self> {
        options.check()?;
        options.features(data, 0.0)?;
        let Smoothed { training, validation, delay_s, regression, regression_mm, workspace } =
            smoothed(data, options.smoothing, options.half_width_s, options.largest_delay_s)?;
        let spec = options.features(data, delay_s)?;
        let raw = |paths: &[Vec<PathPoint>]| -> Vec<Raw> {
            paths.iter().map(|path| Raw::new(path, &spec, &regression)).collect()
        };
        let (mut training, mut validation) = (raw(&training), raw(&validation));
        let inputs = input_ranges(&training, &spec)?;
        let kernel = match options.base {
            BaseMap::Cubic => None,
            BaseMap::Kernel => Some(fitted_kernel(data, &spec, &mut training)?),
        };
        let mut errors_mm = regression_mm;
        if let Some(kernel) = &kernel {
            validation.iter_mut().for_each(|raw| raw.add(kernel));
            errors_mm = root_mean_squares_mm(&data.validation, &validation, data.n_tendons);
        }
        Ok(Self { spec, regression, kernel, training, validation, inputs, workspace, errors_mm, delay_s })
    }

    pub fn into_parts(self, outputs: Normaliser, weights: WeightFormat) -> ControllerParts {
        let name = if self.kernel.is_some() { "kernel regression" } else { "static regression" };
        ControllerParts {
            inputs: self.inputs,
            outputs,
            design: InverseDesign::Recurrent {
                features: self.spec,
                regression: self.regression,
                kernel: self.kernel.map(Box::new),
            },
            workspace: self.workspace,
            weights,
            base: (name, self.errors_mm),
            delay_s: self.delay_s,
        }
    }
}

/// Kernel regression of what the cubic leaves, on the features that err least on trajectories left out. Every trajectory of
/// `training` gets what a kernel says that was fitted to the others: a network above must not learn from errors smaller than those
/// that it will meet.
fn fitted_kernel(data: &Dataset, spec: &FeatureSpec, training: &mut [Raw]) -> Result<RadialBasis> {
    let n_inputs = spec.names().len();
    let rows = KernelRows::new(data, training, n_inputs);
    let samples = RadialSamples {
        n_inputs,
        n_outputs: data.n_tendons,
        inputs: &rows.inputs,
        outputs: &rows.outputs,
        groups: &rows.groups,
    };
    let n_groups = rows.groups.len();
    let parts = folds(n_groups, PARTS.min(n_groups))?;
    let left_out: Vec<Vec<usize>> = parts.iter().map(|part| part.test.clone()).collect();
    let mut best: Option<(RadialSetting, f64)> = None;
    for setting in settings(spec) {
        let found = RadialBasis::choose(&samples, &setting, (&WIDTHS, &PENALTIES), &left_out)?;
        if best.as_ref().is_none_or(|(_, least)| found.1 < *least) {
            best = Some(found);
        }
    }
    let setting = best.map(|(setting, _)| setting).unwrap_or_else(|| settings(spec).swap_remove(0));
    if training.len() > 1 {
        for part in &parts {
            let kernel = RadialBasis::fit(&samples, &setting, &part.training);
            part.test.iter().for_each(|&k| training[k].add(&kernel));
        }
    }
    let kernel = RadialBasis::fit(&samples, &setting, &(0..n_groups).collect::<Vec<_>>());
    if let [only] = training {
        only.add(&kernel);
    }
    Ok(kernel)
}

/// Sets of features to choose from: where the tip is, in which direction it goes and where it will be; and all as a line, with
/// the plays and filters that remember, or none.
fn settings(spec: &FeatureSpec) -> Vec<RadialSetting> {
    let tip = |name: &str| name.starts_with("tip_");
    let direction = |name: &str| name.starts_with("direction_");
    let ahead = |name: &str| name.starts_with("ahead_") && !name.ends_with("_m_s");
    let seen = [
        spec.numbers(tip),
        spec.numbers(|name| tip(name) || direction(name)),
        spec.numbers(|name| tip(name) || direction(name) || ahead(name)),
    ];
    let of = |seen: Vec<usize>| {
        [Vec::new(), spec.numbers(|_| true)].map(|line| RadialSetting {
            seen: seen.clone(),
            line,
            n_centres: N_CENTRES,
            width: WIDTHS[0],
            penalty: PENALTIES[0],
        })
    };
    seen.into_iter().flat_map(of).collect()
}

/// Samples of the training that a kernel is fitted to: features, and what the cubic leaves of the strokes.
struct KernelRows {
    inputs: Vec<f64>,
    outputs: Vec<f64>,
    /// One for each trajectory, or blocks of the only one.
    groups: Vec<std::ops::Range<usize>>,
}

impl KernelRows {
    fn new(data: &Dataset, training: &[Raw], n_inputs: usize) -> Self {
        let n_samples: usize = data.training.iter().map(Demonstration::len).sum();
        let stride = n_samples.div_ceil(MAX_SAMPLES).max(1);
        let mut rows = Self { inputs: Vec::new(), outputs: Vec::new(), groups: Vec::new() };
        for (one, raw) in data.training.iter().zip(training) {
            let start = rows.outputs.len() / data.n_tendons;
            for i in (0..one.len()).step_by(stride).filter(|i| !one.gap[*i]) {
                rows.inputs.extend(&raw.features[i * n_inputs..(i + 1) * n_inputs]);
                let found = &raw.strokes[i * data.n_tendons..(i + 1) * data.n_tendons];
                rows.outputs.extend(one.strokes_at(i).iter().zip(found).map(|(exact, found)| exact - found));
            }
            rows.groups.push(start..rows.outputs.len() / data.n_tendons);
        }
        if let [only] = &rows.groups[..] {
            let end = only.end;
            rows.groups = (0..PARTS).map(|k| k * end / PARTS..(k + 1) * end / PARTS).collect();
        }
        rows
    }
}

/// A trajectory before it is normalised.
pub(super) struct Raw {
    /// Features (n × inputs).
    features: Vec<f64>,
    /// Strokes of the map (n × n_tendons) [m].
    pub strokes: Vec<f64>,
}

impl Raw {
    /// With the strokes of the cubic, of which the features are.
    fn new(path: &[PathPoint], spec: &FeatureSpec, regression: &StaticRegression) -> Self {
        let mut raw = Self { features: Vec::new(), strokes: vec![0.0; path.len() * spec.n_tendons] };
        let mut features = Features::new(spec);
        for (i, strokes) in raw.strokes.chunks_exact_mut(spec.n_tendons).enumerate() {
            regression.strokes_into(path[i].position, strokes);
            features.append(path, i, strokes, &mut raw.features);
        }
        raw
    }

    fn add(&mut self, kernel: &RadialBasis) {
        let mut terms = Vec::new();
        let rows = self.features.chunks_exact(kernel.n_inputs());
        for (row, strokes) in rows.zip(self.strokes.chunks_exact_mut(kernel.n_outputs())) {
            kernel.add_to(row, &mut terms, strokes);
        }
    }

    /// Arrays of the network.
    pub fn row(&self, one: &Demonstration, inputs: &Normaliser, outputs: &Normaliser) -> TrajectoryArrays {
        let n_inputs = inputs.channels.len();
        let mut features = vec![0.0; self.features.len()];
        for (raw, out) in self.features.chunks_exact(n_inputs).zip(features.chunks_exact_mut(n_inputs)) {
            inputs.normalise_into(raw, out);
        }
        let middle = outputs.channels.iter().map(|c| 0.5 * (c.min + c.max)).cycle();
        let offset = self.strokes.iter().zip(&one.strokes).zip(middle);
        let mean = |i: usize| one.strokes_at(i).iter().sum::<f64>() / one.n_tendons as f64;
        TrajectoryArrays {
            features,
            offset: offset
                .map(|((found, stroke), middle)| (1e3 * (found + middle - stroke)) as f32)
                .collect(),
            pull: (0..one.len()).map(|i| (1e3 * mean(i)) as f32).collect(),
            jacobian: one.jacobian.iter().map(|&j| j as f32).collect(),
            weight: one.gap.iter().map(|&gap| if gap { 0.0 } else { 1.0 }).collect(),
        }
    }
}

fn input_ranges(training: &[Raw], spec: &FeatureSpec) -> Check<Normaliser> {
    let names = spec.names();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Normaliser::from_samples(&names, training.iter().flat_map(|raw| raw.features.chunks_exact(names.len())))
}

/// Root mean square error of each stroke, without samples that were filled in [mm].
fn root_mean_squares_mm(demonstrations: &[Demonstration], found: &[Raw], n_tendons: usize) -> Vec<f64> {
    let (mut squares, mut count) = (vec![0.0; n_tendons], 0.0);
    for (one, raw) in demonstrations.iter().zip(found) {
        for (i, strokes) in raw.strokes.chunks_exact(n_tendons).enumerate().filter(|(i, _)| !one.gap[*i]) {
            for ((sum, found), stroke) in squares.iter_mut().zip(strokes).zip(one.strokes_at(i)) {
                *sum += (1e3 * (found - stroke)).powi(2);
            }
            count += 1.0;
        }
    }
    squares.into_iter().map(|sum| (sum / f64::max(count, 1.0)).sqrt()).collect()
}
