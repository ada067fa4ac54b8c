//! The page of `study robots`.

use hysteron_report::dot_plot::DotPlot;
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{RobotsMetrics, assess};
use crate::tendon::coreact::{TwinTable, twin_tiles};
use crate::tendon::outcome::{StudyMetrics, StudyTable};

impl StudyMetrics for RobotsMetrics {
    const TITLE: &'static str = "The twins of coreact on other robots";
    const ABOUT: &'static str = "Twins of other presets, trained on a third of the recordings; and the twins of the preset typical on robots of \
         the population around it, which were not in their training.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        self.ladders.iter().map(TwinTable::table).collect()
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let plot = DotPlot {
            name: "twins".to_owned(),
            title: "Twins on test trajectories".to_owned(),
            caption: "NRMSE of the tip on test trajectories, mean of the three axes; a dot for each robot."
                .to_owned(),
            tiles: self.ladders.iter().flat_map(twin_tiles).collect(),
        };
        folder.add(page, &plot)
    }
}
