//! The page of `study coreact`, and the figure of a table of twins that other studies have too.

use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{CoreactMetrics, TwinErrors, TwinTable, assess};
use crate::tendon::numbers::rms;
use crate::tendon::outcome::{StudyMetrics, StudyTable};

impl StudyMetrics for CoreactMetrics {
    const TITLE: &'static str = "CoReAct end to end on the virtual rig";
    const ABOUT: &'static str = "Record, identify, train, roll out: twins without and with friction, without and with the residual network, and \
         with the paper's network, on trajectories that nothing was trained on.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let ratios = &self.stability.ratio_to_bare;
        let largest = ratios.iter().copied().fold(f64::NAN, f64::max);
        let row = [
            ratios.len().to_string(),
            format!("{:.2}", rms(ratios.iter().copied())),
            format!("{largest:.2}"),
            self.stability.worse_by_10_percent.len().to_string(),
        ];
        let headings =
            ["Plans", "Error over that without a network, rms [-]", "Largest [-]", "Worse by more than 10 %"];
        let stability = StudyTable::new("Rollouts on random plans", headings, [row.to_vec()]);
        self.ladders.iter().map(TwinTable::table).chain([stability]).collect()
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let ratios = DotRow::new("with the network", self.stability.ratio_to_bare.iter().copied());
        let stability = DotTile::new("random plans: error over that without a network [-]", [ratios]);
        let plot = DotPlot {
            name: "twins".to_owned(),
            title: "Twins on test trajectories".to_owned(),
            caption: "NRMSE of the tip on test trajectories, mean of the three axes; a dot for each seed of the network. Last, rollouts on random \
                      plans, a dot for each plan."
                .to_owned(),
            tiles: self.ladders.iter().flat_map(twin_tiles).chain([stability]).collect(),
        };
        folder.add(page, &plot)
    }
}

/// A tile for each test of a table: a row for each twin, a dot for each repeat.
pub(crate) fn twin_tiles(table: &TwinTable) -> Vec<DotTile> {
    let tests = table.twins.first().map_or(&[][..], |twin| &twin.nrmse);
    let tile = |(k, test): (usize, &super::PathErrors)| {
        let row = |twin: &TwinErrors| {
            let [x, y, z] = twin.nrmse[k].axes();
            let means = x.iter().zip(y).zip(z).map(|((x, y), z)| (x + y + z) / 3.0);
            DotRow::new(&twin.twin, means)
        };
        DotTile::new(format!("{}, {}: NRMSE [%]", table.robot, test.path), table.twins.iter().map(row))
    };
    tests.iter().enumerate().map(tile).collect()
}
