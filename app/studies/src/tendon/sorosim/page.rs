//! The page of `study sorosim`.

use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};
use hysteron_report::verdict::Verdict;

use super::outcome::{ErrorStatistics, RodResolution, assess};
use crate::tendon::outcome::{StudyMetrics, StudyTable};

/// A number of the errors at a station.
type Statistic = fn(&ErrorStatistics) -> f64;

impl StudyMetrics for Vec<RodResolution> {
    const TITLE: &'static str = "Shapes of a loaded rod compared with SoRoSim";
    const ABOUT: &'static str = "Static shapes of a rod under gravity, a wrench at mid-length and one at the tip, by the rod solver SoRoSim and \
         by quadratic tetrahedra. Errors are distances of the centre line over the length.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let headings = ["Sides", "Layers", "Station", "Median [%]", "Mean [%]", "95 % [%]", "Largest [%]"];
        let rows = self.iter().flat_map(|one| {
            one.error_percent_of_length.named().map(|(station, errors)| {
                let ErrorStatistics { median, mean, p95, max } = *errors;
                let names = [one.sides.to_string(), one.layers.to_string(), station.to_owned()];
                names.into_iter().chain([median, mean, p95, max].map(|value| format!("{value:.4}"))).collect()
            })
        });
        let effort = self.iter().map(|one| {
            vec![
                one.sides.to_string(),
                one.layers.to_string(),
                one.n_unknowns.to_string(),
                one.shapes.to_string(),
                format!("{:.0}", one.seconds_on_two_threads),
                format!("{:.1}", one.iterations_per_shape),
                format!("{:.1e}", one.worst_relative_residual),
            ]
        });
        let effort_headings = [
            "Sides",
            "Layers",
            "Unknowns",
            "Shapes",
            "Time on two threads [s]",
            "Iterations",
            "Worst residual [-]",
        ];
        vec![
            StudyTable::new("Errors over the length", headings, rows),
            StudyTable::new("Computation", effort_headings, effort),
        ]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let x: Vec<f64> = self.iter().map(|one| f64::from(one.layers)).collect();
        let names = self.first().map(|one| one.error_percent_of_length.named().map(|(name, _)| name));
        let statistics: [(&str, Statistic); 3] =
            [("median", |own| own.median), ("95 %", |own| own.p95), ("largest", |own| own.max)];
        let tile = |(station, name): (usize, &str)| Scatter {
            x_name: "layers".to_owned(),
            y_name: format!("error at {name} [% of the length]"),
            marks: statistics
                .iter()
                .enumerate()
                .map(|(k, (name, of))| {
                    let errors = self.iter().map(|one| of(one.error_percent_of_length.named()[station].1));
                    Marks::bars(*name, k, x.iter().zip(errors).map(|(x, y)| [*x, y, 0.0]).collect())
                })
                .collect(),
        };
        let chart = ScatterChart {
            name: "errors".to_owned(),
            title: "Distance from the reference".to_owned(),
            caption: "Distance of the centre line from that of SoRoSim over the number of layers of the mesh: median, 95 % and largest of all \
                      shapes."
                .to_owned(),
            tiles: names.into_iter().flatten().enumerate().map(tile).collect(),
        };
        folder.add(page, &chart)
    }
}
