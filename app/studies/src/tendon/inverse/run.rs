//! The run of `study inverse`.

use std::path::Path;

use anyhow::{Result, ensure};
use hysteron_control::inverse::{Dataset, Demonstration, RecurrentOptions};
use hysteron_control::tracking::{PlanarPoint, Timed, aligned_rmse, chamfer, frechet, hausdorff, lag};
use hysteron_workflow::{Context, WorkflowError};
use rayon::prelude::*;

use super::baselines;
use super::demonstrations::{N_MOTORS, TRUNK_STEP, TURNS, blocks, pattern};
use super::methods::{Controllers, Errors, InverseScores, METHODS, ftdcr_options, trunk_options};
use super::outcome::{InverseMetrics, PathDifference, SegmentsResult, TrunkResult};
use crate::tendon::columns::Columns;
use crate::tendon::ftdcr::{N_FOLDS, folds, read_patterns};
use crate::tendon::{DataOptions, Outcome, session};

/// Every sample counts for errors, every tenth for the distances of curves, which take time with the square of their
/// number.
const CURVE_EVERY: usize = 10;
/// Every fourth pattern for training is one to stop by.
const STOP_BY: usize = 4;

/// Runs the study, a quick one with fewer epochs and folds; a robot without recordings is skipped.
///
/// # Errors
/// The files of both robots are missing, or cannot be read, or a training fails.
pub fn run(options: &DataOptions, context: &Context) -> Result<Outcome<InverseMetrics>, WorkflowError> {
    session::run("inverse", &options.shared.out, context, || {
        let quick = options.shared.quick;
        let [trunk, segments] = ["trunk", "ftdcr-v4/train.csv"].map(|name| options.find(name));
        if trunk.is_none() && segments.is_none() {
            options.require("trunk")?;
        }
        if trunk.is_none() {
            tracing::warn!("no recordings of the trunk: it is skipped");
        }
        if segments.is_none() {
            tracing::warn!("no recordings of the three-segment robot: it is skipped");
        }
        Ok(InverseMetrics {
            trunk: trunk.map(|folder| study_trunk(&folder, quick)).transpose()?,
            ftdcr: segments.map(|path| study_segments(&path, quick)).transpose()?,
        })
    })
}

fn study_trunk(folder: &Path, quick: bool) -> Result<TrunkResult> {
    let seeds = if quick { 1 } else { 5 };
    let angles = Columns::read(&folder.join("control_inputs_controlled_1.csv"))?;
    let angles = angles.rows_of(&columns("u", N_MOTORS))?;
    let [tips, loaded] = ["", "_200g"].map(|load| {
        let path = folder.join(format!("observations_controlled_1{load}.csv"));
        // y is vertical.
        Columns::read(&path)?.rows_of(&["x3", "z3", "y3"])
    });
    let (tips, loaded) = (tips?, loaded?);
    let (blocks, under_load) = (blocks(&angles, &tips, "block"), blocks(&angles, &loaded, "loaded"));
    ensure!(blocks.len() > TURNS, "the trunk's run is too short for blocks");
    let turn = |remainder: usize, all: &'_ [Demonstration]| -> Vec<Demonstration> {
        all.iter().enumerate().filter(|(k, _)| k % TURNS == remainder).map(|(_, one)| one.clone()).collect()
    };
    // The run under load has the same commands: only the same blocks of it are test data.
    let (test, under_load) = (turn(TURNS - 1, &blocks), turn(TURNS - 1, &under_load));
    let stop = turn(TURNS - 2, &blocks);
    let names: Vec<String> = stop.iter().map(|one| one.name.clone()).collect();
    let known: Vec<Demonstration> = blocks
        .iter()
        .enumerate()
        .filter(|(k, _)| k % TURNS != TURNS - 1)
        .map(|(_, one)| one.clone())
        .collect();
    let known = Dataset::new(known, &names, 1)?;
    let test: Vec<&Demonstration> = test.iter().collect();
    let under_load: Vec<&Demonstration> = under_load.iter().collect();
    let baselines = [baselines::all(&known, &test)?, baselines::all(&known, &under_load)?];
    let found = (1..=seeds)
        .into_par_iter()
        .map(|seed| {
            let options = RecurrentOptions { seed, ..trunk_options(quick) };
            let controllers = Controllers::new(&known, &options)?;
            Ok([controllers.scores(&test, &baselines[0])?, controllers.scores(&under_load, &baselines[1])?])
        })
        .collect::<Result<Vec<[InverseScores; 2]>>>()?;
    let row = |k: usize| found.iter().map(|both| both[k].errors).collect::<Vec<Errors>>();
    let delays: Vec<Errors> = found.iter().map(|both| both[0].delays_s).collect();
    let (same, other) = (row(0), row(1));
    Ok(TrunkResult {
        methods: METHODS.map(str::to_owned).to_vec(),
        unseen_blocks_deg: same,
        loaded_deg: other,
        delays_s: delays,
        path_under_load: compare_paths(&tips, &loaded),
    })
}

