//! Studies: stages are done once, go on after every kind of interruption with the same bytes, and are done again where,
//! and only where, something that they are made from has changed.

use hysteron_base::json;
use std::collections::BTreeMap;
use std::path::Path;

use hysteron_tests::{Outcome, names_in, root, run};

/// A second and a half of each of three motions: two to learn from, one to check with.
const PLAN: &str = "format = \"hysteron-plan\"\nversion = 1\nname = \"tiny\"\nseed = 1\nrate_hz = 100\n\
    tendon_angles_deg = [0, 90, 180, 270]\nrelease = 1.0\nrest_before_s = 0.1\nrest_after_s = 0.1\nstroke_max_mm = 8\n\
    stroke_rate_max_mm_s = 12\n";

fn trajectory(name: &str, role: &str, amplitude_mm: f64) -> String {
    format!(
        "[[trajectory]]\nname = \"{name}\"\nrole = \"{role}\"\nfamily = \"circle\"\namplitude_mm = {amplitude_mm:?}\n\
         frequency_hz = 0.4\ndirection = \"clockwise\"\nattack_s = 0.6\nsustain_s = 0.2\ndecay_s = 0.6\n"
    )
}

/// A curve that is over in two seconds.
const TARGET: &str = "format = \"hysteron-target\"\nversion = 1\nname = \"small\"\nrate_hz = 100\nspeed_mm_s = 10\nramp_s = 0.2\n\
    rest_s = 0.1\nlead_in_s = 0.4\n[curve]\nfamily = \"circle\"\nsize_mm = 4\n";

const HEAD: &str = "format = \"hysteron-study\"\nversion = 1\nname = \"tiny\"\nseed = 1\nrig = \"virtual:typical\"\n\
    plan = \"plan.toml\"\nscene = \"robot/scene.toml\"\n";
const LEARN: &str = "[identify]\nrounds = 1\n[residual]\nepochs = 3\nhidden = 8\nmembers = 1\n";
const MORE: &str = "[generate]\nplan = \"more.toml\"\n";
const INVERSE: &str = "[train]\nepochs = 2\nhidden = 8\n";
const TRACK: &str =
    "[track]\ntargets = [\"small.toml\"]\nmethods = [\"nominal\", \"twin\", \"network\"]\nrepeats = 2\n";
const RUN: [&str; 4] = ["run", "study.toml", "--out", "out"];

/// A folder with a study and all that it names.
struct Place(tempfile::TempDir);

impl Place {
    fn new(study: &str) -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        std::fs::create_dir(place.path().join("robot")).unwrap();
        let robot = root().join("meshes/tpu80");
        std::fs::copy(robot.join("scene-typical.toml"), place.path().join("robot/scene.toml")).unwrap();
        std::fs::copy(robot.join("tpu80.msh"), place.path().join("robot/tpu80.msh")).unwrap();
        let learned = trajectory("one", "training", 2.0) + &trajectory("two", "training", 1.5);
        place.write("plan.toml", &(PLAN.to_owned() + &learned + &trajectory("check", "validation", 1.8)));
        place.write("more.toml", &(PLAN.to_owned() + &trajectory("wide", "training", 2.5)));
        place.write("small.toml", TARGET);
        place.write("study.toml", study);
        place
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path().join(name), text).unwrap();
    }

    fn run(&self) -> Outcome {
        run(self.path(), &RUN)
    }

    /// Every file that the study wrote but the stamps, by its path.
    fn results(&self) -> BTreeMap<String, Vec<u8>> {
        let mut files = BTreeMap::new();
        collect(&self.path().join("out"), "", &mut files);
        files.retain(|name, _| !name.starts_with("stages/"));
        files
    }
}

fn collect(folder: &Path, prefix: &str, files: &mut BTreeMap<String, Vec<u8>>) {
    for name in names_in(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            collect(&path, &format!("{prefix}{name}/"), files);
        } else {
            files.insert(format!("{prefix}{name}"), std::fs::read(path).unwrap());
        }
    }
}

/// Names of the stages that were done, and of those that were not, in order.
fn stages(outcome: &Outcome) -> [Vec<String>; 2] {
    let name = |line: &str| line.split_once("] ").map(|(_, rest)| rest.split(':').next().unwrap().to_owned());
    let lines = outcome.stdout.lines().filter(|line| line.starts_with('['));
    let (unchanged, done): (Vec<&str>, Vec<&str>) = lines.partition(|line| line.ends_with(": unchanged"));
    [done, unchanged].map(|lines| lines.into_iter().filter_map(name).collect())
}

