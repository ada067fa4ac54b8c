//! The page of `study convergence`.

use hysteron_report::folder::ReportFolder;
use hysteron_report::page::Page;
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};
use hysteron_report::verdict::Verdict;

use super::outcome::{MeshResolution, ORDERS, assess, rings};
use crate::tendon::numbers::shown;
use crate::tendon::outcome::{StudyMetrics, StudyTable};

impl StudyMetrics for Vec<MeshResolution> {
    const TITLE: &'static str = "Linear and quadratic tetrahedra, finer and finer";
    const ABOUT: &'static str = "One tendon of a tube is pulled on meshes of several sizes. Tendons hold on to points, which sink into ever \
         smaller elements, or to rings of a given size, which do not.";

    fn verdict(&self) -> Verdict {
        assess(self)
    }

    fn tables(&self) -> Vec<StudyTable> {
        let strokes = self.first().map_or([0.0; 3], |one| one.stroke_mm);
        let at = strokes.iter().flat_map(|mm| [format!("Tip at {mm:.0} mm [mm]"), "Tension [N]".to_owned()]);
        let first = ["Tendon on", "Mesh", "Order", "Unknowns"].map(str::to_owned);
        let headings = first.into_iter().chain(at).chain(["Reached [mm]".to_owned()]);
        let title = "Deflection of the tip and tension of the pulled tendon";
        vec![StudyTable::new(title, headings, self.iter().map(cells))]
    }

    fn show(&self, folder: &ReportFolder<'_>, page: &mut Page) -> anyhow::Result<()> {
        let tile = |quantity: &str, of: fn(&MeshResolution) -> [Option<f64>; 3]| {
            let line = |ring: f64, (order, name): (u32, &str)| {
                let all = self.iter().filter(|one| one.is_refined(order, ring));
                let points = all.map(|one| (one.n_unknowns as f64, of(one)[0].unwrap_or(f64::NAN)));
                let (x, y): (Vec<f64>, Vec<f64>) = points.unzip();
                (format!("{name}, {}", carrier(ring)), x, y)
            };
            let lines = rings(self).into_iter().flat_map(|ring| ORDERS.map(|order| line(ring, order)));
            Scatter {
                x_name: "unknowns".to_owned(),
                y_name: quantity.to_owned(),
                marks: lines.enumerate().map(|(k, (name, x, y))| Marks::line(name, k, &x, &y)).collect(),
            }
        };
        let stroke = self.first().map_or(0.0, |one| one.stroke_mm[0]);
        let chart = ScatterChart {
            name: "refinement".to_owned(),
            title: "Refinement of a tube".to_owned(),
            caption: format!(
                "Deflection of the tip, and tension of the pulled tendon, at a stroke of {stroke:.0} mm over the number of unknowns, for linear \
                 and quadratic tetrahedra with tendons on points or on rings."
            ),
            tiles: vec![
                tile("deflection of the tip [mm]", |one| one.deflection_mm),
                tile("tension [N]", |one| one.tension_n),
            ],
        };
        folder.add(page, &chart)
    }
}

/// Carrier of a tendon, by the radius of its rings [mm].
fn carrier(ring_mm: f64) -> &'static str {
    if ring_mm > 0.0 { "ring" } else { "point" }
}

/// A row of the table.
fn cells(one: &MeshResolution) -> Vec<String> {
    let mut row = vec![carrier(one.ring_mm).to_owned(), one.mesh.clone()];
    row.extend([one.order.to_string(), one.n_unknowns.to_string()]);
    let pairs = one.deflection_mm.iter().zip(&one.tension_n);
    row.extend(pairs.flat_map(|(deflection, tension)| [shown(*deflection, 3), shown(*tension, 3)]));
    row.push(format!("{:.1}", one.reached_mm));
    row
}
