//! Writes a page with every kind of block, at its limits, to a folder: `cargo run --example blocks -- FOLDER`.

use std::f64::consts::TAU;
use std::path::PathBuf;

use hysteron_report::dot_plot::{DotPlot, DotRow, DotTile};
use hysteron_report::error_path::{ErrorPath, ErrorPaths};
use hysteron_report::figure::{drawn, register_embedded_font};
use hysteron_report::heat_map::HeatMap;
use hysteron_report::lines::{Curve, PanelScale, Shaded, TimeChart, TimePanel};
use hysteron_report::overlay::{OverlayTile, PathKind, PathOverlay};
use hysteron_report::page::{Page, write_page};
use hysteron_report::path_views::{PathViews, SpacePath};
use hysteron_report::scatter::{Marks, Scatter, ScatterChart};
use hysteron_report::series::numbered_panels;
use hysteron_report::stick_figure::StickFigure;
use hysteron_report::target_map::{TargetMap, TargetPoint};
use hysteron_report::verdict::{Criterion, Verdict};

fn main() -> anyhow::Result<()> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "target/blocks".to_owned()));
    std::fs::create_dir_all(&folder)?;
    register_embedded_font()?;
    let verdict = Verdict::on("the blocks can be read")
        .because(Criterion::ErrorOverSpread, 0.6, "the tip is off by 60 % of its spread")
        .because(Criterion::SingleRepeat, 1.0, "there is one repeat")
        .verdict();
    let mut page =
        Page::with_verdict("Every kind of block", &verdict, "What pages consist of.", "blocks FOLDER");
    tables(&mut page);
    page.heading("Figures");
    for chart in time_charts() {
        page.figure(&drawn(&chart)?);
    }
    for chart in scatter_charts() {
        page.figure(&drawn(&chart)?);
    }
    page.figure(&drawn(&dot_plot())?);
    paths(&mut page)?;
    page.details(
        "File",
        "a = 1\nb = \"a long line of a file, which is broken where the window ends, at any letter\"",
    );
    page.small("Sum 0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef.");
    write_page(&folder, page.finish("0000000"))
}

fn tables(page: &mut Page) {
    page.heading("Results");
    page.list([
        ("Duration [s]", "12.50".to_owned()),
        ("Largest distance from the measured tip [mm]", "-0.000".to_owned()),
        ("Source", "a/folder/with/a/long/name/and/a/recording-of-the-robot.parquet, measured".to_owned()),
    ]);
    let headings = [
        "Motor",
        "Viscous friction [N m s/rad]",
        "Coulomb friction [N m]",
        "Load scale [-]",
        "Standard error",
        "Where from",
    ];
    let row = |k: usize| {
        let mut row: Vec<String> = (1..5).map(|c| format!("{:.3e}", 0.37 * (k * c) as f64)).collect();
        row.insert(0, format!("shoulder-pan-{k}"));
        row.push("fitted to twelve recordings of the arm, none of them with a payload".to_owned());
        row
    };
    page.table(&headings, (0..4).map(row));
}

fn time_charts() -> Vec<TimeChart> {
    let time: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
    let wave = |size: f64, k: usize| -> Vec<f64> {
        time.iter().map(|t| size * (1.0 + 0.2 * k as f64) * (TAU * 0.1 * t + 0.6 * k as f64).sin()).collect()
    };
    let chart = |name: &str, caption: &str, panels| TimeChart::over_time(name, name, caption, &time, panels);
    let tip = |size: f64, label: &str| {
        let names = ["measured", "uncorrected twin", "twin with auxiliary tendons"];
        let curves = names.iter().enumerate().map(|(k, name)| Curve::new(*name, k, wave(size, k)));
        TimePanel::new(label, curves.collect())
    };
    let tips = vec![tip(12.0, "tip x [mm]"), tip(3e-5, "tip y [mm]"), tip(4e6, "tip z [mm]")];
    let shaded = Shaded { name: "filled in".to_owned(), spans: vec![[3.0, 4.0], [11.0, 11.4]] };
    let strokes = numbered_panels("stroke [mm]", "tendon", (0..36).map(|k| wave(5.0, k)).collect());
    let runs = (0..16).map(|k| Curve::new(format!("run {k}"), k, wave(1e-3, k))).collect();
    let far = wave(0.04, 0).into_iter().map(|value| 123.4 + value).collect();
    vec![
        TimeChart { shaded: vec![shaded], ..chart("Tip", "Three axes over time [s].", tips) },
        TimeChart { scale: PanelScale::Common, ..chart("Strokes", "All tendons over time [s].", strokes) },
        chart("Runs", "More curves than colours, over time [s].", vec![TimePanel::new("error [mm]", runs)]),
        chart(
            "Far from zero",
            "A small change of a large value, whose name is longer than a phone is wide.",
            vec![TimePanel::new(
                "distance of the camera from the base of the robot [mm]",
                vec![Curve::new("camera", 0, far)],
            )],
        ),
    ]
}