fn same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>) {
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in a {
        assert!(b[name] == *bytes, "{name} differs");
    }
}

#[test]
#[cfg(unix)]
fn a_study_that_is_interrupted_anywhere_ends_with_the_same_bytes() {
    use hysteron_tests::emulated::signal;
    use hysteron_tests::program;
    use std::process::{Command, Stdio};

    let study = [HEAD, LEARN, MORE, INVERSE, TRACK].concat();
    let whole = Place::new(&study);
    let [done, unchanged] = stages(&whole.run().succeeded());
    assert_eq!((done.len(), unchanged.len()), (10, 0), "{done:?}");

    let broken = Place::new(&study);
    let log = || std::fs::File::create(broken.path().join("log")).unwrap();
    // Until a stage has begun, then a signal; the stage may have ended in between.
    for (stage, name) in [
        ("record", "INT"),
        ("identify", "KILL"),
        ("fit-residual", "TERM"),
        ("predict.check", "INT"),
        ("generate", "KILL"),
        ("train", "INT"),
        ("track.small.twin", "INT"),
        ("track.small.network", "KILL"),
    ] {
        let mut command = Command::new(program());
        command.args(RUN).current_dir(broken.path()).env_remove("RUST_LOG").stdin(Stdio::null());
        let mut process = command.stdout(log()).stderr(log()).spawn().unwrap();
        let stamp = broken.path().join("out/stages").join(format!("{stage}.json"));
        while !stamp.exists() && process.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        signal(&process, name);
        let status = process.wait().unwrap();
        assert!(!status.success(), "{stage} was not interrupted by {name}");
        // Ctrl-C is an end in order; a kill is none.
        assert_eq!(status.code(), if name == "KILL" { None } else { Some(1) }, "{stage}, {name}");
    }
    broken.run().succeeded();
    same(&whole.results(), &broken.results());

    // Nothing is left to do.
    let again = whole.run().succeeded();
    assert_eq!(stages(&again)[0], Vec::<String>::new());
    same(&whole.results(), &broken.results());
}

#[test]
fn a_change_redoes_only_what_depends_on_it() {
    let track = TRACK.replace("\"twin\", ", "").replace("repeats = 2", "repeats = 1");
    let place = Place::new(&[HEAD, INVERSE, &track].concat());
    place.run().succeeded();
    let first = place.results();

    let change = |from: &str, to: &str| {
        let text = std::fs::read_to_string(place.path().join("study.toml")).unwrap();
        assert!(text.contains(from), "{from}");
        place.write("study.toml", &text.replace(from, to));
    };
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    change("epochs = 2", "epochs = 3");
    let [done, unchanged] = stages(&place.run().succeeded());
    assert_eq!(done, names(&["train", "track small network"]));
    assert_eq!(unchanged, names(&["record", "track small nominal"]));
    assert!(place.results()["inverse/network.safetensors"] != first["inverse/network.safetensors"]);
    change("epochs = 3", "epochs = 2");
    place.run().succeeded();
    same(&first, &place.results());

    // A file that is missing, and one that was changed.
    std::fs::remove_file(place.path().join("out/data/two.parquet")).unwrap();
    std::fs::write(place.path().join("out/tracked/small/network/metrics.json"), "{}").unwrap();
    let [done, _] = stages(&place.run().succeeded());
    assert_eq!(done, names(&["record", "track small network"]));
    same(&first, &place.results());

    // Another target of the same name, and a place of its own in the scene: what reads neither stays.
    place.write("small.toml", &TARGET.replace("size_mm = 4", "size_mm = 5"));
    let [done, _] = stages(&place.run().succeeded());
    assert_eq!(done, names(&["track small nominal", "track small network"]));
}

