//! Files in the layout of NAD through the program: readings of a good one, and errors of bad ones.

use std::fmt::Write as _;
use std::path::Path;

use hysteron_base::Recording;
use hysteron_tests::run;

/// Columns of the OpenManipulator-X after the time: five numbered ones of each of the first kind.
const NUMBERED: [&str; 7] = ["pos", "goal_pos", "current", "vel", "temp", "pwm", "volts"];
const ALONE: [&str; 5] = ["aperture", "goal_aperture", "force_x", "force_y", "force_z"];

/// Changes of a good file.
#[derive(Clone, Copy)]
struct Change<'a> {
    without: &'a str,
    /// Columns whose numbers are multiplied, and by what.
    scaled: (&'a [&'a str], f64),
    /// Columns that read -999 throughout.
    missing: &'a [&'a str],
    /// A kind of column that reads 0 throughout.
    zero: &'a str,
    period: f64,
    /// By how many periods each row comes late.
    late: fn(i32) -> f64,
}

const GOOD: Change =
    Change { without: "", scaled: (&[], 1.0), missing: &[], zero: "", period: 0.017, late: |_| 0.0 };

/// Waves of all joints that goals are ahead of; a weight is held in the second half.
fn value(column: &str, k: usize, t: f64) -> f64 {
    let phase = 1.3 * t + k as f64;
    match column {
        "pos" => 0.4 * phase.sin(),
        "goal_pos" => 0.4 * (phase + 0.06).sin(),
        "current" => 100.0 * phase.cos(),
        "vel" => 0.52 * phase.cos(),
        "temp" => 31.0,
        "pwm" => 60.0 * phase.sin(),
        "volts" => 12.1,
        "aperture" | "goal_aperture" => 15.0 + 22.8 * 0.4 * (1.3 * t + 5.0).sin(),
        "force_z" if t > 1.7 => -4.9,
        _ => -999.0,
    }
}

