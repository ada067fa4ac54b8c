//! The virtual arm compared with `hysteron-arm-dynamics`, which shares no code with it, on equal parameters.

use std::path::Path;

use hysteron_arm_dynamics::{Data, Model, bias_torque, forward_dynamics, frame_jacobian, mass_matrix};
use hysteron_base::{Recording, json};
use hysteron_tests::run;
use hysteron_virtual_rig::virtual_arm::VirtualArm;
use rand::RngExt;

const N: usize = 4;

#[test]
fn bodies_move_as_those_of_the_other_crate() {
    let chain = VirtualArm::preset("open-manipulator-x").unwrap().chain;
    let fingers = [("gripper_left_joint", 0.0), ("gripper_right_joint", 0.0)];
    let model = Model::builtin("open-manipulator-x").unwrap().with_locked(&fingers).unwrap();
    assert_eq!(model.n_joints(), N);
    let frame = model.frame("end_effector_link").unwrap();
    let mut data = Data::new(&model, 0.0);
    let mut stream = hysteron_base::rng(5, "test/virtual-arm");
    for _ in 0..200 {
        let mut draw = |most: f64| -> [f64; N] { std::array::from_fn(|_| stream.random_range(-most..most)) };
        let (q, dq, tau) = (draw(1.5), draw(3.0), draw(2.0));
        let ours = chain.at(&q, &dq);
        let (mut mass, mut bias) = (vec![0.0; N * N], vec![0.0; N]);
        mass_matrix(&model, &mut data, &q, &mut mass);
        bias_torque(&model, &mut data, [&q, &dq], &[], &mut bias);
        let scale = mass.iter().fold(0.0_f64, |most, m| m.abs().max(most));
        for i in 0..N {
            for j in 0..N {
                // The fingers' bodies of the preset are rounded to ten digits.
                assert!((ours.mass[i][j] - mass[N * i + j]).abs() < 1e-8 * scale, "M {i} {j}");
            }
            assert!((ours.bias[i] - bias[i]).abs() < 1e-7, "{} {}", ours.bias[i], bias[i]);
        }
        // Forward dynamics under a force at the tip: the accelerations of one satisfy the equations of the other.
        let force = [2.0, -1.0, 3.0];
        let mut jacobian = vec![0.0; 6 * N];
        let mut ddq = vec![0.0; N];
        forward_dynamics(&model, &mut data, [&q, &dq, &tau], &[], &mut ddq);
        frame_jacobian(&model, &data, frame, &mut jacobian);
        let push = ours.torques_of(&force.into());
        for j in 0..N {
            let transposed: f64 = (0..3).map(|axis| jacobian[N * axis + j] * force[axis]).sum();
            assert!((push[j] - transposed).abs() < 1e-12, "{} {transposed}", push[j]);
            let inertial: f64 = (0..N).map(|k| ours.mass[j][k] * ddq[k]).sum();
            let largest = ddq.iter().fold(1.0_f64, |most, a| a.abs().max(most));
            assert!((inertial + ours.bias[j] - tau[j]).abs() < 1e-8 * largest, "joint {j}");
        }
    }
}

