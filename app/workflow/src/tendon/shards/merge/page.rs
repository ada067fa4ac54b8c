//! The card of a set: counts, coverage of the tip, and every channel.

use hysteron_report::folder::ReportFolder;
use hysteron_report::heat_map::HeatMap;
use hysteron_report::page::Page;

use super::outcome::{ChannelStatistics, FamilySamples, Outcome};
use crate::tendon::shards::coverage::CellCounts;
use crate::tendon::shards::sketch::DataSketch;

/// Writes the figure, `report.html` and `metrics.json` to `folder`; a set without samples has no figure. Cells of the tip have this
/// side [m].
pub(super) fn write(
    folder: &ReportFolder,
    card: &Outcome,
    (data, cell_m): (&DataSketch, f64),
) -> anyhow::Result<()> {
    folder.write_metrics(card)?;
    let about = "Synthetic data, made in shards: trajectories of a plan, simulated by the twin. They are training data and were not \
                 measured on a robot. All numbers are merged from the sketches of the shards; no row was read again.";
    let title = format!("Synthetic data, plan {}", card.plan);
    let mut page = Page::concluded(&title, &card.conclusion(), about, &card.command);
    let percent = |part: f64| format!("{:.1}", 100.0 * part);
    page.heading("Results");
    page.list(vec![
        ("Shards", format!("{} of {}", card.shards - card.missing, card.shards)),
        ("Trajectories", card.made.to_string()),
        ("Left out", card.dropped.to_string()),
        ("Samples", card.samples.to_string()),
        ("Size [GB]", format!("{:.3}", 1e-9 * card.bytes as f64)),
        ("Network outside its training range [% of samples]", percent(card.extrapolating)),
        ("Chain bent further than validated [% of samples]", percent(card.outside_validation)),
        ("Area covered by the tip (convex hull) [cm²]", format!("{:.1}", 1e4 * card.area_m2)),
    ]);
    match card.samples {
        0 => page.paragraph("No figure: there is no sample."),
        _ => folder.add(&mut page, &coverage(card, data, cell_m))?,
    }
    page.heading("Families");
    let family = |(name, one): (&String, &FamilySamples)| {
        vec![name.clone(), one.made.to_string(), one.skipped.to_string(), one.samples.to_string()]
    };
    page.table(&["Family", "Trajectories", "Skipped", "Samples"], card.families.iter().map(family));
    page.heading("Channels");
    page.paragraph("Values in SI units. Quantiles are good to a sixteenth of themselves.");
    let headings = ["Channel", "Smallest", "1 %", "Median", "99 %", "Largest", "Mean", "Standard deviation"];
    let channel = |(name, one): (&String, &ChannelStatistics)| {
        let [low, median, high] = one.quantiles;
        let numbers = [one.smallest, low, median, high, one.largest, one.mean, one.deviation];
        std::iter::once(name.clone()).chain(numbers.map(|x| format!("{x:.4e}"))).collect::<Vec<String>>()
    };
    page.table(&headings, card.channels.iter().map(channel));
    if !card.skipped.is_empty() {
        page.heading("Skipped trajectories");
        let rows = card.skipped.iter().map(|one| vec![one.name.clone(), one.why.clone()]);
        page.table(&["Trajectory", "Why"], rows);
    }
    page.small(&format!("Scene {}. Manifest {}.", card.scene_sha256, card.manifest_sha256));
    folder.write_page(page, &card.commit)
}

/// Where samples of the tip are, from above: a tile for every family.
fn coverage(card: &Outcome, data: &DataSketch, cell_m: f64) -> HeatMap {
    let group = |(family, cells): (&String, &CellCounts)| {
        let made = card.families.get(family).map_or(0, |one| one.made);
        let counts = cells.0.iter().map(|(cell, count)| (*cell, *count as usize)).collect();
        (format!("{family}: {made} trajectories"), counts)
    };
    let hull = data.hull_m.iter().map(|[x, y]| (1e3 * x, 1e3 * y)).collect();
    let outline = ("convex hull of the samples", hull);
    let groups = data.cells.iter().map(group).collect();
    let mut map = HeatMap::of_cells("coverage", "Coverage", groups, 1e3 * cell_m, outline);
    map.caption = format!(
        "Samples of the tip in cells of {:.2} mm, from above [mm], by family of trajectories; the colour scale is logarithmic, all \
         axes have one scale. The line is the convex hull of all samples.",
        map.cell()
    );
    map
}
