//! How closely a tip followed its target, in the numbers that every table of tracking shows: error in space and at
//! equal times, overlap, lag. A method that is late looks good in space alone.

use anyhow::Context as _;
use hysteron_control::tracking::TrackingScore;
use hysteron_report::dot_plot::{DotRow, DotTile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::numbers::mean;

/// Quantities of [`means`], for the first cell of a table.
pub const HEADING: &str = "NRMSE [%], IoU, at equal times [mm], lag [ms]";

/// How closely the tip of one repeat followed its target.
#[derive(Debug, Clone, Copy)]
pub struct Followed {
    /// NRMSE [%].
    pub nrmse_percent: f64,
    /// Overlap [-].
    pub iou: f64,
    /// Root mean square distance from where the tip was to be at that time [mm]; the paper gives none.
    pub aligned_rmse_mm: Option<f64>,
    /// Lag behind the target [ms].
    pub lag_ms: Option<f64>,
}

impl Followed {
    /// Of a score.
    ///
    /// # Errors
    /// The target encloses nothing, so that its path has no NRMSE or no overlap.
    pub fn of(score: &TrackingScore) -> anyhow::Result<Self> {
        let (nrmse, iou) = score.nrmse.zip(score.iou).context("a target without NRMSE or overlap")?;
        Ok(Self {
            nrmse_percent: 100.0 * nrmse,
            iou,
            aligned_rmse_mm: score.aligned_rmse_m.map(|m| 1e3 * m),
            lag_ms: score.lag_s.map(|s| 1e3 * s),
        })
    }

    /// The mean of every number, of those that have it.
    fn mean(all: &[Self]) -> Self {
        Self {
            nrmse_percent: mean(all.iter().map(|one| one.nrmse_percent)).unwrap_or(f64::NAN),
            iou: mean(all.iter().map(|one| one.iou)).unwrap_or(f64::NAN),
            aligned_rmse_mm: mean(all.iter().filter_map(|one| one.aligned_rmse_mm)),
            lag_ms: mean(all.iter().filter_map(|one| one.lag_ms)),
        }
    }

    /// `, 0.65, -5` for millimetres and milliseconds, as far as they are known.
    fn in_time(&self) -> String {
        match (self.aligned_rmse_mm, self.lag_ms) {
            (Some(aligned), Some(lag)) => format!(", {aligned:.2}, {lag:.0}"),
            _ => String::new(),
        }
    }
}

/// How closely a tip followed its target, for programs; null where the rig did not carry the strokes out.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct FollowedKeys {
    /// NRMSE [%].
    pub nrmse_percent: Option<f64>,
    /// Overlap [-].
    pub iou: Option<f64>,
    /// Root mean square distance from where the tip was to be at that time [mm].
    pub aligned_rmse_mm: Option<f64>,
    /// Lag behind the target [ms].
    pub lag_ms: Option<f64>,
}

impl FollowedKeys {
    /// Of a cell of a table.
    pub fn of(cell: Option<&Followed>) -> Self {
        Self {
            nrmse_percent: cell.map(|one| one.nrmse_percent),
            iou: cell.map(|one| one.iou),
            aligned_rmse_mm: cell.and_then(|one| one.aligned_rmse_mm),
            lag_ms: cell.and_then(|one| one.lag_ms),
        }
    }

    /// The same, where the rig carried the strokes out.
    pub fn followed(&self) -> Option<Followed> {
        Some(Followed {
            nrmse_percent: self.nrmse_percent?,
            iou: self.iou?,
            aligned_rmse_mm: self.aligned_rmse_mm,
            lag_ms: self.lag_ms,
        })
    }
}

/// One method for strokes.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FollowedMethod {
    /// Name of the method.
    pub method: String,
    /// How closely the tip followed the target.
    #[serde(flatten)]
    pub followed: FollowedKeys,
}

/// Means over the runs, and how many targets were not run.
pub fn means(cells: &[Option<Followed>]) -> String {
    let all: Vec<Followed> = cells.iter().flatten().copied().collect();
    if all.is_empty() {
        return "-".to_owned();
    }
    let of_all = Followed::mean(&all);
    let Followed { nrmse_percent, iou, .. } = of_all;
    format!("{nrmse_percent:.2}, {iou:.3}{}{}", of_all.in_time(), refused((cells.len() - all.len()) as u64))
}

/// A row of a table: its name, and for every one of `n_methods` the [`means`] over the paths.
pub fn row_of_means(name: &str, paths: &[Vec<Option<Followed>>], n_methods: usize) -> Vec<String> {
    let cell = |k: usize| means(&paths.iter().map(|path| path.get(k).copied().flatten()).collect::<Vec<_>>());
    std::iter::once(name.to_owned()).chain((0..n_methods).map(cell)).collect()
}

