//! The page of `study population`.

use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{METHODS, PopulationMetrics, PopulationRobot, assess};
use crate::tendon::numbers::mean;
use crate::tendon::outcome::{StudyMetrics, StudyTable};
use crate::tendon::path_following::{Followed, HEADING, means};

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
            None => line(&robot.robot, &robot.followed().collect::<Vec<_>>()),
        });
        let all = line("all", &self.robots.iter().flat_map(PopulationRobot::followed).collect::<Vec<_>>());
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
        let tile = |quantity: &str, of: fn(&Followed) -> Option<f64>| {
            let row = |(k, method): (usize, &&str)| {
                let of_robot = |robot: &PopulationRobot| {
                    mean(robot.followed().filter_map(|path| of(path.get(k)?.as_ref()?)))
                };
                DotRow::new(*method, self.robots.iter().filter_map(of_robot))
            };
            DotTile::new(quantity, METHODS.iter().enumerate().map(row))
        };
        let plot = DotPlot {
            name: "methods".to_owned(),
            title: "Methods on all robots".to_owned(),
            caption: "How closely the tip follows its targets by every method; a dot for each robot, mean of its paths.".to_owned(),
            tiles: vec![
                tile("NRMSE [%]", |one| Some(one.nrmse_percent)),
                tile("distance at equal times, root mean square [mm]", |one| one.aligned_rmse_mm),
            ],
        };
        folder.add(page, &plot)
    }
}

/// A row of the table: the mean over the paths by every method.
fn line(name: &str, paths: &[Vec<Option<Followed>>]) -> Vec<String> {
    let cell = |method: usize| {
        means(&paths.iter().map(|path| path.get(method).copied().flatten()).collect::<Vec<_>>())
    };
    std::iter::once(name.to_owned()).chain((0..METHODS.len()).map(cell)).collect()
}
