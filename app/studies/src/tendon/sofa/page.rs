//! The page of `study sofa`.

use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};
use hysteron_report::verdict::Verdict;

use super::outcome::{Comparison, assess};
use crate::tendon::outcome::{StudyMetrics, StudyTable};

impl StudyMetrics for Vec<Comparison> {
    const TITLE: &'static str = "Tip and tension compared with SOFA";
    const ABOUT: &'static str = "One tendon of a tube is pulled, in SOFA and in the twin, on the same mesh. Differences are the largest of all \
         strokes up to the one that is named: distance of the tips, and difference of the tips' distances from rest, over the deflection; \
         difference of the tensions over the tension. SOFA's law `polar` takes its frames from edges; the other rows compare one law with another.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let headings = ["Comparison", "Up to [mm]", "Tip [-]", "Deflection [-]", "Tension [-]"];
        let row = |one: &Comparison| {
            let values = [one.worst_tip, one.worst_deflection, one.worst_tension];
            let names = [one.comparison.clone(), format!("{:.1}", one.to_stroke_mm)];
            names.into_iter().chain(values.map(|value| format!("{value:.2e}"))).collect()
        };
        vec![StudyTable::new("Worst relative differences", headings, self.iter().map(row))]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let groups: Vec<&[Comparison]> = self.chunk_by(|a, b| a.comparison == b.comparison).collect();
        let tile = |quantity: &str, of: fn(&Comparison) -> f64| {
            let line = |(k, group): (usize, &&[Comparison])| {
                let x: Vec<f64> = group.iter().map(|one| one.to_stroke_mm).collect();
                let y: Vec<f64> = group.iter().map(|one| 100.0 * of(one)).collect();
                Marks::line(group.first().map_or("", |one| &one.comparison), k, &x, &y)
            };
            Scatter {
                x_name: "strokes up to [mm]".to_owned(),
                y_name: quantity.to_owned(),
                marks: groups.iter().enumerate().map(line).collect(),
            }
        };
        let chart = ScatterChart {
            name: "differences".to_owned(),
            title: "Worst differences from SOFA".to_owned(),
            caption: "Largest difference of all strokes up to the one on the horizontal axis: of the tips over the deflection, and of the \
                      tensions of the pulled tendon over the tension."
                .to_owned(),
            tiles: vec![
                tile("tip [% of the deflection]", |one| one.worst_tip),
                tile("tension [%]", |one| one.worst_tension),
            ],
        };
        folder.add(page, &chart)
    }
}