fn scatter_charts() -> Vec<ScatterChart> {
    let x: Vec<f64> = (0..400).map(|i| -2.0 + 0.01 * f64::from(i)).collect();
    let y = |k: usize| -> Vec<f64> { x.iter().map(|x| 0.02 * (k as f64 + 1.0) * (x * 3.0).sin()).collect() };
    let tile = |marks| Scatter { x_name: "joint speed [rad/s]".into(), y_name: "torque [N m]".into(), marks };
    let cloud = || tile(vec![Marks::dots("measured", 6, &x, &y(0)), Marks::line("model", 0, &x, &y(1))]);
    let bars = (1..6).map(|k| [f64::from(k), 0.1 * f64::from(k), 0.05]).collect();
    let chart = |title: &str, tiles| ScatterChart {
        name: title.to_owned(),
        title: title.to_owned(),
        caption: "One quantity over another.".to_owned(),
        tiles,
    };
    vec![
        chart("Cloud", vec![cloud()]),
        chart("Clouds", (0..5).map(|_| cloud()).collect()),
        chart("Bars", vec![tile(vec![Marks::bars("joints", 1, bars)])]),
    ]
}

fn dot_plot() -> DotPlot {
    let names = ["regression", "kernel on two positions of the tip, each with a delay of its own", "network"];
    let row = |(k, name): (usize, &&str)| {
        DotRow::new(*name, (0..6).map(|seed| 3.0 - 0.8 * k as f64 + 0.1 * f64::from(seed)))
    };
    let tile = |quantity: &str| DotTile::new(quantity, names.iter().enumerate().map(row));
    DotPlot {
        name: "methods".to_owned(),
        title: "Methods".to_owned(),
        caption: "A row for each method, a dot for each repeat.".to_owned(),
        tiles: vec![
            tile("error of the tip [mm]"),
            tile("error of the strokes, root mean square of all tendons [mm]"),
        ],
    }
}

/// A rose of so many millimetres.
fn rose(size: f64) -> Vec<(f64, f64)> {
    let point = |k: u32| {
        let angle = TAU * f64::from(k) / 600.0;
        let far = size * (2.0 * angle).cos();
        (far * angle.cos(), far * angle.sin())
    };
    (0..=600).map(point).collect()
}

fn paths(page: &mut Page) -> anyhow::Result<()> {
    let texts = || ["path", "Paths", "One path over another, from above [mm]."].map(str::to_owned);
    let tile = |k: usize| OverlayTile {
        title: format!("a-recording-with-a-long-name-{k}"),
        note: "diamond 0.873, return error 12.34 %".to_owned(),
        paths: vec![rose(20.0), rose(19.0)],
    };
    let kinds = vec![PathKind::new("command, scaled", 4, 3.0), PathKind::new("tip", 0, 1.2)];
    let [name, title, caption] = texts();
    page.figure(&drawn(&PathOverlay { name, title, caption, kinds, tiles: (0..4).map(tile).collect() })?);
    let errors = |k: usize| ErrorPath {
        name: format!("recording {k}"),
        path: rose(18.0 + k as f64),
        errors: rose(2.0).iter().map(|(x, y)| x.hypot(*y)).collect(),
    };
    let [name, title, caption] = texts();
    let paths = vec![errors(1), errors(2)];
    page.figure(&drawn(&ErrorPaths { name, title, caption, target: rose(20.0), paths })?);
    let goal = |(k, at): (usize, (f64, f64))| {
        let missed_at = (k % 3 == 0).then_some((0.9 * at.0, 0.9 * at.1));
        TargetPoint { at, missed_at }
    };
    let goals = Some(rose(20.0).into_iter().step_by(20).enumerate().map(goal).collect());
    let [name, title, caption] = texts();
    let transits = vec![vec![(0.0, 0.0), (20.0, 0.0)]];
    page.figure(&drawn(&TargetMap { name, title, caption, curve: rose(20.0), transits, goals })?);
    let groups = vec![("circles of the tip".to_owned(), rose(20.0)), ("roses".to_owned(), rose(12.0))];
    let outline = vec![(-20.0, -20.0), (20.0, -20.0), (0.0, 20.0)];
    let [name, title, caption] = texts();
    let mut map = HeatMap::new(name, title, groups, ("convex hull", outline));
    map.caption = caption;
    page.figure(&drawn(&map)?);
    in_space(page)
}

fn in_space(page: &mut Page) -> anyhow::Result<()> {
    let texts = || ["space", "Paths in space", "A path from three sides [mm]."].map(str::to_owned);
    let path = |name: &str, size: f64| {
        let (x, y): (Vec<f64>, Vec<f64>) = rose(size).into_iter().unzip();
        let z = x.iter().map(|x| 80.0 - 0.02 * x * x).collect();
        SpacePath { name: name.to_owned(), axes: [x, y, z] }
    };
    let [name, title, caption] = texts();
    page.figure(&drawn(&PathViews {
        name,
        title,
        caption,
        path: path("simulated", 20.0),
        goals: Some(path("goals", 20.5)),
        reference: Some(path("measured", 19.5)),
        time: [0.0, 12.5],
    })?);
    let pose = |k: usize| {
        let lean = 0.1 * k as f64;
        (0.5 * k as f64, vec![[[0.0; 3], [0.0, 0.0, 0.2]], [[0.0, 0.0, 0.2], [lean, 0.5 * lean, 0.4]]])
    };
    let [name, title, caption] = texts();
    page.figure(&drawn(&StickFigure { name, title, caption, poses: (0..7).map(pose).collect() })?);
    Ok(())
}