/// How far two recorded paths of the same commands are apart, in the horizontal plane.
fn compare_paths(tips: &[Vec<f64>], loaded: &[Vec<f64>]) -> PathDifference {
    let plane = |tips: &[Vec<f64>]| -> Vec<PlanarPoint> {
        tips.iter().step_by(CURVE_EVERY).map(|tip| [tip[0], tip[1]]).collect()
    };
    let (a, b) = (plane(tips), plane(loaded));
    let time: Vec<f64> = (0..a.len().max(b.len())).map(|i| (i * CURVE_EVERY) as f64 * TRUNK_STEP).collect();
    let target = Timed { time: &time[..a.len()], points: &a };
    let path = Timed { time: &time[..b.len()], points: &b };
    PathDifference {
        aligned_rmse_mm: aligned_rmse(target, path, 0.0).map(|m| 1e3 * m),
        lag_s: lag(target, path, CURVE_EVERY as f64 * TRUNK_STEP),
        chamfer_mm: 1e3 * chamfer(&a, &b),
        hausdorff_mm: 1e3 * hausdorff(&a, &b),
        frechet_mm: 1e3 * frechet(&a, &b),
    }
}

fn study_segments(path: &Path, quick: bool) -> Result<SegmentsResult> {
    let patterns = read_patterns(path)?;
    let fold_of = folds(patterns.len());
    let all: Vec<Demonstration> = patterns.iter().map(pattern).collect();
    let found = (0..if quick { 1 } else { N_FOLDS })
        .into_par_iter()
        .map(|fold| {
            let (test, known): (Vec<_>, Vec<_>) = all.iter().zip(&fold_of).partition(|(_, of)| **of == fold);
            let test: Vec<&Demonstration> = test.into_iter().map(|(one, _)| one).collect();
            let known: Vec<Demonstration> = known.into_iter().map(|(one, _)| one.clone()).collect();
            let stop: Vec<String> =
                known.iter().skip(STOP_BY - 1).step_by(STOP_BY).map(|one| one.name.clone()).collect();
            let known = Dataset::new(known, &stop, 1)?;
            Controllers::new(&known, &ftdcr_options(quick))?.scores(&test, &baselines::all(&known, &test)?)
        })
        .collect::<Result<Vec<InverseScores>>>()?;
    let errors: Vec<Errors> = found.iter().map(|test| test.errors).collect();
    Ok(SegmentsResult { methods: METHODS.map(str::to_owned).to_vec(), folds_mm: errors })
}

fn columns(stem: &str, n: usize) -> Vec<String> {
    (1..=n).map(|k| format!("{stem}{k}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_that_comes_later_is_late_and_no_farther() {
        let circle = |shift: f64| -> Vec<Vec<f64>> {
            let at = |i: usize| std::f64::consts::TAU * (i as f64 * TRUNK_STEP - shift) / 8.0;
            (0..1600).map(|i| vec![at(i).cos(), at(i).sin(), 0.0]).collect()
        };
        let found = compare_paths(&circle(0.0), &circle(0.3));
        // Lags are found on chords of 0.1 s: to much less than one of them.
        assert!((found.lag_s.unwrap_or(f64::NAN) - 0.3).abs() < 0.01, "{found:?}");
        // A chord's sagitta: 1 m (0.1 s τ / 8 s)² / 8 = 0.8 mm.
        assert!(found.chamfer_mm < 0.8, "{found:?}");
    }
}
