//! The page of `study sensing`.

use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{SensedRobot, SensingMetrics, assess};
use crate::tendon::outcome::{StudyMetrics, StudyTable};

impl StudyMetrics for SensingMetrics {
    const TITLE: &'static str = "Forces without force sensors";
    const ABOUT: &'static str = "Tensions and pushes estimated from recordings of virtual robots whose true forces are known. Each robot is \
         calibrated from recordings of its own, the sensor is fitted on further ones and evaluated on others.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        vec![tensions(&self.robots), forces(&self.robots), contacts(&self.robots)]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let tensions = self.robots.iter().map(|one| {
            let scores = &one.scores.tensions;
            let rows = scores.iter().map(|score| DotRow::new(score.method.as_ref(), [100.0 * score.all]));
            DotTile::new(format!("{}: error of the tensions [% of their size]", one.robot), rows)
        });
        let forces = self.robots.iter().map(|one| {
            let scores = &one.scores.forces;
            let rows = scores
                .iter()
                .map(|score| DotRow::new(format!("{}, {}", score.method, score.samples), [score.rms_n]));
            DotTile::new(format!("{}: error of a push [N]", one.robot), rows)
        });
        let plot = DotPlot {
            name: "methods".to_owned(),
            title: "Errors of tensions and pushes by method".to_owned(),
            caption: "Root mean square error of the tensions over their root mean square, and root mean square error of a push that has lasted, \
                      robot by robot."
                .to_owned(),
            tiles: tensions.chain(forces).collect(),
        };
        folder.add(page, &plot)
    }
}

fn tensions(robots: &[SensedRobot]) -> StudyTable {
    let rows = robots.iter().flat_map(|one| {
        one.scores.tensions.iter().map(|score| {
            let values = [score.all, score.moving, score.resting].map(|part| format!("{:.1}", 100.0 * part));
            [vec![one.robot.clone(), score.method.clone().into_owned()], values.to_vec()].concat()
        })
    });
    let headings = ["Robot", "Method", "All [%]", "Moving [%]", "At rest [%]"];
    StudyTable::new("Error of the tensions over their root mean square", headings, rows)
}

fn forces(robots: &[SensedRobot]) -> StudyTable {
    let rows = robots.iter().flat_map(|one| {
        one.scores.forces.iter().map(|score| {
            vec![
                one.robot.clone(),
                score.method.clone().into_owned(),
                score.samples.clone().into_owned(),
                score.n.to_string(),
                format!("{:.3}", score.rms_n),
                format!("{:.3}", score.median_n),
                format!("{:.0}", 100.0 * score.near),
                format!("{:.0}", 100.0 * score.aligned),
            ]
        })
    });
    let headings = [
        "Robot",
        "Method",
        "Samples",
        "Number",
        "RMS [N]",
        "Median [N]",
        "Within 30 mN or 15 % [%]",
        "Direction within 15° [%]",
    ];
    StudyTable::new("Error of a push that has lasted", headings, rows)
}

fn contacts(robots: &[SensedRobot]) -> StudyTable {
    let rows = robots.iter().filter_map(|one| {
        let found = one.scores.contacts.as_ref()?;
        Some(vec![
            one.robot.clone(),
            found.contacts.to_string(),
            format!("{:.0}", 100.0 * found.found_at_once),
            format!("{:.0}", 100.0 * found.strong_found_at_once),
            format!("{:.1}", found.false_alarms_per_hour),
            format!("{:.0} in {:.0} s", one.without_contact.alarms, one.without_contact.seconds),
        ])
    });
    let headings = [
        "Robot",
        "Contacts",
        "Found within 100 ms [%]",
        "Above 0.15 N [%]",
        "False alarms [1/h]",
        "Alarms in recordings without contact",
    ];
    StudyTable::new("Contacts", headings, rows)
}
