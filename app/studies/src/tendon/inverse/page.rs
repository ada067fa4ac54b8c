//! The page of `study inverse`.

use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::verdict::Verdict;

use super::outcome::{InverseMetrics, InverseTest, PathDifference, TrunkResult, assess};
use crate::tendon::numbers::{mean, rms, shown};
use crate::tendon::outcome::{StudyMetrics, StudyTable};

impl StudyMetrics for InverseMetrics {
    const TITLE: &'static str = "Strokes of recorded robots from the paths of their tips";
    const ABOUT: &'static str = "Motor angles of a trunk, and strokes of a three-segment robot, found from the path of the tip by regressions, a \
         kernel and a network; on blocks and patterns that were in no training.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let of_test = |InverseTest { what, unit, methods, errors }: InverseTest<'_>| {
            let row = |(k, name): (usize, &String)| {
                let values = || errors.iter().map(move |row| row[k]);
                let average = mean(values()).unwrap_or(f64::NAN);
                let spread = rms(values().map(|value| value - average));
                vec![name.clone(), format!("{average:.3} ± {spread:.3}")]
            };
            let headings = ["Method".to_owned(), format!("Error [{unit}]")];
            StudyTable::new(capitalised(what), headings, methods.iter().enumerate().map(row))
        };
        let tests = self.tests().into_iter().map(of_test);
        let trunk = self.trunk.iter().flat_map(|one| [delays(one), under_load(&one.path_under_load)]);
        tests.chain(trunk).collect()
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let tile = |InverseTest { what, unit, methods, errors }: InverseTest<'_>| {
            let row = |(k, name): (usize, &String)| DotRow::new(name, errors.iter().map(move |row| row[k]));
            DotTile::new(format!("{what}: error [{unit}]"), methods.iter().enumerate().map(row))
        };
        let plot = DotPlot {
            name: "methods".to_owned(),
            title: "Error of the strokes by method".to_owned(),
            caption: "Root mean square error of motor angles or strokes; a dot for each seed of the network, or for each fold.".to_owned(),
            tiles: self.tests().into_iter().map(tile).collect(),
        };
        folder.add(page, &plot)
    }
}

/// The text with a capital letter.
fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Delays that methods chose, mean over the seeds.
fn delays(trunk: &TrunkResult) -> StudyTable {
    let row = |(k, name): (usize, &String)| {
        let delay = mean(trunk.delays_s.iter().map(|row| 1e3 * row[k]));
        vec![name.clone(), shown(delay, 0)]
    };
    let rows = trunk.methods.iter().enumerate().map(row);
    StudyTable::new("Trunk, delay of the tip behind the angles", ["Method", "Delay [ms]"], rows)
}

/// The path under load compared with the one without.
fn under_load(path: &PathDifference) -> StudyTable {
    let rows = [
        ("At equal times, root mean square [mm]", path.aligned_rmse_mm, 2),
        ("Lag [s]", path.lag_s, 3),
        ("Chamfer distance [mm]", Some(path.chamfer_mm), 2),
        ("Hausdorff distance [mm]", Some(path.hausdorff_mm), 2),
        ("Fréchet distance [mm]", Some(path.frechet_mm), 2),
    ];
    let rows = rows.map(|(name, value, digits)| vec![name.to_owned(), shown(value, digits)]);
    let title = "Trunk, the path under load compared with the one without, same commands";
    StudyTable::new(title, ["Distance", "Value"], rows)
}
