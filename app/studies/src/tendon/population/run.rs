//! The run of `study population`.

use anyhow::Result;
use hysteron_workflow::{Context, WorkflowError};

use super::outcome::{METHODS, PopulationMetrics, PopulationPath, PopulationRobot};
use super::plans::{synthetic_plan, write_nominal_scene, write_recorded_plan};
use crate::tendon::commands::{ChainCommands, Strokes};
use crate::tendon::path_following::{Followed, FollowedKeys, FollowedMethod};
use crate::tendon::session::StudySession;
use crate::tendon::{Outcome, PopulationOptions};

/// Members of the population.
const ROBOTS: u64 = 10;
/// Paths, as far out as the recordings go.
const TARGETS: [&str; 7] =
    ["circle:40", "diamond:40", "square:30", "ellipse:40", "figure_eight:40", "lissajous:36", "rose:40"];
/// Those that a scene is fitted to.
const FITTED: [&str; 3] = ["circle", "square", "rose"];
/// Options of the fit: the scene does not know where the tip rests.
const FIT: [&str; 8] = [
    "--fit",
    "zero,compliance,sheath_exponent,backlash,gravity,tracker",
    "--frame",
    "trust",
    "--step-mm",
    "0.2",
    "--every-mm",
    "0.4",
];

/// How much is done for a robot.
struct PopulationEffort {
    robots: u64,
    targets: &'static [&'static str],
    /// Steps of an evaluation of the fit.
    steps: &'static str,
    /// At most so many epochs of the twin's network, and of the inverse networks.
    twin_epochs: Option<&'static str>,
    inverse_epochs: &'static str,
}

const FULL: PopulationEffort = PopulationEffort {
    robots: ROBOTS,
    targets: &TARGETS,
    steps: "1500",
    twin_epochs: None,
    inverse_epochs: "90",
};
/// Shows that it runs.
const QUICK: PopulationEffort = PopulationEffort {
    robots: 1,
    targets: &["circle:40"],
    steps: "300",
    twin_epochs: Some("3"),
    inverse_epochs: "3",
};

/// One robot: for every path what each method came to, none where the rig would not carry the strokes out; or why there
/// is nothing.
struct Robot {
    name: String,
    found: Result<Vec<Row>, String>,
}

type Row = [Option<Followed>; METHODS.len()];

impl Robot {
    fn result(&self, targets: &[&str]) -> PopulationRobot {
        let method = |(method, cell): (&&str, &Option<Followed>)| FollowedMethod {
            method: (*method).to_owned(),
            followed: FollowedKeys::of(cell.as_ref()),
        };
        let path = |(target, row): (&&str, &Row)| PopulationPath {
            target: (*target).to_owned(),
            methods: METHODS.iter().zip(row).map(method).collect(),
        };
        PopulationRobot {
            robot: self.name.clone(),
            paths: self.found.as_ref().ok().map(|rows| targets.iter().zip(rows).map(path).collect()),
            failed: self.found.as_ref().err().cloned(),
        }
    }
}

/// Runs the study on as many members as are asked for, or on all that are left; quick: one robot, one path, few steps
/// and epochs.
///
/// # Errors
/// Refusals of the file system, or an interruption.
pub fn run(
    options: &PopulationOptions,
    context: &Context,
) -> Result<Outcome<PopulationMetrics>, WorkflowError> {
    let PopulationOptions { robots, first, shared } = options;
    let session = StudySession::begin("population", &shared.out, context)?;
    let effort = if shared.quick { QUICK } else { FULL };
    let last = robots.map_or(effort.robots.max(*first), |robots| first.saturating_add(robots) - 1);
    let mut all = Vec::new();
    let mut outcome = session.write(PopulationMetrics { robots: Vec::new() })?;
    for member in *first..=last {
        let name = format!("wide/{member}");
        tracing::info!("{name}");
        let folder = shared.out.join(name.replace('/', "-"));
        let chain = ChainCommands::new(&folder, &shared.repository, context)?;
        let found = match known_from_recordings(&chain, &name, &effort).map_err(WorkflowError::from) {
            Err(error @ WorkflowError::Cancelled(_)) => return Err(error),
            other => other.map_err(|error| error.to_string()),
        };
        all.push(Robot { found, name: name.clone() });
        // After every robot, so that a study that is stopped has reported its results.
        let robots = all.iter().map(|one: &Robot| one.result(effort.targets)).collect();
        outcome = session.write(PopulationMetrics { robots })?;
        context.print(&name);
    }
    Ok(session.finish(outcome))
}

