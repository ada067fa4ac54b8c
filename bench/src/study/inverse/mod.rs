//! The inverse network on robots that other people recorded: which strokes, or motor angles, made a given path of
//! the tip?
//!
//! Compared with baselines without a network: a static regression, the same of the tip some time later, and a
//! kernel on two tips, with the delay that does best on the validation trajectories; and the same network
//! without looking ahead. On the trunk, blocks of the run take turns: most for training, some for validation,
//! some for the test; and the same blocks of a run with a load at the tip. On the three-segment robot whole
//! patterns, in five folds.
#![allow(clippy::print_stdout)] // this program prints tables

mod rivals;

use std::path::Path;

use anyhow::{Result, ensure};
use hysteron_base::{Bounds, json};
use hysteron_control::StrokeLimits;
use hysteron_control::inverse::{
    Axes, DataOrigin, Dataset, Demonstration, InverseDesign, InverseModel, PathSmoothing, RecurrentOptions,
    TipPosition, fit_recurrent,
};
use hysteron_control::tracking::{PlanarPoint, Timed, aligned_rmse, chamfer, frechet, hausdorff, lag};
use hysteron_learn::{SequenceOptions, TrainingSession};
use rayon::prelude::*;
use serde_json::Value;

use super::ftdcr::{N_FOLDS, N_TENDONS, Pattern, folds, read_patterns};
use super::{data_folder, rms, write_metrics};
use crate::columns::Columns;
use crate::table::print_cells;
use rivals::Rival;

/// Nominal duration of a sample of the trunk, and of the three-segment robot [s].
const TRUNK_STEP: f64 = 0.01;
const FTDCR_STEP: f64 = 0.58;
const N_MOTORS: usize = 6;
/// An angle stands for a stroke: one degree for this many metres, so that what is said in millimetres is in degrees.
const DEGREE: f64 = 1e-3;
/// A block of the trunk's run, and every how many of them one is to stop by, and the next to test on.
const BLOCK_S: f64 = 10.0;
const TURNS: usize = 5;
/// Every sample counts for errors, every tenth for the distances of curves, which take time with the square of their
/// number.
const CURVE_EVERY: usize = 10;
/// Every fourth pattern for training is one to stop by.
const STOP_BY: usize = 4;

/// No limits.
const WIDE: StrokeLimits = StrokeLimits { stroke: Bounds { min: -1.0, max: 1.0 }, stroke_rate: 1e6 };

/// Root mean square error over all strokes [mm or degrees] of what was tested, by method.
type Errors = [f64; METHODS.len()];
const METHODS: [&str; 5] = [
    "static regression",
    "static regression, delayed",
    "kernel on two tips, delayed",
    "network, no look ahead",
    "network",
];

/// Errors, and the delays that the methods chose [s].
struct Judged {
    errors: Errors,
    delays_s: Errors,
}

/// Runs the study, a quick one with fewer epochs and folds; robots whose recordings are not there are skipped by name.
///
/// # Errors
/// The files cannot be read, or a training fails.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let seeds = if quick { 1 } else { 5 };
    let mut metrics = json!({});
    let trunk = data_folder().join("trunk");
    if trunk.exists() {
        metrics["trunk"] = study_trunk(&trunk, seeds, quick)?;
    } else {
        println!("trunk skipped: no {}", trunk.display());
    }
    let path = data_folder().join("ftdcr-v4/train.csv");
    if path.exists() {
        metrics["ftdcr"] = study_ftdcr(&path, quick)?;
    } else {
        println!("three-segment robot skipped: no {}", path.display());
    }
    write_metrics(folder, "inverse", metrics)
}

/// How to train on the trunk: its motors run about a quarter of a second ahead of the tip, which the horizons span.
fn trunk_options(quick: bool) -> RecurrentOptions {
    let default = RecurrentOptions::default();
    let epochs = if quick { 2 } else { 60 };
    RecurrentOptions { learning: SequenceOptions { epochs, truncation: 100, ..default.learning }, ..default }
}

/// How to train on patterns of some tens of rows, far apart in time.
fn ftdcr_options(quick: bool) -> RecurrentOptions {
    let default = RecurrentOptions::default();
    let learning = SequenceOptions {
        hidden: 48,
        epochs: if quick { 2 } else { 600 },
        patience: 200,
        learning_rate: 5e-3,
        ema: 0.05,
        ..default.learning
    };
    RecurrentOptions {
        learning,
        half_width_s: FTDCR_STEP,
        horizons_s: vec![FTDCR_STEP],
        filters_s: vec![2.0, 10.0],
        ..default
    }
}

