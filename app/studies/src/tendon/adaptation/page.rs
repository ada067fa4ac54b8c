//! The page of `study adaptation`.

use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{AdaptationMetrics, Row, Tip, assess};
use crate::tendon::numbers::shown;
use crate::tendon::outcome::{StudyMetrics, StudyTable};

/// One of the runs of a row.
type TipOf = fn(&Row) -> Option<Tip>;

impl StudyMetrics for AdaptationMetrics {
    const TITLE: &'static str = "A robot that changes";
    const ABOUT: &'static str = "Targets are followed on each robot with the network of the robot as it was, and with what adaptation kept after a \
         minute of its data. The error on the unchanged robot is the least that exact knowledge of the change would leave.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let headings = [
            "Change",
            "Target",
            "Kept",
            "Before: RMSE [mm], at equal times [mm], NRMSE [%]",
            "After a minute of data",
            "Gain at equal times [%]",
            "Unchanged robot at equal times [mm]",
        ];
        let tip = |tip: &Option<Tip>| {
            let text =
                |it: &Tip| format!("{:.2}, {:.2}, {:.2}", it.rmse_mm, it.aligned_rmse_mm, it.nrmse_percent);
            tip.as_ref().map_or_else(|| "-".to_owned(), text)
        };
        let row = |row: &Row| {
            vec![
                row.change.clone(),
                row.target.clone(),
                format!("{:?}", row.kept).to_lowercase(),
                tip(&row.before),
                tip(&row.after),
                shown(row.gain.map(|gain| 100.0 * gain), 0),
                shown(row.unchanged_robot_aligned_rmse_mm, 2),
            ]
        };
        vec![StudyTable::new("Before and after adaptation", headings, self.rows.iter().map(row))]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let times: [(&str, TipOf); 2] = [("before", |row| row.before), ("after", |row| row.after)];
        let changes = self.rows.chunk_by(|a, b| a.change == b.change);
        let rows = changes.flat_map(|rows| {
            times.map(|(time, of)| {
                let change = rows.first().map_or("", |row| &row.change[..]);
                let values = rows.iter().filter_map(of).map(|tip| tip.aligned_rmse_mm);
                DotRow::new(format!("{change}, {time}"), values)
            })
        });
        let plot = DotPlot {
            name: "adaptation".to_owned(),
            title: "Distance from the target before and after adaptation".to_owned(),
            caption:
                "Root mean square distance of the tip from its target at equal times; a dot for each target."
                    .to_owned(),
            tiles: vec![DotTile::new("distance at equal times, root mean square [mm]", rows)],
        };
        folder.add(page, &plot)
    }
}
