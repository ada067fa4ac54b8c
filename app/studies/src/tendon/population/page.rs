//! The page of `study population`.

use hysteron_report::dot_plot::DotPlot;
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{METHODS, PopulationMetrics, PopulationRobot, assess};
use crate::tendon::outcome::{StudyMetrics, StudyTable};
use crate::tendon::path_following::{HEADING, error_tiles, row_of_means};

impl StudyMetrics for PopulationMetrics {
    const TITLE: &'static str = "Robots of a wide population";
    const ABOUT: &'static str = "Robots that are known from their recordings alone, by one procedure for all: record, fit, calibrate, generate, \
         train. Paths are in no training. A robot on which a stage failed is named.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let paths = self.robots.iter().find_map(|robot| robot.paths.as_ref());
        let targets: Vec<&str> = paths.into_iter().flatten().map(|path| &path.target[..]).collect();
        let robots = self.robots.iter().map(|robot| match &robot.failed {
            Some(_) => [vec![robot.robot.clone()], vec!["failed".to_owned(); METHODS.len()]].concat(),
            None => row_of_means(&robot.robot, &robot.followed().collect::<Vec<_>>(), METHODS.len()),
        });
        let all = row_of_means(
            "all",
            &self.robots.iter().flat_map(PopulationRobot::followed).collect::<Vec<_>>(),
            METHODS.len(),
        );
        let headings = std::iter::once("Robot").chain(METHODS);
        let title = format!("{HEADING}: mean of {}", targets.join(", "));
        let mut tables = vec![StudyTable::new(title, headings, robots.chain([all]))];
        let failed: Vec<Vec<String>> = self
            .robots
            .iter()
            .filter_map(|robot| {
                Some(vec![robot.robot.clone(), robot.failed.as_ref()?.lines().next()?.to_owned()])
            })
            .collect();
        if !failed.is_empty() {
            tables.push(StudyTable::new("Robots on which a stage failed", ["Robot", "Error"], failed));
        }
        tables
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let robots: Vec<_> = self.robots.iter().map(|robot| robot.followed().collect()).collect();
        let plot = DotPlot {
            name: "methods".to_owned(),
            title: "Methods on all robots".to_owned(),
            caption: "How closely the tip follows its targets by every method; a dot for each robot, mean of its paths.".to_owned(),
            tiles: error_tiles(&METHODS, &robots),
        };
        folder.add(page, &plot)
    }
}
