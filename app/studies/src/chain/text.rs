//! Text of a study's report, and its tables.

use std::path::Path;

use super::definition::{Study, Track};
use super::method::Method;
use super::outcome::Tracked;
use super::stage::Stage;
use hysteron_report::page::Page;

pub const ABOUT: &str = "Tendons bend a continuum robot. When a tendon is pulled and released again, the tip does not return on \
the same path: friction, slack, backlash and creep cause hysteresis, and every path that is computed without it is missed. A \
study records the robot, calibrates its digital twin on the recordings, and computes the strokes that lead the tip along \
test paths. The rig carries these strokes out open loop, and the tip is measured.";

pub const TWIN: &str = "The twin is a finite-element model of the body and its tendons. Without its network it has at most the \
friction of its scene, and no creep. An identification finds the strokes of auxiliary tendons that bring the twin's tip to the \
measured one, and a network learns these strokes. The figures show a test path, which was used for no fit.";

pub const TRACKING: &str = "For each path, each method computed the strokes beforehand, and the rig carried them out open loop: the \
measured tip is not fed back. Targets are dashed; the colour of the tip's path is its distance from the target.";

/// Says what measured.
pub fn rig(study: &Study) -> String {
    let (rig, robot) = (&study.rig.description, &study.scene.robot);
    if study.rig.is_virtual {
        format!(
            "The robot is {robot} on the {rig}: a simulation of servos, tendons, body and tracker, with friction, slack, \
             creep and noise that the twin knows nothing of. No hardware was involved, and nothing here says how well \
             a real robot does."
        )
    } else {
        format!("The robot is {robot} on the {rig}, measured.")
    }
}

/// Name of a method in the report, with its explanation.
fn explained(method: Method) -> &'static str {
    match method {
        Method::Nominal => "nominal: the twin without zeros, compliance and friction of its tendons",
        Method::Scene => {
            "scene: the twin with these parameters as in its scene, usually fitted to recordings; no network"
        }
        Method::Twin => "twin: the calibrated twin with its network",
        Method::Network => "network: the inverse network",
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn shown(value: Option<f64>, scale: f64, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{:.digits$}", scale * value))
}

/// Headings of [`numbers`].
const NUMBERS: [&str; 5] = ["RMSE [mm]", "NRMSE [%]", "IoU", "At equal times [mm]", "Lag [ms]"];

/// RMSE, NRMSE, IoU, RMSE at equal times and lag of all repeats of these.
fn numbers<'a>(tracked: impl Iterator<Item = &'a Tracked> + Clone) -> [String; 5] {
    [
        shown(mean(tracked.clone().flat_map(|it| it.rmse_m.iter().copied())), 1e3, 2),
        shown(mean(tracked.clone().flat_map(|it| it.nrmse.iter().flatten().copied())), 100.0, 2),
        shown(mean(tracked.clone().flat_map(|it| it.iou.iter().flatten().copied())), 1.0, 3),
        shown(mean(tracked.clone().flat_map(|it| it.aligned_rmse_m.iter().flatten().copied())), 1e3, 2),
        shown(mean(tracked.flat_map(|it| it.lag_s.iter().flatten().copied())), 1e3, 0),
    ]
}

/// Results, in a table of one line per method: the mean over the paths that the rig ran with all methods.
pub fn outcome(page: &mut Page, track: &Track, tracked: &[Tracked]) {
    let common: Vec<&[Tracked]> = tracked
        .chunks(track.methods.len())
        .filter(|methods| methods.iter().all(Tracked::is_carried_out))
        .collect();
    page.heading("Results");
    if common.is_empty() {
        page.paragraph("No path was completed by all methods; the table below lists those that were.");
        return;
    }
    page.paragraph(&format!(
        "Distance of the tip from the path, over {} that the rig completed with every method: the smaller RMSE, \
         NRMSE and lag, and the nearer IoU to 1, the better.",
        if common.len() == 1 { "the one path".to_owned() } else { format!("the {} paths", common.len()) },
    ));
    let row = |(k, method): (usize, &Method)| {
        let numbers = numbers(common.iter().map(move |methods| &methods[k]));
        [explained(*method).to_owned()].into_iter().chain(numbers).collect()
    };
    let headings = [&["Strokes by"][..], &NUMBERS].concat();
    page.table(&headings, track.methods.iter().enumerate().map(row));
}

/// The table of all paths and methods.
pub fn tracking_table(page: &mut Page, track: &Track, tracked: &[Tracked]) {
    let percent = |part: f64| format!("{:.1}", 100.0 * part);
    let row = |it: &Tracked| {
        let mut cells = vec![it.target.clone(), it.method.name().to_owned()];
        if it.is_carried_out() {
            cells.extend(numbers(std::iter::once(it)));
        } else {
            cells.extend(["not completed", "", "", "", ""].map(str::to_owned));
        }
        cells.extend([percent(it.limited), percent(it.extrapolating)]);
        cells
    };
    let headings = [&["Path", "Strokes by"][..], &NUMBERS, &["Limited [%]", "Outside training [%]"]].concat();
    page.table(&headings, tracked.iter().map(row));
    if track.repeats > 1 {
        page.paragraph(&format!("Means over {} repeats; the figures show the first.", track.repeats));
    }
}

/// Glossary of the columns.
pub fn glossary(page: &mut Page) {
    let rows = [
        ("RMSE", "root mean square distance from points of the path to the tip's nearest, mean of x and y"),
        ("NRMSE", "the same over the width of the path"),
        ("IoU", "area that path and tip both enclose, over the area that either encloses: 1 is perfect"),
        (
            "At equal times",
            "root mean square distance of the tip from the target at the same time; contains the lag",
        ),
        ("Lag", "delay of the tip behind the target"),
        ("Limited", "samples in which a limit reduced a stroke or its rate"),
        ("Outside training", "samples in which the input of a network was outside its training range"),
        ("Not completed", "the rig stopped or did not start: its load or strokes passed a limit"),
    ];
    page.list(rows.map(|(name, text)| (name, text.to_owned())));
}

/// Name and purpose of every stage; those of tracking as one.
pub fn stages(stages: &[Stage]) -> Vec<Vec<String>> {
    let is_tracking = |stage: &&Stage| stage.name.starts_with("track ");
    let row = |stage: &Stage| vec![stage.name.clone(), stage.about.clone()];
    let mut rows: Vec<Vec<String>> = stages.iter().filter(|stage| !is_tracking(stage)).map(row).collect();
    let n = stages.iter().filter(is_tracking).count();
    if n > 0 {
        let about =
            format!("strokes for a path are found, run and measured: {n} times, every path by every method");
        rows.push(vec!["track".to_owned(), about]);
    }
    rows
}

/// Where everything is, and how it was made.
pub fn files(page: &mut Page, stages: &[Stage], out: &Path) {
    page.heading("Commands");
    page.paragraph(&format!(
        "Every stage is one command of the program; each wrote to its own folder in {}. After a change of the study, the \
         same command repeats only the stages that depend on it.",
        out.display()
    ));
    let commands = stages.iter().flat_map(|stage| &stage.steps).map(|step| step.shown());
    page.details("All commands", &commands.collect::<Vec<_>>().join("\n"));
}
