//! The page of `study ablation`.

use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{AblatedRobot, AblationMetrics, LEVELS, assess};
use crate::tendon::numbers::mean;
use crate::tendon::outcome::{StudyMetrics, StudyTable};
use crate::tendon::path_following::{Followed, HEADING, means};

impl StudyMetrics for AblationMetrics {
    const TITLE: &'static str = "The effect of each part of the chain";
    const ABOUT: &'static str = "Every robot is known from a minute of recordings alone. Levels: strokes through the twin without learning, inverse \
         networks on recorded and on hybrid data, the calibrated twin, and that twin after adaptation. No path is in any training.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let targets: Vec<&str> = self
            .robots
            .first()
            .map_or(&[][..], |one| &one.paths)
            .iter()
            .map(|path| &path.target[..])
            .collect();
        let title = format!("{HEADING}: mean of {}", targets.join(", "));
        let headings = std::iter::once("Robot").chain(LEVELS);
        let robots =
            self.robots.iter().map(|robot| line(&robot.robot, &robot.followed().collect::<Vec<_>>()));
        let members = self.robots.iter().filter(|robot| robot.is_member());
        let all = line("population", &members.flat_map(AblatedRobot::followed).collect::<Vec<_>>());
        vec![StudyTable::new(title, headings, robots.chain([all]))]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let tile = |quantity: &str, of: fn(&Followed) -> Option<f64>| {
            let row = |(k, level): (usize, &&str)| {
                let of_robot = |robot: &AblatedRobot| {
                    mean(robot.followed().filter_map(|path| of(path.get(k)?.as_ref()?)))
                };
                DotRow::new(*level, self.robots.iter().filter_map(of_robot))
            };
            DotTile::new(quantity, LEVELS.iter().enumerate().map(row))
        };
        let plot = DotPlot {
            name: "levels".to_owned(),
            title: "Ablation levels".to_owned(),
            caption: "How closely the tip follows its targets at every level of the ablation; a dot for each robot, mean of its paths.".to_owned(),
            tiles: vec![
                tile("NRMSE [%]", |one| Some(one.nrmse_percent)),
                tile("distance at equal times, root mean square [mm]", |one| one.aligned_rmse_mm),
            ],
        };
        folder.add(page, &plot)
    }
}

/// A row of the table: the mean over the paths at every level.
fn line(name: &str, paths: &[Vec<Option<Followed>>]) -> Vec<String> {
    let cell = |level: usize| {
        means(&paths.iter().map(|path| path.get(level).copied().flatten()).collect::<Vec<_>>())
    };
    std::iter::once(name.to_owned()).chain((0..LEVELS.len()).map(cell)).collect()
}