/// The whole procedure on one robot.
fn known_from_recordings(
    chain: &ChainCommands<'_>,
    name: &str,
    effort: &PopulationEffort,
) -> Result<Vec<Row>> {
    let rig = format!("virtual:{name}");
    let nominal = write_nominal_scene(chain)?;
    chain.record(name, &write_recorded_plan(chain)?, "data")?;
    let recordings = chain.training_recordings()?;
    let fitted = fit(chain, &nominal, effort.steps)?;
    chain.calibrate("twin", &fitted, &recordings, 1, effort.twin_epochs)?;
    let twin = chain.path("twin-1.safetensors")?;
    let mut both = recordings.clone();
    both.push(chain.generate(&fitted, &twin, &synthetic_plan(), "synthetic")?);
    let options = ["--epochs", effort.inverse_epochs];
    let recorded = chain.train_inverse("recorded", &recordings, &options)?;
    let compared = [&options[..], &["--scene", &fitted, "--residual", &twin]].concat();
    let hybrid = chain.train_inverse("hybrid", &both, &options)?;
    let best = chain.train_inverse("best", &both, &compared)?;
    let steered = |scene, residual| Strokes::Twin { scene, residual };
    let methods: [Strokes; METHODS.len()] = [
        steered(nominal.as_str(), None),
        steered(fitted.as_str(), None),
        Strokes::Network(&recorded),
        steered(fitted.as_str(), Some(&twin)),
        Strokes::Network(&hybrid),
        Strokes::Best(&best),
    ];
    let follow = |target: &&str| {
        let mut row: Row = [None; METHODS.len()];
        for (k, (cell, method)) in row.iter_mut().zip(methods).enumerate() {
            let name = format!("tracked/{k}-{}", target.replace(':', ""));
            *cell = chain
                .track(&rig, method, target, [1, 1], &name)?
                .and_then(|repeats| repeats.first().copied());
        }
        Ok(row)
    };
    effort.targets.iter().map(follow).collect()
}

/// Fits the nominal scene to some of the recordings.
fn fit(chain: &ChainCommands<'_>, nominal: &str, steps: &str) -> Result<String> {
    let out = chain.path("fitted.toml")?;
    let recordings =
        FITTED.iter().map(|name| chain.path(&format!("data/{name}.parquet"))).collect::<Result<Vec<_>>>()?;
    let mut arguments = vec!["fit-material", nominal];
    arguments.extend(recordings.iter().map(String::as_str));
    arguments.extend(FIT);
    arguments.extend(["--steps", steps, "--out", &out]);
    chain.once(&out, &arguments)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tendon::outcome::StudyMetrics;

    #[test]
    fn a_failed_robot_is_reported_and_does_not_count() {
        let one = |nrmse_percent| {
            Some(Followed { nrmse_percent, iou: 0.9, aligned_rmse_mm: Some(1.0), lag_ms: Some(50.0) })
        };
        let mut rows = [[one(2.0); METHODS.len()]; 2];
        rows[1] = [one(1.0), None, one(1.0), one(1.0), one(1.0), one(1.0)];
        rows[0][1] = None;
        let found = Robot { name: "a".to_owned(), found: Ok(rows.to_vec()) };
        let failed = Robot { name: "b".to_owned(), found: Err("a stage".to_owned()) };
        let robots = [found, failed].map(|robot| robot.result(&TARGETS[..2]));
        assert_eq!(robots[1].failed.as_deref(), Some("a stage"));
        let metrics = PopulationMetrics { robots: robots.to_vec() };
        let table = &metrics.tables()[0];
        assert_eq!(table.rows[0][..4], ["a", "1.50, 0.900, 1.00, 50", "-", "1.50, 0.900, 1.00, 50"]);
        assert_eq!(table.rows[1][..2], ["b", "failed"]);
        assert_eq!(table.rows[2][1..], table.rows[0][1..]);
        let reasons = metrics.verdict().sentence;
        assert!(reasons.contains("a stage failed on 1 of 2 robots"), "{reasons}");
    }
}
