//! The page of `study ablation`.

use hysteron_report::dot_plot::DotPlot;
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{AblatedRobot, AblationMetrics, LEVELS, assess};
use crate::tendon::outcome::{StudyMetrics, StudyTable};
use crate::tendon::path_following::{HEADING, error_tiles, row_of_means};

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
        let robots = self
            .robots
            .iter()
            .map(|robot| row_of_means(&robot.robot, &robot.followed().collect::<Vec<_>>(), LEVELS.len()));
        let members = self.robots.iter().filter(|robot| robot.is_member());
        let all = row_of_means(
            "population",
            &members.flat_map(AblatedRobot::followed).collect::<Vec<_>>(),
            LEVELS.len(),
        );
        vec![StudyTable::new(title, headings, robots.chain([all]))]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let robots: Vec<_> = self.robots.iter().map(|robot| robot.followed().collect()).collect();
        let plot = DotPlot {
            name: "levels".to_owned(),
            title: "Ablation levels".to_owned(),
            caption: "How closely the tip follows its targets at every level of the ablation; a dot for each robot, mean of its paths.".to_owned(),
            tiles: error_tiles(&LEVELS, &robots),
        };
        folder.add(page, &plot)
    }
}