/// The same for a path that is not known in advance.
fn without_looking_ahead(options: &RecurrentOptions) -> RecurrentOptions {
    RecurrentOptions {
        smoothing: PathSmoothing::Causal,
        horizons_s: Vec::new(),
        largest_delay_s: 0.0,
        ..options.clone()
    }
}

/// Trains both networks on `known` and tests on `test`, next to baselines with the same data.
fn evaluate(
    known: &Dataset,
    test: &[&Demonstration],
    [plain, delayed, kernel]: &[Rival; 3],
    options: &RecurrentOptions,
) -> Result<Judged> {
    let fit = |options: &RecurrentOptions| -> Result<InverseModel> {
        Ok(fit_recurrent(known, options, &mut TrainingSession { file: None, progress: &mut |_| true })?.model)
    };
    let (blind, seeing) = (fit(&without_looking_ahead(options))?, fit(options)?);
    let InverseDesign::Recurrent { features, .. } = &seeing.design else {
        unreachable!("what fit_recurrent makes")
    };
    let by = |model: &InverseModel, path: &[TipPosition]| -> Result<Vec<f64>> {
        Ok(model.command(path, WIDE, &mut |_| true)?.strokes)
    };
    let errors = [
        plain.error,
        delayed.error,
        kernel.error,
        error(test, &|path| by(&blind, path))?,
        error(test, &|path| by(&seeing, path))?,
    ];
    Ok(Judged { errors, delays_s: [plain.delay_s, delayed.delay_s, kernel.delay_s, 0.0, features.delay_s] })
}

/// Root mean square of what strokes miss [mm].
fn error(test: &[&Demonstration], strokes: &dyn Fn(&[TipPosition]) -> Result<Vec<f64>>) -> Result<f64> {
    let mut off = Vec::new();
    for one in test {
        let found = strokes(&one.tip)?;
        off.extend(found.iter().zip(&one.strokes).map(|(found, made)| 1e3 * (found - made)));
    }
    Ok(rms(off))
}

fn study_trunk(folder: &Path, seeds: u64, quick: bool) -> Result<Value> {
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
    let turn = |wanted: usize, all: &'_ [Demonstration]| -> Vec<Demonstration> {
        all.iter().enumerate().filter(|(k, _)| k % TURNS == wanted).map(|(_, one)| one.clone()).collect()
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
    let rivals = [rivals::all(&known, &test)?, rivals::all(&known, &under_load)?];
    let found = (1..=seeds)
        .into_par_iter()
        .map(|seed| {
            let options = RecurrentOptions { seed, ..trunk_options(quick) };
            let [same, other] = [(&test, &rivals[0]), (&under_load, &rivals[1])]
                .map(|(test, rivals)| evaluate(&known, test, rivals, &options));
            Ok([same?, other?])
        })
        .collect::<Result<Vec<[Judged; 2]>>>()?;
    let row = |k: usize| found.iter().map(|both| both[k].errors).collect::<Vec<Errors>>();
    let delays: Vec<Errors> = found.iter().map(|both| both[0].delays_s).collect();
    print_delays(&delays);
    let (same, other) = (row(0), row(1));
    print_errors(
        "trunk, error of the motor angles [deg]",
        &[("unseen blocks", &same), ("the same, 200 g at the tip", &other)],
    );
    let paths = compare_paths(&tips, &loaded);
    println!("trunk, the path under load against the one without, same commands: {paths}\n");
    Ok(json!({
        "methods": METHODS, "unseen_blocks_deg": same, "loaded_deg": other, "delays_s": delays,
        "path_under_load": paths,
    }))
}

/// Blocks of the trunk's run, in order; the tip from where it was in the first second of the run.
fn blocks(angles: &[Vec<f64>], tips: &[Vec<f64>], name: &str) -> Vec<Demonstration> {
    let n = angles.len().min(tips.len());
    let n_rest = (1.0 / TRUNK_STEP) as usize;
    let rest: Vec<f64> = (0..3).map(|c| mean(tips[..n_rest.min(n)].iter().map(|tip| tip[c]))).collect();
    let size = (BLOCK_S / TRUNK_STEP) as usize;
    let block = |k: usize| {
        let samples = k * size..(k + 1) * size;
        let tip = samples.clone().map(|i| std::array::from_fn(|c| tips[i][c] - rest[c])).collect();
        let strokes = samples.flat_map(|i| &angles[i]).map(|angle| DEGREE * angle).collect();
        demonstration(format!("{name}-{k}"), TRUNK_STEP, tip, N_MOTORS, strokes)
    };
    (0..n / size).map(block).collect()
}