#[test]
fn the_report_holds_what_metrics_say_and_nothing_of_the_clock() {
    let track = TRACK.replace("\"twin\", ", "");
    let place = Place::new(&[HEAD, INVERSE, &track].concat());
    place.run().succeeded();
    let read = |name: &str| std::fs::read_to_string(place.path().join("out").join(name)).unwrap();
    let metrics: serde_json::Value = json::from_text(read("metrics.json")).unwrap();
    let html = read("report.html");
    let tracked = metrics["tracked"].as_array().unwrap();
    assert_eq!(tracked.len(), 2);
    for (row, method) in tracked.iter().zip(["nominal", "network"]) {
        assert_eq!(row["method"], method);
        let own = read(&format!("tracked/small/{method}/metrics.json"));
        let own: serde_json::Value = json::from_text(&own).unwrap();
        let of = |k: usize| own["recordings"][k]["rmse_m"].as_f64().unwrap();
        assert_eq!(row["rmse_m"].as_array().unwrap().len(), 2);
        assert_eq!(row["rmse_m"][1].as_f64().unwrap(), of(1));
        let mean = 1e3 * 0.5 * (of(0) + of(1));
        assert!(html.contains(&format!(">{mean:.2}<")), "{mean}");
    }
    assert!(html.contains("<svg") && html.contains("No hardware was involved"));
    assert!(
        !html.contains("http://")
            || html.matches("http://").count() == html.matches("http://www.w3.org").count()
    );
}

#[test]
fn a_mistake_in_a_study_is_named_before_anything_runs() {
    let place = Place::new("");
    let full = [HEAD, LEARN, MORE, INVERSE, TRACK].concat();
    let slow = |text: &str| text.replace("rate_hz = 100", "rate_hz = 50");
    place.write("slow-plan.toml", &slow(&(PLAN.to_owned() + &trajectory("slow", "training", 2.0))));
    place.write("slow.toml", &slow(&TARGET.replace("speed_mm_s = 10", "speed_mm_s = 5")));
    let before = names_in(place.path());
    let refused = |from: &str, to: &str, parts: &[&str]| {
        assert!(full.contains(from), "{from}");
        place.write("study.toml", &full.replacen(from, to, 1));
        let outcome = place.run();
        let error = outcome.error(2);
        assert!(error.starts_with("error: study.toml: "), "{error}");
        assert!(parts.iter().all(|part| error.contains(part)), "{parts:?} in {error}");
        assert_eq!(outcome.stdout, "");
        assert_eq!(names_in(place.path()), before);
    };
    refused("version = 1", "version = 2", &["version", "got 2"]);
    refused("name = \"tiny\"", "name = \"../tiny\"", &["name", "letters, digits"]);
    refused("seed = 1", "seed = 1\nsede = 2", &["line 5: sede", "one of format"]);
    refused("seed = 1", "seed = -1", &["seed", "whole number"]);
    refused("virtual:typical", "virtual:typcal", &["rig", "virtual:typical"]);
    refused("virtual:typical", "rig.toml", &["rig", "rig.toml", "nothing there"]);
    refused("plan = \"plan.toml\"", "plan = \"slow\"", &["plan", "one of paper"]);
    refused("plan = \"plan.toml\"", "plan = \"more.toml\"", &["plan", "two trajectories for training"]);
    refused("robot/scene.toml", "robot/sene.toml", &["scene", "robot/sene.toml", "nothing there"]);
    refused("rounds = 1", "rounds = 0", &["identify.rounds", "got 0"]);
    refused("epochs = 3", "epochs = 3.5", &["residual.epochs", "a whole number"]);
    refused("[identify]\nrounds = 1\n", "", &["residual", "[identify]"]);
    refused(INVERSE, "", &["generate", "[train]"]);
    refused("more.toml", "plan.toml", &["generate.plan", "other names", "\"one\" again"]);
    refused("more.toml", "slow-plan.toml", &["generate.plan", "rate_hz = 100", "got 50"]);
    refused("small.toml", "slow.toml", &["track.targets[1]", "rate_hz = 100", "got 50"]);
    refused("small.toml", "circle:", &["track.targets[1]", "circle:SIZE"]);
    refused("\"small.toml\"", "\"small.toml\", \"small.toml\"", &["track.targets[2]", "\"small\" again"]);
    refused("[\"small.toml\"]", "[]", &["track.targets", "at least one"]);
    refused("\"twin\"", "\"twins\"", &["track.methods", "nominal", "twins"]);
    refused("\"twin\"", "\"nominal\"", &["track.methods", "\"nominal\" again"]);
    refused("repeats = 2", "repeats = 0", &["track.repeats", "got 0"]);
    // An older file has `ways`: it is read up to its next error.
    let methods = "methods = [\"nominal\", \"twin\", \"network\"]\nrepeats = 2";
    let ways = methods.replace("methods", "ways").replace('2', "0");
    refused(methods, &ways, &["track.repeats", "got 0"]);
    let fit = "[calibrate]\nrecordings = [\"three\"]\nfit = [\"zero\"]\n[identify]";
    refused("[identify]", fit, &["calibrate.recordings", "one, two, check", "\"three\""]);
    let fit = "[calibrate]\nrecordings = [\"one\"]\nfit = [\"colour\"]\n[identify]";
    refused("[identify]", fit, &["calibrate.fit", "colour"]);
}