/// Paths of all recordings below a folder, with their bytes.
fn recordings(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(at) = open.pop() {
        for entry in std::fs::read_dir(&at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|ending| ending == "parquet") {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                found.push((name, std::fs::read(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

const PART: [&str; 8] =
    ["--subsets", "weight", "--payloads-g", "300", "--splits", "train", "--trajectories", "1"];

#[test]
fn a_data_set_resumes_and_is_the_same_on_any_number_of_threads() {
    let place = tempfile::tempdir().unwrap();
    let generate = |out: &str, more: &[&str]| {
        run(place.path(), &[&["arm", "generate", "--out", out, "--seed", "3"], &PART[..], more].concat())
    };
    let made = generate("one", &["--threads", "1"]).succeeded();
    assert!(
        made.stdout.contains("2 trajectories") && made.stdout.contains("in place of NAD"),
        "{}",
        made.stdout
    );
    generate("two", &["--threads", "2"]).succeeded();
    let one = recordings(&place.path().join("one"));
    let names: Vec<&str> = one.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "weight/go_up_and_stay_still_300g/train/001.parquet",
            "weight/pick_place_object_300g/train/001.parquet"
        ]
    );
    // The command is in the files, so compare the recorded values.
    for (name, _) in &one {
        let [a, b] =
            ["one", "two"].map(|folder| Recording::read(place.path().join(folder).join(name)).unwrap());
        assert_eq!(a.channels(), b.channels(), "{name}");
        assert_eq!(a.time(), b.time(), "{name}");
    }
    // One is lost: only that one is made again, and the report is of all.
    std::fs::remove_file(place.path().join("one").join(names[0])).unwrap();
    let kept = place.path().join("one").join(names[1]);
    let before = std::fs::metadata(&kept).unwrap().modified().unwrap();
    generate("one", &["--threads", "1"]).succeeded();
    assert_eq!(recordings(&place.path().join("one")), one);
    assert_eq!(std::fs::metadata(&kept).unwrap().modified().unwrap(), before);
    let report = std::fs::read_to_string(place.path().join("one/report.html")).unwrap();
    assert!(report.contains("Virtual arm in place of NAD") && report.contains("pick_place_object_300g"));
}

#[test]
fn what_is_not_in_the_set_is_refused_with_what_is() {
    let place = tempfile::tempdir().unwrap();
    for (option, wrong, there) in [
        ("--subsets", "weights", "motor_condition"),
        ("--tasks", "dance", "sweep_1"),
        ("--splits", "eval", "validation"),
        ("--payloads-g", "250", "300"),
        ("--arm", "panda", "open-manipulator-x"),
        ("--arm", "missing.toml", "missing.toml"),
        ("--trajectories", "0", "1"),
    ] {
        let failed = run(place.path(), &["arm", "generate", "--out", "out", option, wrong]);
        let message = failed.error(2);
        assert!(message.contains(there), "{option} {wrong}: {message}");
        assert!(!place.path().join("out").exists(), "{option}");
    }
}

#[test]
fn forces_are_estimated_as_in_table_six() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), &["study", "force", "--seeds", "1", "--out", "out"]).succeeded();
    let metrics = std::fs::read(place.path().join("out/metrics.json")).unwrap();
    let metrics: serde_json::Value = json::from_text(&metrics).unwrap();
    let mean = |method: usize, key: &str| {
        metrics["methods"][method]["loaded"][key].as_array().unwrap().last().unwrap().as_f64().unwrap()
    };
    // The paper's order: the momentum observer beats inverse dynamics on currents, and the drive's PWM beats both.
    assert_eq!(metrics["methods"][4]["name"], "GMO-drive");
    for key in ["mean_n", "z_n"] {
        assert!(mean(4, key) < mean(3, key) && mean(4, key) < mean(1, key), "{metrics}");
    }
    // An estimate of a force is better than the estimate of none.
    assert!(mean(4, "z_n") < 0.5 * mean(0, "z_n"), "{metrics}");
    let report = std::fs::read_to_string(place.path().join("out/report.html")).unwrap();
    // What is done is found again.
    let cell = place.path().join("out/cells/arm-1.json");
    let before = std::fs::metadata(&cell).unwrap().modified().unwrap();
    run(place.path(), &["study", "force", "--seeds", "1", "--out", "out"]).succeeded();
    assert_eq!(std::fs::metadata(&cell).unwrap().modified().unwrap(), before);
    for part in ["GMO-drive", "(0.58)", "in place of NAD", "Learned threshold"] {
        assert!(report.contains(part), "{part}");
    }
}

/// A recording as NAD has it: a table of 44 columns.
fn nad_table(recording: &Recording) -> String {
    let joints = |name: &str, unit: &str, factor: f64| -> Vec<(String, Vec<f64>)> {
        let column = |k: usize| {
            let values = recording.require(&format!("{name}_{k}_{unit}")).unwrap();
            (k.to_string(), values.iter().map(|x| factor * x).collect())
        };
        (1..=5).map(column).collect()
    };
    let mut columns: Vec<(String, Vec<f64>)> = vec![("timestamp".to_owned(), recording.time().to_vec())];
    let mut add = |stem: &str, found: Vec<(String, Vec<f64>)>| {
        columns.extend(found.into_iter().map(|(k, values)| (format!("{stem}{k}"), values)));
    };
    let metres = |name: &str| {
        let values = recording.require(name).unwrap();
        vec![(String::new(), values.iter().map(|x| 1e3 * x).collect())]
    };
    add("pos", joints("q", "rad", 1.0));
    add("aperture", metres("aperture_m"));
    add("goal_pos", joints("goal", "rad", 1.0));
    add("goal_aperture", metres("goal_aperture_m"));
    add("current", joints("current", "a", 1e3));
    add("vel", joints("dq", "rad_s", 1.0));
    add("temp", joints("temperature", "degc", 1.0));
    add("pwm", joints("pwm", "ratio", 885.0));
    add("volts", joints("voltage", "v", 1.0));
    for axis in ["x", "y", "z"] {
        let labelled = recording.channel(&format!("force_{axis}_labelled_ratio"));
        let force = recording.channel(&format!("force_{axis}_n"));
        let label = |row: usize| match (force, labelled) {
            (Some(force), Some(labelled)) if labelled[row] == 1.0 => force[row],
            _ => -999.0,
        };
        add(&format!("force_{axis}"), vec![(String::new(), (0..recording.n_samples()).map(label).collect())]);
    }
    for axis in ["x", "y", "z"] {
        add(&format!("force_gripper_{axis}"), vec![(String::new(), vec![0.0; recording.n_samples()])]);
    }
    assert_eq!(columns.len(), 44);
    let header: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let row =
        |k: usize| columns.iter().map(|(_, values)| values[k].to_string()).collect::<Vec<_>>().join(",");
    let rows: Vec<String> = (0..recording.n_samples()).map(row).collect();
    format!("{}\n{}\n", header.join(","), rows.join("\n"))
}

#[test]
fn the_study_of_forces_reads_tables_of_nad() {
    let place = tempfile::tempdir().unwrap();
    let generate = |more: &[&str]| {
        let common = [
            "arm",
            "generate",
            "--out",
            "set",
            "--splits",
            "train,test",
            "--trajectories",
            "1",
            "--overwrite",
        ];
        run(place.path(), &[&common[..], more].concat()).succeeded();
    };
    generate(&["--subsets", "force_unlabeled"]);
    generate(&["--subsets", "weight", "--payloads-g", "300,500"]);
    let set = place.path().join("set");
    for (name, _) in recordings(&set) {
        let table = nad_table(&Recording::read(set.join(&name)).unwrap());
        let path = place.path().join("nad").join(name).with_extension("csv");
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, table).unwrap();
    }
    let mean = |data: &str| {
        run(place.path(), &["study", "force", "--data", data, "--out", &format!("out-{data}")]).succeeded();
        let metrics = std::fs::read(place.path().join(format!("out-{data}/metrics.json"))).unwrap();
        let metrics: serde_json::Value = json::from_text(&metrics).unwrap();
        assert!(metrics["about"].as_str().unwrap().contains(data), "{metrics}");
        // No 400 g: that task has no cell.
        assert!(metrics["methods"][4]["loaded"]["z_n"][2].is_null(), "{metrics}");
        metrics["methods"][4]["loaded"]["z_n"][7].as_f64().unwrap()
    };
    let [recorded, imported] = ["set", "nad"].map(mean);
    // Import resamples to a fixed rate, so the estimates differ a little.
    assert!((recorded / imported - 1.0).abs() < 0.1, "{recorded} {imported}");
    let missing = run(place.path(), &["study", "force", "--data", "nowhere", "--out", "out"]);
    assert!(missing.error(2).contains("force_unlabeled"));
}