fn write(path: &Path, change: Change) {
    let mut columns: Vec<(String, &str, usize)> = Vec::new();
    for name in NUMBERED {
        columns.extend((1..=5).map(|k| (format!("{name}{k}"), name, k)));
    }
    columns.extend(ALONE.map(|name| (name.to_owned(), name, 0)));
    columns.extend(["x", "y", "z"].map(|axis| (format!("force_gripper_{axis}"), "unused", 0)));
    columns.retain(|(name, ..)| name != change.without);
    let mut text = "timestamp".to_owned();
    columns.iter().for_each(|(name, ..)| write!(text, ",{name}").unwrap());
    for i in 0..200 {
        let t = change.period * (f64::from(i) + (change.late)(i));
        write!(text, "\n{:.6}", 1000.0 + t).unwrap();
        for (_, name, k) in &columns {
            let factor = if change.scaled.0.contains(name) { change.scaled.1 } else { 1.0 };
            let own = match *name {
                "unused" => 0.0,
                name if name == change.zero => 0.0,
                name if change.missing.contains(&name) => -999.0,
                name => value(name, *k, t),
            };
            write!(text, ",{:.6}", factor * own).unwrap();
        }
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn files_of_nad_are_read_and_bad_ones_say_what_is_wrong() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let import = |change: Change| {
        write(&folder.join("in.csv"), change);
        run(folder, &["import", "in.csv", "--map", "nad-omx", "--out", "out.parquet", "--overwrite"])
    };
    import(GOOD).succeeded();
    let good = Recording::read(folder.join("out.parquet")).unwrap();
    assert_eq!(good.n_samples(), 200);
    // A label in z alone, and only while something is held.
    assert!(good.channel("force_x_n").is_none());
    let labelled = good.require("force_z_labelled_ratio").unwrap();
    assert!(labelled[0] == 0.0 && labelled[199] == 1.0);
    assert!(good.require("aperture_m").unwrap().iter().all(|a| (0.005..0.025).contains(a)));

    // -999 everywhere: no label is not no force.
    import(Change { missing: &["force_z"], ..GOOD }).succeeded();
    let unlabelled = Recording::read(folder.join("out.parquet")).unwrap();
    assert!(unlabelled.channels().iter().all(|channel| !channel.name.starts_with("force_")));
    let bad = import(Change { missing: &["pos"], ..GOOD });
    let found = "q_1_rad, rows 1: expected numbers in the unit that is stated, got -999.0000 in row 1";
    assert!(bad.error(2).contains(found), "{}", bad.stderr);

    let bad = import(Change { without: "current3", ..GOOD });
    assert!(bad.error(2).contains("current_3_a"), "{}", bad.stderr);
    let bad = import(Change { scaled: (&["pos", "goal_pos"], 57.3), ..GOOD });
    assert!(bad.error(2).contains("--accept-units"), "{}", bad.stderr);
    // Currents in amperes and in microamperes; without PWM the motion decides. An arm that hardly moves needs
    // next to none.
    for (factor, zero, found, plausible) in [
        (1e-3, "", "got 1.4", "A at full PWM; 0.01 to 1000 A is plausible"),
        (1e3, "", "got 1.4", "A at full PWM; 0.01 to 1000 A is plausible"),
        (1e-3, "pwm", "got 7", "in the median of motors that move; 0.00025 A or more is plausible"),
    ] {
        let bad = import(Change { scaled: (&["current"], factor), zero, ..GOOD });
        let text = bad.error(2);
        for part in ["current_*_a: expected", found, plausible] {
            assert!(text.contains(part), "{factor} {part:?} {text}");
        }
        let unit = if factor < 1.0 { "unit a?" } else { "unit ma?" };
        assert!(text.contains(unit) && text.contains("--accept-units"), "{text}");
    }
    for slow in [0.1, 0.01] {
        import(Change { scaled: (&["pos", "goal_pos", "vel", "current", "pwm"], slow), ..GOOD }).succeeded();
    }
    // Torque off, and moved by hand.
    import(Change { scaled: (&["current", "pwm"], 0.0), ..GOOD }).succeeded();
    // Times in milliseconds.
    let bad = import(Change { period: 17.0, ..GOOD });
    assert!(bad.error(2).contains("in.csv") && bad.error(2).contains("unit"), "{}", bad.stderr);

    // Three times too slow for the simulation's step.
    import(Change { period: 0.05, ..GOOD }).succeeded();
    std::fs::copy(folder.join("out.parquet"), folder.join("slow.parquet")).unwrap();
    let fit = ["arm", "fit", "neural", "slow.parquet", "out.parquet", "--out", "a.safetensors"];
    let bad = run(folder, &fit);
    assert!(bad.error(2).contains("steps of 0.017 s"), "{}", bad.stderr);
    assert!(!folder.join("a.safetensors").exists());

    // Import resamples what is uneven, and what it filled in is still known.
    let fit_of = |late: fn(i32) -> f64, name: &str| {
        import(Change { late, ..GOOD }).succeeded();
        std::fs::copy(folder.join("out.parquet"), folder.join(name)).unwrap();
        run(folder, &["arm", "fit", "neural", name, "--out", "a.safetensors"])
    };
    let bad = fit_of(|i| f64::from(3 * (i / 20)), "late.parquet");
    let expected = "late.parquet: gap: expected at most 10 % of the samples filled in, got 1";
    assert!(bad.error(2).contains(expected), "{}", bad.stderr);
    let bad = fit_of(|i| 0.45 * f64::from(i / 2 % 2), "scattered.parquet");
    let expected =
        "scattered.parquet: time_s: expected steps that scatter by at most 20 % about their median";
    assert!(bad.error(2).contains(expected), "{}", bad.stderr);
    // What is within the limits fails for another reason: one recording is none to validate.
    let bad = fit_of(|i| 0.1 * f64::from(i / 2 % 2) + f64::from(i / 100), "fair.parquet");
    assert!(bad.error(2).contains("two or more, one of them for validation"), "{}", bad.stderr);
}
