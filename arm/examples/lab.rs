#![allow(missing_docs, clippy::all, clippy::unwrap_used, clippy::print_stdout)]
use hysteron_arm::Model;
use hysteron_arm::neural::*;
use hysteron_arm::servo_force::observed_arm;
use hysteron_base::Recording;
use std::path::{Path, PathBuf};

fn walk(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            walk(&path, all)
        } else if path.extension().is_some_and(|e| e == "parquet") {
            all.push(path)
        }
    }
}
fn load(folder: &str) -> Vec<(String, Recording)> {
    let mut all = Vec::new();
    walk(Path::new(folder), &mut all);
    all.sort();
    all.iter().map(|p| (p.display().to_string(), Recording::read(p).unwrap())).collect()
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let nad = load(&args[1]);
    let faults = load(&args[2]);
    let leave = args.get(3).cloned().unwrap_or("nothing".into());
    let recs: Vec<Recording> = nad.iter().chain(&faults).map(|x| x.1.clone()).collect();
    let features = Features { joints: 4, gripper: gripper_of(&recs).unwrap() };
    let period = 0.017;
    let traj = |(path, rec): &(String, Recording)| {
        let un = if path.contains("force_unlabeled") { Unlabelled::Free } else { Unlabelled::Unknown };
        (path.clone(), trajectory_of(rec, &features, period, un).unwrap())
    };
    let nad: Vec<_> = nad.iter().map(traj).collect();
    let faults: Vec<_> = faults.iter().map(traj).collect();
    let arm = observed_arm(&Model::builtin("open-manipulator-x").unwrap(), 4).unwrap();
    let training: Vec<Trajectory> = nad
        .iter()
        .chain(&faults)
        .filter(|x| x.0.contains("/train/") && !x.0.contains(&leave))
        .map(|x| x.1.clone())
        .collect();
    let observers = identified_observers(&arm, (&features, period), &training).unwrap();
    println!("drive {:?}", observers.drive);
    let clean: Vec<Trajectory> = if std::env::var("ALL").is_ok() {
        training.clone()
    } else {
        nad.iter()
            .chain(&faults)
            .filter(|x| x.0.contains("/train/") && !x.0.contains(&leave) && (x.0.contains("motor_")))
            .map(|x| x.1.clone())
            .collect()
    };
    let known = IdentifiedArm::identify(&arm, (&features, &observers.drive, period), &clean).unwrap();
    println!("{:?}", known.health);
    let test: Vec<_> =
        faults.iter().filter(|x| x.0.contains("/test/") || x.0.contains("/validation/")).collect();
    let mut rows = Vec::new();
    for (path, t) in test.iter().map(|x| (&x.0, &x.1)) {
        let o = Observed::new(&arm, (&features, &known, period), t).unwrap();
        let n = o.evidence.len();
        let q: Vec<f64> =
            [0.1, 0.25, 0.5, 0.75, 1.0].iter().map(|s| o.evidence[(s * (n - 1) as f64) as usize]).collect();
        let kind = path.split('/').find(|p| p.starts_with("pick_place")).unwrap().to_owned();
        let rec = Recording::read(Path::new(path)).unwrap();
        let fault = rec.meta().extra.get("fault").cloned().unwrap_or_default();
        println!("{:40} {:?} {fault}", kind, q.iter().map(|x| (x * 10.0).round() / 10.0).collect::<Vec<_>>());
        rows.push((kind, o.evidence, t.is_healthy.unwrap()));
    }
    for of in ["band", "friction", "lost_tooth", ""] {
        let mine: Vec<_> = rows.iter().filter(|r| r.2 || r.0.contains(of)).collect();
        let ends: Vec<(f64, bool)> = mine.iter().map(|r| (*r.1.last().unwrap(), r.2)).collect();
        let windows: Vec<(f64, bool)> =
            mine.iter().flat_map(|r| (0..=r.1.len() - 64).step_by(32).map(|s| (r.1[s + 63], r.2))).collect();
        let late: Vec<(f64, bool)> = mine
            .iter()
            .flat_map(|r| (r.1.len() / 4..=r.1.len() - 64).step_by(32).map(|s| (r.1[s + 63], r.2)))
            .collect();
        println!(
            "{of:12} end {:.3} windows {:.3} after a quarter {:.3}",
            area_under_curve(&ends).unwrap(),
            area_under_curve(&windows).unwrap(),
            area_under_curve(&late).unwrap()
        );
    }
}
