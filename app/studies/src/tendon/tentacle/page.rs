//! The page of `study tentacle`.

use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};
use hysteron_report::verdict::Verdict;

use super::outcome::{FittedValue, HoldErrors, ParameterFit, PooledError, TentacleMetrics, assess};
use crate::tendon::numbers::shown;
use crate::tendon::outcome::{StudyMetrics, StudyTable};

impl StudyMetrics for TentacleMetrics {
    const TITLE: &'static str = "A recorded silicone tentacle";
    const ABOUT: &'static str = "Markers of a tentacle that hangs under known tensions, hold by hold: predicted with nominal parameters, with \
         parameters fitted to the other holds, and with residual tensions on top; compared with rod models.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let mut tables = vec![holds(&self.holds), summary(&self.summary)];
        if let Some(found) = &self.fits {
            tables.extend([fits(found), parameters(found)]);
        }
        if let Some(residual) = &self.residual_tensions {
            let rows = residual.readings.iter().map(|one| {
                vec![one.sharing.clone(), format!("{:.2}", one.rmse_mm), shown(one.left_out_rmse_mm, 2)]
            });
            let title = format!("Residual tensions of {} cables", residual.cables);
            let headings = ["Tensions", "Mean of the markers' RMSE [mm]", "One hold left out [mm]"];
            tables.push(StudyTable::new(title, headings, rows));
        }
        tables
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let rows = self.methods().into_iter().map(|(name, error)| DotRow::new(name, [error]));
        let methods = DotPlot {
            name: "methods".to_owned(),
            title: "Error of the markers by method".to_owned(),
            caption: "Mean of the markers' root mean square errors over session B; fitted parameters and shared tensions on holds that were left \
                      out of their fit."
                .to_owned(),
            tiles: vec![DotTile::new("mean of the markers' RMSE [mm]", rows)],
        };
        folder.add(page, &methods)?;
        let marks = |(tendon, name): (usize, &str)| {
            let own = self.holds.iter().filter(|one| one.tensions_n[tendon] > 0.0);
            let points = own.map(|one| [one.tensions_n[tendon], one.rmse_mm, 0.0]).collect();
            Marks::bars(name, tendon, points)
        };
        let holds = ScatterChart {
            name: "holds".to_owned(),
            title: "Error of every hold".to_owned(),
            caption: "Root mean square error of the markers in a hold over the tension of its tendon, nominal parameters.".to_owned(),
            tiles: vec![Scatter {
                x_name: "tension [N]".to_owned(),
                y_name: "RMSE [mm]".to_owned(),
                marks: ["first tendon", "second tendon"].into_iter().enumerate().map(marks).collect(),
            }],
        };
        folder.add(page, &holds)
    }
}

fn holds(holds: &[HoldErrors]) -> StudyTable {
    let headings =
        ["Hold", "Session", "T1 [N]", "T2 [N]", "p1 [mm]", "p2 [mm]", "p3 [mm]", "p4 [mm]", "RMSE [mm]"];
    let row = |one: &HoldErrors| {
        let values = one.tensions_n.iter().chain(&one.marker_error_mm).chain([&one.rmse_mm]);
        let names = [one.hold.to_string(), one.session.clone()];
        names.into_iter().chain(values.map(|value| format!("{value:.2}"))).collect()
    };
    StudyTable::new("Holds with nominal parameters", headings, holds.iter().map(row))
}

fn summary(summary: &[PooledError]) -> StudyTable {
    let headings = ["RMSE [mm]", "This twin", "Own rod model", "Published rod model"];
    let row = |one: &PooledError| {
        let rods = [one.own_rod_mm, one.published_rod_mm].map(|error| shown(error, 1));
        [vec![one.over.clone(), format!("{:.2}", one.rmse_mm)], rods.to_vec()].concat()
    };
    StudyTable::new("Errors over the holds", headings, summary.iter().map(row))
}

fn fits(fits: &[ParameterFit]) -> StudyTable {
    let row = |fit: &ParameterFit| {
        let errors = [fit.mean_of_markers_rmse_mm, fit.left_out_mean_of_markers_rmse_mm];
        let end = if fit.converged { "converged" } else { "not converged" };
        let errors = errors.map(|error| format!("{error:.2}"));
        [vec![fit.set.clone()], errors.to_vec(), vec![end.to_owned()]].concat()
    };
    let headings = ["Parameters", "Mean of the markers' RMSE [mm]", "One hold left out [mm]", "Fit"];
    StudyTable::new("Fits on the holds of session B", headings, fits.iter().map(row))
}

fn parameters(fits: &[ParameterFit]) -> StudyTable {
    let row = |set: &str, one: &FittedValue| {
        let error = one.standard_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.2e}"));
        let standing = if one.is_fitted { "fitted" } else { "not determined" };
        let values = [one.start, one.value].map(|value| format!("{value:.4e}"));
        [vec![set.to_owned(), one.name.clone()], values.to_vec(), vec![error, standing.to_owned()]].concat()
    };
    let rows = fits.iter().flat_map(|fit| fit.parameters.iter().map(|one| row(&fit.set, one)));
    let headings = ["Parameters", "Name", "Start", "Value", "Standard error", ""];
    StudyTable::new("Fitted parameters", headings, rows)
}
