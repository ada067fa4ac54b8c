//! The page of `study edic`.

use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};
use hysteron_report::verdict::Verdict;

use super::outcome::{EdicMetrics, EdicPath, assess};
use crate::tendon::numbers::{mean, rms};
use crate::tendon::outcome::{StudyMetrics, StudyTable};
use crate::tendon::path_following::{Followed, HEADING, spreads};

impl StudyMetrics for EdicMetrics {
    const TITLE: &'static str = "Ideal paths, open loop";
    const ABOUT: &'static str = "Strokes for ideal paths, found by several methods and carried out on the virtual rig without a sensor; compared \
         with the paper's EDIC (tables II to IV), which was measured on a real robot.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let methods = self.paths.first().map_or(&[][..], |path| &path.methods);
        let names = methods.iter().map(|one| one.method.clone());
        let headings = ["Path".to_owned(), "Paper's EDIC".to_owned()].into_iter().chain(names);
        let row = |path: &EdicPath| {
            let names = [path.path.clone(), spreads(&[paper(path)], 0)];
            let cells = path.methods.iter().map(|one| spreads(&one.followed(), one.seeds_refused));
            names.into_iter().chain(cells).collect()
        };
        let papers: Vec<Followed> = self.paths.iter().map(paper).collect();
        let all = (0..methods.len()).map(|k| {
            let runs = || self.paths.iter().filter_map(|path| path.methods.get(k));
            let followed: Vec<Followed> = runs().flat_map(|one| one.followed()).collect();
            spreads(&followed, runs().map(|one| one.seeds_refused).sum())
        });
        let all = ["mean of those tracked".to_owned(), spreads(&papers, 0)].into_iter().chain(all).collect();
        vec![StudyTable::new(HEADING, headings, self.paths.iter().map(row).chain([all]))]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let sized: Vec<(&str, f64, &EdicPath)> = self.paths.iter().filter_map(sized).collect();
        let groups = sized.chunk_by(|a, b| a.0 == b.0);
        let chart = ScatterChart {
            name: "sizes".to_owned(),
            title: "Error over the size of the path".to_owned(),
            caption: "NRMSE of every method over the size of the path, mean of all runs and their standard deviation; the paper's EDIC as a line."
                .to_owned(),
            tiles: groups.map(tile).collect(),
        };
        folder.add(page, &chart)
    }
}

/// Errors that the paper gives for a path.
fn paper(path: &EdicPath) -> Followed {
    Followed {
        nrmse_percent: path.paper_nrmse_percent,
        iou: path.paper_iou,
        aligned_rmse_mm: None,
        lag_ms: None,
    }
}

/// The shape of a path, its size [mm], and the path.
fn sized(path: &EdicPath) -> Option<(&str, f64, &EdicPath)> {
    let (shape, size) = path.path.split_once(':')?;
    Some((shape, size.parse().ok()?, path))
}

/// All sizes of a shape.
fn tile(paths: &[(&str, f64, &EdicPath)]) -> Scatter {
    let shape = paths.first().map_or("", |(shape, ..)| shape);
    let (x, y): (Vec<f64>, Vec<f64>) =
        paths.iter().map(|(_, size, path)| (*size, path.paper_nrmse_percent)).unzip();
    let methods = paths.first().map_or(&[][..], |(.., path)| &path.methods);
    let marks = methods.iter().enumerate().map(|(k, method)| {
        let point = |(_, size, path): &(&str, f64, &EdicPath)| {
            let values = path.methods.get(k).map_or(&[][..], |one| &one.nrmse_percent);
            let average = mean(values.iter().copied())?;
            Some([*size, average, rms(values.iter().map(|value| value - average))])
        };
        Marks::bars(&method.method, k + 1, paths.iter().filter_map(point).collect())
    });
    Scatter {
        x_name: format!("size of the {shape} [mm]"),
        y_name: "NRMSE [%]".to_owned(),
        marks: std::iter::once(Marks::line("paper's EDIC", 0, &x, &y)).chain(marks).collect(),
    }
}