fn demonstration(
    name: String,
    step: f64,
    tip: Vec<TipPosition>,
    n_tendons: usize,
    strokes: Vec<f64>,
) -> Demonstration {
    Demonstration {
        name,
        hash: String::new(),
        origin: DataOrigin::Real,
        robot: String::new(),
        family: String::new(),
        step,
        axes: Axes::Spatial,
        gap: vec![false; tip.len()],
        tip,
        n_tendons,
        strokes,
        jacobian: Vec::new(),
    }
}

/// How far two recorded paths of the same commands are apart, in the horizontal plane.
fn compare_paths(tips: &[Vec<f64>], loaded: &[Vec<f64>]) -> Value {
    let plane = |tips: &[Vec<f64>]| -> Vec<PlanarPoint> {
        tips.iter().step_by(CURVE_EVERY).map(|tip| [tip[0], tip[1]]).collect()
    };
    let (a, b) = (plane(tips), plane(loaded));
    let time: Vec<f64> = (0..a.len().max(b.len())).map(|i| (i * CURVE_EVERY) as f64 * TRUNK_STEP).collect();
    let target = Timed { time: &time[..a.len()], points: &a };
    let path = Timed { time: &time[..b.len()], points: &b };
    json!({
        "aligned_rmse_mm": aligned_rmse(target, path, 0.0).map(|m| 1e3 * m),
        "lag_s": lag(target, path, CURVE_EVERY as f64 * TRUNK_STEP),
        "chamfer_mm": 1e3 * chamfer(&a, &b),
        "hausdorff_mm": 1e3 * hausdorff(&a, &b),
        "frechet_mm": 1e3 * frechet(&a, &b),
    })
}

fn study_ftdcr(path: &Path, quick: bool) -> Result<Value> {
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
            evaluate(&known, &test, &rivals::all(&known, &test)?, &ftdcr_options(quick))
        })
        .collect::<Result<Vec<Judged>>>()?;
    let errors: Vec<Errors> = found.iter().map(|test| test.errors).collect();
    print_errors("three segments, error of the strokes [mm]", &[("unseen patterns, five folds", &errors)]);
    Ok(json!({ "methods": METHODS, "folds_mm": errors }))
}

fn pattern(pattern: &Pattern) -> Demonstration {
    let (tip, strokes) =
        pattern.rows.iter().map(|row| (row.tip, row.strokes)).unzip::<_, _, Vec<_>, Vec<_>>();
    demonstration(pattern.label.clone(), FTDCR_STEP, tip, N_TENDONS, strokes.concat())
}

/// Mean and deviation over seeds or folds.
fn print_errors(what: &str, rows: &[(&str, &Vec<Errors>)]) {
    let mut cells = vec![vec![what.to_owned()]];
    cells[0].extend(METHODS.map(str::to_owned));
    for (name, found) in rows {
        let mut row = vec![(*name).to_owned()];
        row.extend((0..METHODS.len()).map(|m| {
            let average = mean(found.iter().map(|errors| errors[m]));
            format!("{average:.3} ± {:.3}", rms(found.iter().map(|errors| errors[m] - average)))
        }));
        cells.push(row);
    }
    print_cells(&cells);
    println!();
}

/// The delays that the methods chose, mean over the seeds.
fn print_delays(delays: &[Errors]) {
    let cells = METHODS.iter().enumerate().map(|(m, name)| {
        let delay = mean(delays.iter().map(|delays| delays[m]));
        format!("{name} {:.0} ms", 1e3 * delay)
    });
    println!("trunk, delay of the tip behind the angles: {}", cells.collect::<Vec<_>>().join("; "));
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len().max(1) as f64;
    values.sum::<f64>() / n
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
        let number = |key: &str| found[key].as_f64().unwrap_or(f64::NAN);
        // Lags are found on chords of 0.1 s: to much less than one of them.
        assert!((number("lag_s") - 0.3).abs() < 0.01, "{found}");
        // A chord's sagitta: 1 m (0.1 s τ / 8 s)² / 8 = 0.8 mm.
        assert!(number("chamfer_mm") < 0.8, "{found}");
    }
}
