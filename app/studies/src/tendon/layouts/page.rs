//! The page of `study layouts`.

use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{LayoutMetrics, LayoutReach, assess};
use crate::tendon::coreact::twin_tiles;
use crate::tendon::outcome::{StudyMetrics, StudyTable};

impl StudyMetrics for LayoutMetrics {
    const TITLE: &'static str = "Fewer auxiliary tendons";
    const ABOUT: &'static str = "The paper's layout of auxiliary tendons compared with fewer, longer ones: in which directions they move the tip, \
         how far from the recorded tip identification leaves it, and how well a network that is trained on it does.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let headings = [
            "Layout",
            "Singular values of ∂tip/∂s* [-]",
            "Largest over smallest [-]",
            "Distance left: median [mm]",
            "99 % [mm]",
        ];
        let row = |one: &LayoutReach| {
            let [first, second, third] = one.singular_values;
            let [median, p99] = one.left_median_p99_mm.map(|value| format!("{value:.3}"));
            let values = format!("{first:.2}, {second:.2}, {third:.3}");
            vec![one.layout.clone(), values, format!("{:.0}", first / third), median, p99]
        };
        let reach = StudyTable::new("Identification", headings, self.layouts.iter().map(row));
        vec![reach, self.ladder.table()]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let tile = |quantity: &str, of: fn(&LayoutReach) -> f64| {
            DotTile::new(quantity, self.layouts.iter().map(|one| DotRow::new(&one.layout, [of(one)])))
        };
        let reach = [
            tile("distance left, median [mm]", |one| one.left_median_p99_mm[0]),
            tile("smallest singular value of ∂tip/∂s* [-]", |one| one.singular_values[2]),
        ];
        let plot = DotPlot {
            name: "layouts".to_owned(),
            title: "Layouts of auxiliary tendons".to_owned(),
            caption: "Distance of the tip that identification leaves, smallest singular value of the tip's motion by the auxiliary tendons, and \
                      NRMSE of the tip with a trained network, mean of the three axes."
                .to_owned(),
            tiles: reach.into_iter().chain(twin_tiles(&self.ladder)).collect(),
        };
        folder.add(page, &plot)
    }
}