#[test]
fn files_of_somebody_else_are_not_touched() {
    let place = Place::new(&[HEAD, INVERSE].concat());
    std::fs::create_dir_all(place.path().join("out/data")).unwrap();
    place.write("out/data/notes.txt", "mine");
    let outcome = place.run();
    assert!(outcome.error(2).contains("notes.txt, which this study did not write"), "{}", outcome.stderr);
    assert_eq!(std::fs::read(place.path().join("out/data/notes.txt")).unwrap(), b"mine");
}

#[test]
#[cfg(unix)]
fn what_was_measured_on_a_rig_is_set_aside_and_never_removed() {
    use hysteron_tests::emulated::EmulatedRig;

    let rig = EmulatedRig::start("", 0.6);
    // A machine that is busy for long stops a rig; the same command then goes on.
    let run = || (0..5).map(|_| run(rig.path(), &RUN)).find(|outcome| outcome.code == Some(0)).unwrap();
    let study = HEAD
        .replace("virtual:typical", "rig/rig.toml")
        .replace("robot/scene.toml", &root().join("meshes/tpu80/scene.toml").display().to_string());
    std::fs::write(rig.file("study.toml"), study).unwrap();
    run();
    let measured = std::fs::read(rig.file("out/data/circle.parquet")).unwrap();
    let plan = std::fs::read_to_string(rig.file("plan.toml")).unwrap();
    std::fs::write(rig.file("plan.toml"), plan.replace("amplitude_mm = 1.5", "amplitude_mm = 1.4")).unwrap();
    run();
    assert!(std::fs::read(rig.file("out/data.earlier-1/circle.parquet")).unwrap() == measured);
    assert!(std::fs::read(rig.file("out/data/circle.parquet")).unwrap() != measured);
}

#[test]
fn a_demo_that_was_edited_is_not_overwritten() {
    let place = tempfile::tempdir().unwrap();
    std::fs::create_dir(place.path().join("demo")).unwrap();
    std::fs::write(place.path().join("demo/study.toml"), "mine").unwrap();
    let outcome = run(place.path(), &["demo", "--out", "demo"]);
    let error = outcome.error(2);
    assert!(error.contains("demo/study.toml") && error.contains("hysteron study run"), "{error}");
    assert_eq!(names_in(&place.path().join("demo")), ["study.toml"]);
}

#[test]
fn two_studies_do_not_share_a_folder() {
    let place = Place::new(HEAD);
    place.run().succeeded();
    let before = place.results();
    place.write(
        "study.toml",
        &HEAD.replace("name = \"tiny\"", "name = \"other\"").replace("seed = 1", "seed = 2"),
    );
    let outcome = place.run();
    assert!(outcome.error(2).contains("that of \"tiny\""), "{}", outcome.stderr);
    same(&before, &place.results());
}

#[test]
fn a_stamp_cannot_name_files_outside_of_its_folder() {
    let place = Place::new(HEAD);
    place.run().succeeded();
    place.write("precious.txt", "mine");
    let stamp = place.path().join("out/stages/record.json");
    let text = std::fs::read_to_string(&stamp).unwrap();
    let measured = std::fs::read(place.path().join("out/data/one.parquet")).unwrap();
    for name in ["../../precious.txt", "/etc/hostname", "a/../../../precious.txt"] {
        std::fs::write(
            &stamp,
            text.replace("\"outputs\": {", &format!("\"outputs\": {{\n    \"{name}\": \"0\",")),
        )
        .unwrap();
        place.write("study.toml", &HEAD.replace("seed = 1", "seed = 2"));
        place.run().error(2);
        assert_eq!(std::fs::read(place.path().join("precious.txt")).unwrap(), b"mine", "{name}");
        assert_eq!(std::fs::read(place.path().join("out/data/one.parquet")).unwrap(), measured, "{name}");
    }
}

#[test]
#[cfg(unix)]
fn an_interrupted_study_is_reported_once() {
    let place = Place::new(&[HEAD, LEARN].concat());
    let outcome = hysteron_tests::interrupt(place.path(), &RUN, "out/stages/identify.json");
    assert!(outcome.error(1).contains("interrupted"), "{}", outcome.stderr);
    place.run().succeeded();
}
