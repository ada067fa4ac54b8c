//! A three-segment robot driven by nine strokes: tip error on patterns that were not fitted, in five folds.
//!
//! Beside each other: the twin with fitted zeros, compliance and angles of its tendons; static regressions of the tip
//! on the strokes; and a regression of what the twin leaves. A pattern and its holds are never divided.
#![allow(clippy::print_stdout)] // this program prints tables

mod recording;
mod regression;
mod robot;

use std::path::Path;

use anyhow::Result;
use hysteron_base::rng;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::{data_folder, distance, rms, write_metrics};
use crate::table::print_cells;
use recording::{Pattern, read_patterns};
use robot::{Fitted, Robot};

const N_FOLDS: usize = 5;

/// What predicts the tip; another one is one more line in [`run`].
const METHODS: [&str; 4] =
    ["twin, fitted", "cubic regression", "kernel regression", "twin + kernel regression"];

/// Runs the study, a quick one with the first fold and few rows to fit; skipped by name where the recordings are not there.
///
/// # Errors
/// The files cannot be read, or a fit fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let path = data_folder().join("ftdcr-v4/train.csv");
    if !path.exists() {
        println!("study ftdcr skipped: no {}", path.display());
        return Ok(());
    }
    let patterns = read_patterns(&path)?;
    let fold_of = folds(patterns.len());
    let (n_folds, fit_rows) = if quick { (1, 24) } else { (N_FOLDS, 110) };
    let robot = Robot::read(fit_rows)?;
    let folds: Vec<Fold> = (0..n_folds)
        .into_par_iter()
        .map(|fold| {
            let (held, training): (Vec<_>, Vec<_>) =
                patterns.iter().zip(&fold_of).partition(|(_, of)| **of == fold);
            let only = |pairs: Vec<(&Pattern, &usize)>| {
                pairs.into_iter().map(|(p, _)| p.clone()).collect::<Vec<_>>()
            };
            Fold::new(&robot, &only(training), &only(held))
        })
        .collect::<Result<_>>()?;
    print(&folds);
    write_metrics(folder, "ftdcr", metrics(&folds))
}

/// The fold of every pattern, drawn with a seed.
fn folds(n_patterns: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n_patterns).collect();
    order.shuffle(&mut rng(1, "ftdcr/folds"));
    let mut fold_of = vec![0; n_patterns];
    order.into_iter().enumerate().for_each(|(place, pattern)| fold_of[pattern] = place % N_FOLDS);
    fold_of
}

/// What the patterns of a fold, which were not fitted, gave.
struct Fold {
    patterns: Vec<String>,
    fitted: Fitted,
    /// Distance of the tip for every method and held-out row [mm].
    errors: Vec<Vec<f64>>,
    rows_without_equilibrium: usize,
}

impl Fold {
    fn new(robot: &Robot, training: &[Pattern], held: &[Pattern]) -> Result<Self> {
        let fitted = robot.fit(training)?;
        let [(known, bad), (new, worse)] = [robot.predict(&fitted, training)?, robot.predict(&fitted, held)?];
        let strokes = |patterns: &[Pattern]| -> Vec<Vec<f64>> {
            patterns.iter().flat_map(|p| &p.rows).map(|row| row.strokes.map(|s| 1e3 * s).to_vec()).collect()
        };
        let tips = |patterns: &[Pattern]| -> Vec<[f64; 3]> {
            patterns.iter().flat_map(|p| &p.rows).map(|row| row.tip.map(|c| 1e3 * c)).collect()
        };
        let (known_strokes, new_strokes) = (strokes(training), strokes(held));
        let (known_tips, measured) = (tips(training), tips(held));
        let groups: Vec<usize> =
            training.iter().enumerate().flat_map(|(k, p)| std::iter::repeat_n(k, p.rows.len())).collect();

        let twin: Vec<[f64; 3]> = new.iter().map(|row| row.tip).collect();
        let left: Vec<[f64; 3]> = known
            .iter()
            .zip(&known_tips)
            .map(|(row, tip)| std::array::from_fn(|c| tip[c] - row.tip[c]))
            .collect();
        let features =
            |rows: &[robot::Predicted]| rows.iter().map(robot::Predicted::features).collect::<Vec<_>>();
        let correction = regression::kernel(&features(&known), &left, &groups, &features(&new))?;
        let corrected =
            twin.iter().zip(&correction).map(|(a, b)| std::array::from_fn(|c| a[c] + b[c])).collect();
        let predictions: [Vec<[f64; 3]>; 4] = [
            twin,
            regression::cubic(&known_strokes, &known_tips, &groups, &new_strokes)?,
            regression::kernel(&known_strokes, &known_tips, &groups, &new_strokes)?,
            corrected,
        ];
        let error =
            |tips: &Vec<[f64; 3]>| tips.iter().zip(&measured).map(|(a, b)| distance(*a, *b)).collect();
        Ok(Self {
            patterns: held.iter().map(|pattern| pattern.label.clone()).collect(),
            fitted,
            errors: predictions.iter().map(error).collect(),
            rows_without_equilibrium: bad + worse,
        })
    }
}

fn pooled(folds: &[Fold], method: usize) -> f64 {
    rms(folds.iter().flat_map(|fold| &fold.errors[method]).copied())
}

fn print(folds: &[Fold]) {
    let mut heading = vec!["tip RMSE [mm] on held-out patterns".to_owned()];
    heading.extend((1..=folds.len()).map(|k| format!("fold {k}")));
    heading.push("all".into());
    let mut cells = vec![heading];
    for (m, name) in METHODS.iter().enumerate() {
        let mut row = vec![(*name).to_owned()];
        row.extend(folds.iter().map(|fold| format!("{:.2}", rms(fold.errors[m].iter().copied()))));
        row.push(format!("{:.2}", pooled(folds, m)));
        cells.push(row);
    }
    print_cells(&cells);
    println!();
    for (name, k) in folds[0].fitted.names.iter().zip(0..) {
        let values: Vec<String> = folds.iter().map(|fold| format!("{:9.4}", fold.fitted.values[k])).collect();
        println!("{name:<34}{}", values.join(" "));
    }
}

fn metrics(folds: &[Fold]) -> Value {
    let of_fold = |fold: &Fold| {
        json!({
            "patterns": fold.patterns,
            "rows": fold.errors[0].len(),
            "rows_without_equilibrium": fold.rows_without_equilibrium,
            "parameters": fold.fitted.names.iter().zip(&fold.fitted.values).map(|(name, value)| json!({"name": name, "value": value})).collect::<Vec<_>>(),
            "fit_ended": fold.fitted.ended,
            "rmse_mm": METHODS.iter().zip(&fold.errors).map(|(name, e)| json!({"method": name, "rmse_mm": rms(e.iter().copied())})).collect::<Vec<_>>(),
        })
    };
    json!({
        "folds": folds.iter().map(of_fold).collect::<Vec<_>>(),
        "pooled": METHODS.iter().enumerate().map(|(m, name)| json!({"method": name, "rmse_mm": pooled(folds, m)})).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_are_even_and_the_same_every_time() {
        let fold_of = folds(66);
        assert_eq!(fold_of, folds(66));
        for fold in 0..N_FOLDS {
            let n = fold_of.iter().filter(|of| **of == fold).count();
            assert!((13..=14).contains(&n), "{n} patterns in fold {fold}");
        }
        assert_ne!(fold_of[..5], [0, 1, 2, 3, 4]);
    }
}