/// Tiles of the error in space and of that at equal times: a row for each method, a dot for each robot, mean of its paths.
/// `robots` has for each robot and path what every method came to.
pub fn error_tiles(methods: &[&str], robots: &[Vec<Vec<Option<Followed>>>]) -> Vec<DotTile> {
    let tile = |quantity: &str, of: fn(&Followed) -> Option<f64>| {
        let row = |(k, method): (usize, &&str)| {
            let of_robot = |paths: &Vec<Vec<Option<Followed>>>| {
                mean(paths.iter().filter_map(|path| of(path.get(k)?.as_ref()?)))
            };
            DotRow::new(*method, robots.iter().filter_map(of_robot))
        };
        DotTile::new(quantity, methods.iter().enumerate().map(row))
    };
    vec![
        tile("NRMSE [%]", |one| Some(one.nrmse_percent)),
        tile("distance at equal times, root mean square [mm]", |one| one.aligned_rmse_mm),
    ]
}

/// Means and deviations over repeats, and how many networks' strokes were refused.
pub fn spreads(all: &[Followed], n_refused: u64) -> String {
    if all.is_empty() {
        return "-".to_owned();
    }
    let of_all = Followed::mean(all);
    let spread = |of: fn(&Followed) -> f64, digits: usize| {
        let squares = all.iter().map(|one| (of(one) - of(&of_all)).powi(2));
        let deviation = mean(squares).unwrap_or(0.0).sqrt();
        format!("{:.digits$} ± {deviation:.digits$}", of(&of_all))
    };
    let (nrmse, iou) = (spread(|one| one.nrmse_percent, 2), spread(|one| one.iou, 3));
    format!("{nrmse}, {iou}{}{}", of_all.in_time(), refused(n_refused))
}

fn refused(count: u64) -> String {
    if count == 0 { String::new() } else { format!(" ({count} refused)") }
}

/// The mean of every method over the cases in which all methods have a value, case by case and method by method; a method
/// without any value is left out.
pub(super) fn paired_means(methods: &[String], cases: &[Vec<Option<f64>>]) -> Vec<(String, f64)> {
    let at = |case: &[Option<f64>], method: usize| case.get(method).copied().flatten();
    let has_any = |method: &usize| cases.iter().any(|case| at(case, *method).is_some());
    let kept: Vec<usize> = (0..methods.len()).filter(has_any).collect();
    let whole: Vec<Vec<f64>> =
        cases.iter().filter_map(|case| kept.iter().map(|method| at(case, *method)).collect()).collect();
    let of_method = |(k, method): (usize, &usize)| {
        Some((methods[*method].clone(), mean(whole.iter().map(|case| case[k]))?))
    };
    kept.iter().enumerate().filter_map(of_method).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: Followed =
        Followed { nrmse_percent: 2.0, iou: 0.9, aligned_rmse_mm: Some(1.0), lag_ms: Some(50.0) };

    #[test]
    fn refused_paths_are_reported_and_do_not_count() {
        let other =
            Followed { nrmse_percent: 1.0, iou: 0.8, aligned_rmse_mm: Some(2.0), lag_ms: Some(-20.0) };
        assert_eq!(means(&[Some(ONE), Some(other)]), "1.50, 0.850, 1.50, 15");
        assert_eq!(means(&[Some(ONE), None]), "2.00, 0.900, 1.00, 50 (1 refused)");
        assert_eq!(means(&[None]), "-");
        assert_eq!(FollowedKeys::of(None).lag_ms, None);
        // Deviations of half of the differences.
        assert_eq!(spreads(&[ONE, other], 3), "1.50 ± 0.50, 0.850 ± 0.050, 1.50, 15 (3 refused)");
    }

    #[test]
    fn methods_are_compared_on_the_cases_that_all_have() {
        let methods = ["a", "b", "never run"].map(str::to_owned);
        let cases =
            [vec![Some(1.0), Some(4.0), None], vec![Some(9.0), None, None], vec![Some(3.0), Some(2.0), None]];
        let expected = [("a".to_owned(), 2.0), ("b".to_owned(), 3.0)];
        assert_eq!(paired_means(&methods, &cases), expected);
        assert!(paired_means(&methods, &[]).is_empty());
    }

    #[test]
    fn values_missing_in_a_paper_are_not_shown() {
        let printed = Followed { aligned_rmse_mm: None, lag_ms: None, ..ONE };
        assert_eq!(spreads(&[printed], 0), "2.00 ± 0.00, 0.900 ± 0.000");
    }
}
