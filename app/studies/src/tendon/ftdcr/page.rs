//! The page of `study ftdcr`.

use hysteron_base::number::significant;
use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{FoldResult, FtdcrMetrics, assess};
use crate::tendon::outcome::{StudyMetrics, StudyTable};

impl StudyMetrics for FtdcrMetrics {
    const TITLE: &'static str = "A recorded three-segment robot";
    const ABOUT: &'static str = "Tip of a robot driven by nine strokes on patterns that were not fitted, in folds, by a reduced model, \
         regressions, networks and the finite-element twin. The last method is led to the measured tip: what auxiliary tendons could reach.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let folds = (1..=self.folds.len()).map(|k| format!("Fold {k} [mm]"));
        let headings = ["Method".to_owned()].into_iter().chain(folds).chain(["All [mm]".to_owned()]);
        let rows = self.pooled.iter().enumerate().map(|(k, pooled)| {
            let folds = self.folds.iter().map(|fold| fold.rmse_mm[k].rmse_mm);
            let values = folds.chain([pooled.rmse_mm]).map(|error| format!("{error:.2}"));
            std::iter::once(pooled.method.clone()).chain(values).collect()
        });
        vec![
            StudyTable::new("Root mean square error of the tip on held-out patterns", headings, rows),
            parameters(&self.folds),
        ]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let row = |(k, pooled): (usize, &super::MethodError)| {
            DotRow::new(&pooled.method, self.folds.iter().map(|fold| fold.rmse_mm[k].rmse_mm))
        };
        let plot = DotPlot {
            name: "methods".to_owned(),
            title: "Error of the tip by method".to_owned(),
            caption: "Root mean square error of the tip on the patterns that a fold holds out; a dot for each fold.".to_owned(),
            tiles: vec![DotTile::new("RMSE of the tip [mm]", self.pooled.iter().enumerate().map(row))],
        };
        folder.add(page, &plot)
    }
}

/// Parameters of the reduced model, fold by fold; lengths in millimetres.
fn parameters(folds: &[FoldResult]) -> StudyTable {
    let names = folds.first().map_or(&[][..], |fold| &fold.parameters);
    let rows = names.iter().enumerate().map(|(k, parameter)| {
        let name = parameter.name.replace("[m", "[mm");
        let scale = if name == parameter.name { 1.0 } else { 1e3 };
        let values = folds.iter().map(|fold| significant(scale * fold.parameters[k].value, 3));
        std::iter::once(name).chain(values).collect()
    });
    let headings = (1..=folds.len()).map(|k| format!("Fold {k}"));
    let headings = ["Parameter".to_owned()].into_iter().chain(headings);
    StudyTable::new("Fitted parameters of constant curvature", headings, rows)
}
