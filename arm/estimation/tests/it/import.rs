//! Files of other programs as recordings of arms, and those that cannot be.

use std::path::Path;
use std::sync::Arc;

use hysteron_actuator::{CatalogueDrive, Winding};
use hysteron_arm_dynamics::*;
use hysteron_arm_estimation::*;
use hysteron_base::{Metadata, Recording, RowFilter};
use hysteron_fuzz::recorded;
use parquet::data_type::{FloatType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

/// Columns of two joints, as a person types them.
pub(crate) const COLUMNS: &str = r#"
format = "hysteron-columns"
version = 1
joint_names = ["shoulder", "elbow"]
missing = [-999]
[columns]
time_ms = "t"
"q_*_deg" = ["a", "b"]
"current_*_ma" = { columns = "i*", times = 2.0 }
force_z_n = { columns = "fz", unlabelled = -1000 }
"#;

fn import_text(
    text: &str,
    columns: &str,
    change: impl FnOnce(&mut ImportOptions),
) -> Result<ArmImport, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, text).unwrap();
    let mut options =
        ImportOptions { columns: Some(ColumnMap::parse(columns, "test").unwrap()), ..Default::default() };
    change(&mut options);
    import(&path, &options, Metadata::default()).map_err(|error| error.to_string())
}

const HEADER: &str = "t,a,b,i1,i2,fz\n";

/// A log at 100 Hz in which row `row` reads `text`.
pub(crate) fn log(row: usize, text: &str) -> String {
    let rows = (0..50).map(|k| match k == row {
        true => format!("{text}\n"),
        false => format!("{},{},{},10,20,-1000\n", 5000 + 10 * k, k, 2 * k),
    });
    format!("{HEADER}{}", rows.collect::<String>())
}

#[test]
fn columns_become_channels_in_si_from_time_zero() {
    let imported = import_text(&log(7, "5070,7,14,10,20,3.5"), COLUMNS, |_| ()).unwrap();
    let recording = &imported.recording;
    let recorded = ArmRecording::of(recording).unwrap();
    assert_eq!(recorded.joint_names, ["shoulder", "elbow"]);
    // Times of the file are rounded to eps, at 5 s.
    assert!(recorded.time[0] == 0.0 && (recorded.time[1] - 0.01).abs() < 5.0 * f64::EPSILON);
    assert_eq!(recording.meta().extra["time_origin_s"], "5");
    assert_eq!(recorded.joints[1].position.unwrap()[3], 6.0_f64.to_radians());
    assert_eq!(recorded.joints[1].current.unwrap()[3], 0.04);
    let force = recorded.force[2].unwrap();
    assert_eq!((force.values[7], force.values[8]), (3.5, 0.0));
    assert_eq!((force.labelled.unwrap()[7], force.labelled.unwrap()[8]), (1.0, 0.0));
    assert!(recorded.gap.iter().all(|gap| !gap) && recorded.joints[0].velocity.is_none());
    assert_eq!(recorded.require(JointQuantityKind::Torque).unwrap_err().place, "tau_1_n_m");
}

#[test]
fn a_missing_value_is_interpolated_and_its_row_a_gap() {
    let imported = import_text(&log(7, "5070,-999,14,10,20,-1000"), COLUMNS, |_| ()).unwrap();
    let recorded = ArmRecording::of(&imported.recording).unwrap();
    assert!((recorded.joints[0].position.unwrap()[7] - 7.0_f64.to_radians()).abs() < 1e-15);
    let gaps: Vec<usize> = (0..50).filter(|row| recorded.gap[*row]).collect();
    assert_eq!(gaps, [7]);
    // No row has a label of the force: the channel is left out, and named.
    assert!(recorded.force[2].is_none());
    assert_eq!(imported.recording.meta().extra["without_values"], "force_z_n");
}

#[test]
fn uneven_times_are_resampled_and_holes_are_gaps() {
    // Every step is off by up to 2 of 10 ms, and 0.1 s are missing; the coordinate is a line.
    let rows = (0..200).filter(|k| !(80..90).contains(k)).map(|k: i32| {
        let t = 10.0 * f64::from(k) + f64::from(k % 3) - 1.0 + f64::from(k % 2);
        format!("{t},{},0,0,0,-1000\n", 0.1 * t)
    });
    let text = format!("{HEADER}{}", rows.collect::<String>());
    let imported = import_text(&text, COLUMNS, |_| ()).unwrap();
    let recorded = ArmRecording::of(&imported.recording).unwrap();
    let rate = imported.recording.rate_hz().unwrap();
    assert!((rate - 100.0).abs() < 20.0, "{rate}");
    let q = recorded.joints[0].position.unwrap();
    for (t, q) in recorded.time.iter().zip(q) {
        // The line, from the first time -1 ms on, within rounding.
        let expected = (0.1 * (1e3 * t - 1.0)).to_radians();
        assert!((q - expected).abs() < 1e-12, "{q} at {t}");
    }
    for (t, gap) in recorded.time.iter().zip(recorded.gap) {
        assert_eq!(*gap, (0.7921..0.8999).contains(t), "at {t}");
    }
    let asked = import_text(&text, COLUMNS, |options| options.rate_hz = Some(50.0)).unwrap();
    assert!((asked.recording.rate_hz().unwrap() - 50.0).abs() < 1e-9);
    assert_eq!(asked.recording.meta().extra["resampled_hz"], "50");
}

#[test]
fn rows_that_cannot_be_read_are_refused_by_line_or_left_out_as_asked() {
    for (row, part) in [
        ("5070,x,14,10,20,0", "line 9: a: expected a finite number, got \"x\""),
        ("5070,NaN,14,10,20,0", "line 9: a: expected a finite number, got no number"),
        ("5070,inf,14,10,20,0", "line 9: a: expected a finite number, got inf"),
        ("5070,7,14,10,,0", "line 9: i2: expected a finite number"),
        ("5070,7,14,10", "line 9: expected 6 cells, as the first row has, got 4"),
        ("5050,7,14,10,20,0", "line 9: time: expected one after 5.06 s of line 8, got 5.05 s"),
        ("5060,7,14,10,20,0", "line 9: time: expected one after 5.06 s"),
        ("later,7,14,10,20,0", "line 9: t: expected a finite number, got \"later\""),
        ("1e400,7,14,10,20,0", "line 9: t: expected a finite number, got inf"),
    ] {
        let error = import_text(&log(7, row), COLUMNS, |_| ()).unwrap_err();
        assert!(error.contains(part) && error.contains("log.csv"), "{part:?} in {error}");
        let imported =
            import_text(&log(7, row), COLUMNS, |options| options.bad_rows = BadRows::LeaveOut).unwrap();
        assert_eq!((imported.n_left_out, imported.recording.n_samples()), (1, 50), "{row}");
        assert!(imported.recording.gap()[7], "{row}");
        assert!(imported.first_left_out.unwrap().place.starts_with("line 9"), "{row}");
    }
    // A time far ahead, which no later one exceeds, costs its own row alone.
    let ahead =
        import_text(&log(7, "9e9,7,14,10,20,0"), COLUMNS, |options| options.bad_rows = BadRows::LeaveOut);
    let ahead = ahead.unwrap();
    assert_eq!((ahead.n_left_out, ahead.recording.n_samples()), (1, 50));
    let first = ahead.first_left_out.unwrap().to_string();
    assert!(first.contains("line 9: time: expected one between those around it"), "{first}");
    let backwards: String = (0..50).map(|k| format!("{},0,0,0,0,0\n", 10 * (50 - k))).collect();
    let error = import_text(&format!("{HEADER}{backwards}"), COLUMNS, |o| o.bad_rows = BadRows::LeaveOut)
        .unwrap_err();
    assert!(error.contains("at most 10 %") && error.contains("49 of 50"), "{error}");
}

#[test]
fn joints_are_counted() {
    let three_currents = log(99, "").replace("i2,fz", "i2,i3").replace(",-1000", ",30");
    let columns = COLUMNS.replace("force_z_n = { columns = \"fz\", unlabelled = -1000 }", "");
    let error = import_text(&three_currents, &columns, |_| ()).unwrap_err();
    assert!(error.contains("q_3_rad: expected this channel of all 3 joints, got of 2"), "{error}");
    let names = COLUMNS.replace("\"elbow\"", "\"elbow\", \"wrist\"");
    let error = import_text(&log(99, ""), &names, |_| ()).unwrap_err();
    assert!(error.contains("joints: expected 3, as joint_names says, got 2"), "{error}");
    let panda = Model::builtin("panda").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, log(99, "")).unwrap();
    let columns = Some(ColumnMap::parse(COLUMNS, "test").unwrap());
    let known = ArmProperties { model: Some(&panda), ..Default::default() };
    let options = ImportOptions { columns, arm: known, ..Default::default() };
    let error = import(&path, &options, Metadata::default()).unwrap_err().to_string();
    assert!(error.contains("joints: expected 9, as \"panda\" has, got 2"), "{error}");
}

#[test]
fn numbers_in_another_unit_are_suspected() {
    let other = |from: &str, to: &str| COLUMNS.replace(from, to);
    let fast: String = (0..50).map(|k| format!("{},{},0,10,20,-1000\n", 10 * k, 3 * k)).collect();
    for (columns, channel, limit) in [
        (other("q_*_deg", "q_*_rad"), ": q_1_rad, rows 10: ", "at most 25 rad or m is plausible"),
        (
            other("current_*_ma", "current_*_a").replace("times = 2.0", "times = 200.0"),
            ": current_1_a, rows ",
            "at most 200 A is plausible",
        ),
    ] {
        let error = import_text(&format!("{HEADER}{fast}"), &columns, |_| ()).unwrap_err();
        for part in [channel, limit, "--accept-units"] {
            assert!(error.contains(part), "{part:?} in {error}");
        }
        import_text(&format!("{HEADER}{fast}"), &columns, |options| {
            options.arm.unit_check = UnitCheck::Accept
        })
        .unwrap();
    }
    // Speeds in degrees with coordinates in radians.
    let speeds: String = (0..200)
        .map(|k| {
            let phase = 0.05 * f64::from(k);
            format!("{},{},{}\n", 10 * k, phase.sin(), (5.0 * phase.cos()).to_degrees() / 10.0)
        })
        .collect();
    let columns =
        "format = \"hysteron-columns\"\nversion = 1\n[columns]\ntime_ms = 1\nq_1_rad = 2\ndq_1_rad_s = 3\n";
    let error = import_text(&speeds, columns, |_| ()).unwrap_err();
    assert!(
        error.contains(": dq_1_rad_s: ") && error.contains("times as fast as the recorded speeds"),
        "{error}"
    );
    import_text(
        &speeds,
        &columns.replace("dq_1_rad_s = 3", "dq_1_deg_s = { columns = 3, times = 10 }"),
        |_| (),
    )
    .unwrap();
}

#[test]
fn descriptions_that_cannot_be() {
    let parse = |from: &str, to: &str| {
        ColumnMap::parse(&COLUMNS.replacen(from, to, 1), "c.toml").unwrap_err().to_string()
    };
    assert!(parse("hysteron-columns", "columns").contains("format"));
    assert!(parse("version = 1", "version = 2").contains("version"));
    assert!(parse("missing", "colour").contains("colour"));
    assert!(
        parse("times = 2.0", "times = 0.0")
            .contains("columns.current_*_ma.times: expected a finite number other than 0")
    );
    assert!(parse("= \"t\"", "= []").contains("columns.time_ms: expected at least one column"));
    assert!(parse("= \"t\"", "= true").contains("a column, a list of columns"));
    for (from, to, part) in [
        ("= \"t\"", "= \"time\"", "columns.time_ms: expected a column \"time\", got t, a, b"),
        ("= \"t\"", "= 7", "columns.time_ms: expected column number 7"),
        ("= \"t\"", "= 0", "columns.time_ms: expected column number 0"),
        ("time_ms = \"t\"", "", "a column time_s, or rate_hz"),
        ("q_*_deg", "q_*_grad", "columns.q_*_grad: expected a name that ends in its unit"),
        ("\"q_*_deg\"", "q_1_deg", "columns.q_1_deg: expected one column, or a *"),
        ("q_*_deg", "Q_*_deg", "Q_1_rad"),
    ] {
        let error = import_text(&log(99, ""), &COLUMNS.replacen(from, to, 1), |_| ()).unwrap_err();
        assert!(error.contains(part), "{part:?} in {error}");
    }
    assert!(ColumnMap::named("nowhere").unwrap_err().to_string().contains("one of bam-dynamixel"));
    for name in ColumnMap::builtin_names() {
        ColumnMap::named(name).unwrap();
    }
}

/// An episode as LeRobot writes it: lists of single precision.
pub(crate) fn write_lerobot(path: &Path, n_episodes: i64) {
    let schema = "message episode {
        required group observation.state (LIST) { repeated group list { required float element; } }
        required group action (LIST) { repeated group list { required float element; } }
        required float timestamp; required int64 episode_index; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let file = std::fs::File::create(path).unwrap();
    let mut writer =
        SerializedFileWriter::new(file, schema, Arc::new(WriterProperties::builder().build())).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let n = 50 * n_episodes;
    for offset in [0.0_f32, 1.0] {
        let values: Vec<f32> = (0..n).flat_map(|k| [k as f32 + offset, -(k as f32)]).collect();
        let repeated: Vec<i16> = (0..n).flat_map(|_| [0, 1]).collect();
        let mut column = group.next_column().unwrap().unwrap();
        let levels = vec![1_i16; values.len()];
        column.typed::<FloatType>().write_batch(&values, Some(&levels), Some(&repeated)).unwrap();
        column.close().unwrap();
    }
    let mut column = group.next_column().unwrap().unwrap();
    let times: Vec<f32> = (0..n).map(|k| (k % 50) as f32 / 30.0).collect();
    column.typed::<FloatType>().write_batch(&times, None, None).unwrap();
    column.close().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    let episodes: Vec<i64> = (0..n).map(|k| k / 50).collect();
    column.typed::<Int64Type>().write_batch(&episodes, None, None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
}

#[test]
fn an_episode_of_lerobot_is_read_once_its_unit_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("episodes.parquet");
    write_lerobot(&path, 2);
    let read = |options: &ImportOptions| import(&path, options, Metadata::default());
    let error = read(&ImportOptions::default()).unwrap_err().to_string();
    assert!(error.contains("--map lerobot-deg or lerobot-rad"), "{error}");
    let columns = Some(ColumnMap::named("lerobot-deg").unwrap());
    let all = ImportOptions {
        columns,
        arm: ArmProperties { unit_check: UnitCheck::Accept, ..Default::default() },
        ..Default::default()
    };
    let error = read(&all).unwrap_err().to_string();
    assert!(error.contains("row 51: time") && error.contains("--where episode_index=0"), "{error}");
    let filter = Some(RowFilter { column: "episode_index".into(), value: "1".into() });
    let imported = read(&ImportOptions { filter, ..all.clone() }).unwrap();
    let recorded = ArmRecording::of(&imported.recording).unwrap();
    assert_eq!((recorded.joints.len(), recorded.time.len()), (2, 50));
    assert_eq!(recorded.joints[1].position.unwrap()[3], (-53.0_f64).to_radians());
    assert_eq!(recorded.joints[0].goal.unwrap()[3], 54.0_f64.to_radians());
    // Damaged anywhere, it is refused or read.
    let bytes = std::fs::read(&path).unwrap();
    for at in (0..bytes.len()).step_by(7) {
        let mut altered = bytes.clone();
        altered[at] ^= 0x55;
        std::fs::write(&path, &altered).unwrap();
        let _ = read(&all);
    }
}

/// Samples of a log of bam.
pub(crate) fn bam_entries() -> Vec<String> {
    (0..20)
        .map(|k| {
            let load = if k == 3 { 65_535 } else { 885 };
            format!(
                r#"{{"position": {}, "speed": 1.0, "load": {load}, "input_volts": 7.3, "temp": 28, "timestamp": {}, "goal_position": 0.5, "torque_enable": true}}"#,
                0.005 * f64::from(k), 0.005 * f64::from(k) + 3.0
            )
        })
        .collect()
}

/// A log of bam with these samples.
pub(crate) fn bam_log(motor: &str, entries: &str) -> String {
    format!(
        r#"{{"mass": 0.49, "length": 0.1, "kp": 100, "vin": 7.4, "motor": "{motor}", "trajectory": "sin_sin", "entries": [{entries}]}}"#
    )
}

#[test]
fn a_log_of_bam_holds_its_servo_and_its_pendulum() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.json");
    let entries = bam_entries();
    let log = bam_log;
    std::fs::write(&path, log("xl330", &entries.join(","))).unwrap();
    let read = || import(&path, &ImportOptions::default(), Metadata::default());
    let imported = read().unwrap();
    let recorded = ArmRecording::of(&imported.recording).unwrap();
    let joint = recorded.joints[0];
    // A register of 16 bits with sign: 65535 is -1.
    assert_eq!(joint.pwm.unwrap()[2..4], [1.0, -1.0 / 885.0]);
    assert_eq!(
        (joint.voltage.unwrap()[0], joint.temperature.unwrap()[0], joint.goal.unwrap()[0]),
        (7.3, 28.0, 0.5)
    );
    let extra = &imported.recording.meta().extra;
    let noted = ["mass_kg", "length_m", "position_gain", "supply_v", "motor", "bam.trajectory"]
        .map(|key| extra[key].as_str());
    assert_eq!(noted, ["0.49", "0.1", "100", "7.4", "xl330", "sin_sin"]);
    std::fs::write(&path, log("sts3250", &entries.join(","))).unwrap();
    let imported = read().unwrap();
    assert_eq!(imported.columns, "bam-feetech");
    assert!(ArmRecording::of(&imported.recording).unwrap().joints[0].pwm.is_none());
    for (text, part) in [
        ("[1, 2]".to_owned(), "a log of bam"),
        ("{}".to_owned(), "samples under \"entries\""),
        (log("xl330", ""), "at least one sample"),
        (log("xl330", "1, 2"), "at least one sample"),
        (
            log("xl330", &entries.join(",").replace("7.3", "null")),
            "row 1: input_volts: expected a finite number",
        ),
        ("{\"entries\": 3}".to_owned(), "a list of samples"),
        ("[".repeat(1 << 20), "line 1"),
    ] {
        std::fs::write(&path, text).unwrap();
        let error = read().unwrap_err().to_string();
        assert!(error.contains(part) && error.contains("log.json"), "{part:?} in {error}");
    }
}

#[test]
fn currents_that_a_log_leaves_out_follow_from_the_voltage_on_the_motor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.json");
    let drive = CatalogueDrive::named("xl330-m288").unwrap();
    let read = |log: String| {
        std::fs::write(&path, log).unwrap();
        let options = ImportOptions {
            arm: ArmProperties { drive: Some(&drive), ..Default::default() },
            ..Default::default()
        };
        import(&path, &options, Metadata::default())
    };
    let (k, ohm) = (drive.drive.motor.torque_constant(), drive.drive.motor.resistance());
    let Winding { reference, resistance_slope, magnet_slope, .. } = drive.drive.winding;
    let warm = [magnet_slope, resistance_slope].map(|slope| slope * (28.0 - reference));
    // The log's motor turns at 1 rad/s, at 28 °C.
    let current = |volts: f64| (volts - k * (1.0 - warm[0])) / (ohm * (1.0 + warm[1]));
    let imported = read(bam_log("xl330", &bam_entries().join(","))).unwrap().recording;
    let found = imported.channel("current_1_a").unwrap();
    // At full duty more would flow than the drive allows; at -1/885 the turning motor brakes.
    assert_eq!(found[0], drive.drive.motor.current_limit);
    assert!((found[3] - current(-7.3 / 885.0)).abs() < 1e-9, "{} {}", found[3], current(-7.3 / 885.0));
    assert_eq!(imported.meta().extra["currents_by"], drive.name);
    // Without a recorded duty that of the position loop: 100/256 PWM units of 885 per tick.
    let imported = read(bam_log("sts3250", &bam_entries().join(","))).unwrap().recording;
    let per_radian = 100.0 / 256.0 / 885.0 * 4096.0 / std::f64::consts::TAU;
    let [goal, q, pwm, found] = ["goal_1_rad", "q_1_rad", "pwm_1_ratio", "current_1_a"]
        .map(|name| imported.channel(name).unwrap().to_vec());
    let duty = per_radian * (goal[10] - q[10]);
    assert!((pwm[10] - duty).abs() < 1e-12 && duty > 0.1, "{} {duty}", pwm[10]);
    assert!((found[10] - current(7.3 * duty)).abs() < 1e-9, "{} {}", found[10], current(7.3 * duty));
    // With the torque off no current flows.
    let off = bam_entries().join(",").replace("true", "false");
    let imported = read(bam_log("xl330", &off)).unwrap().recording;
    assert!(imported.channel("current_1_a").unwrap().iter().all(|current| *current == 0.0));
    let error = read(bam_log("sts3250", &bam_entries().join(",")).replace("\"kp\"", "\"gain\"")).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("log.json: pwm_1_ratio: expected this channel, got none")
            && text.contains("position gain"),
        "{text}"
    );
}

#[test]
fn garbage_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut state = 1_u64;
    let mut garbage: Vec<u8> = (0..10 << 20)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 56) as u8
        })
        .collect();
    for is_text in [false, true] {
        if is_text {
            let printable = b"0123456789.,;-eE \n\tabc\"{}[]";
            garbage.iter_mut().for_each(|byte| *byte = printable[usize::from(*byte) % printable.len()]);
        }
        for extension in ["csv", "txt", "npz", "npy", "json", "parquet", "log"] {
            let path = folder.path().join(format!("garbage.{extension}"));
            std::fs::write(&path, &garbage).unwrap();
            let columns = Some(ColumnMap::named("ur10e").unwrap());
            for columns in [None, columns] {
                let options = ImportOptions { columns, bad_rows: BadRows::LeaveOut, ..Default::default() };
                let error = import(&path, &options, Metadata::default()).unwrap_err().to_string();
                assert!(error.contains("garbage") && error.len() < 3000, "{extension}: {error}");
            }
        }
    }
}

fn imported(path: &Path, columns: Option<&str>) -> Recording {
    let columns = columns.map(|name| ColumnMap::named(name).unwrap());
    let imported =
        import(path, &ImportOptions { columns, ..Default::default() }, Metadata::default()).unwrap();
    imported.recording
}

#[test]
fn public_recordings_are_read_as_they_are() {
    let name = "public_recordings_are_read_as_they_are";
    for (what, columns, joints, rate, rows) in [
        ("nad/excerpt-omx.csv", None, 5, 58.82, 8),
        ("baxter/test/circle_XY_T2_r10_ang_vel_torq.csv", None, 7, 100.0, 5651),
        ("ur10e/ur-20_02_19_15harm50sec.csv", Some("ur10e"), 6, 100.0, 5347),
        ("friction-franka/franka_case3_slow.csv", None, 1, 500.0, 25_391),
        ("panda-gaz", None, 7, 1000.0, 20_544),
        ("kuka-lwr4/measurements_1.npz", None, 7, 200.0, 5027),
        ("bam/xl330/2026-01-15_10h28m10.json", None, 1, 188.6, 1124),
        ("bam/data_raw_feetech/2024-10-26_12h23m27.json", None, 1, 48.68, 286),
        ("bam/atomic/data/friction_1.json", None, 1, 62.5, 313),
    ] {
        let Some(path) = recorded(name, &format!("arms/{what}")) else { continue };
        let recording = imported(&path, columns);
        let found = recording.rate_hz().unwrap();
        assert_eq!(ArmRecording::of(&recording).unwrap().joints.len(), joints, "{what}");
        assert!((found - rate).abs() < 0.03 * rate, "{what}: {found} Hz");
        // As many as the time at that rate holds.
        let n = recording.n_samples() as f64;
        assert!((n - f64::from(rows)).abs() < 0.2 * f64::from(rows), "{what}: {n} rows");
    }
}

/// A table with these columns (`*` for 1 to n), each of the value next to it, at `period` [s].
fn table(columns: &[(&str, usize, f64)], period: f64) -> String {
    let names: Vec<(String, f64)> = columns
        .iter()
        .flat_map(|(name, n, value)| (1..=*n).map(move |k| (name.replace('*', &k.to_string()), *value)))
        .collect();
    let header: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
    let row = |k: usize| {
        let cells: Vec<String> = names.iter().map(|(_, value)| value.to_string()).collect();
        format!("{},{}\n", period * k as f64, cells.join(","))
    };
    format!("timestamp,{}\n{}", header.join(","), (0..30).map(row).collect::<String>())
}

#[test]
fn every_layout_of_nad_is_known_by_its_columns() {
    // As the data set's description has them: 44, 46 and 72 columns with the time; a label in z alone.
    let force = [("force_x", 1, -999.0), ("force_y", 1, -999.0), ("force_z", 1, -4.9)];
    let omx = [
        &[("pos*", 5, 0.2), ("aperture", 1, 11.5), ("goal_pos*", 5, 0.3), ("goal_aperture", 1, 11.6)][..],
        &[("current*", 5, -53.8), ("vel*", 5, 0.048), ("temp*", 5, 31.0), ("pwm*", 5, -44.25)],
        &[("volts*", 5, 12.9)],
        &force,
        &[("force_gripper_x", 1, 0.0), ("force_gripper_y", 1, 0.0), ("force_gripper_z", 1, 0.0)],
    ]
    .concat();
    let so101 = [
        &[("pos*", 6, 0.2), ("goal_pos*", 6, 0.3), ("current*", 6, 10.0), ("vel*", 6, 1024.0)][..],
        &[("load*", 6, -250.0), ("temp*", 6, 31.0), ("volts*", 6, 123.0)],
        &force,
    ]
    .concat();
    let panda = [
        &[("pos*", 7, 0.2), ("gripper_width", 1, 0.5), ("vel*", 7, 0.1), ("vel_d*", 7, 0.2)][..],
        &[("tau_d*", 7, 1.0), ("tau*", 7, 2.0), ("tau_ext*", 7, 3.0), ("cmd_pos*", 7, 0.3)],
        &[("motor_pos*", 7, 0.25), ("motor_vel*", 7, 0.15)],
        &force,
        &[("torque_ext_x", 1, 0.0), ("torque_ext_y", 1, 0.0), ("torque_ext_z", 1, 0.0), ("lifting", 1, 1.0)],
    ]
    .concat();
    let turn = std::f64::consts::TAU;
    let known: [(_, _, _, _, &[(&str, f64)]); 3] = [
        (
            "nad-omx",
            omx,
            0.017,
            44,
            &[("current_5_a", -0.0538), ("pwm_3_ratio", -0.05), ("aperture_m", 0.0115)],
        ),
        (
            "nad-so101",
            so101,
            1.0 / 62.3,
            46,
            &[
                ("current_6_a", 0.065),
                ("dq_6_rad_s", turn / 4.0),
                ("pwm_6_ratio", -0.25),
                ("voltage_1_v", 12.3),
            ],
        ),
        (
            "nad-panda",
            panda,
            0.016,
            72,
            &[
                ("tau_7_n_m", 2.0),
                ("goal_tau_7_n_m", 1.0),
                ("tau_external_7_n_m", 3.0),
                ("motor_q_7_rad", 0.25),
                ("goal_1_rad", 0.3),
            ],
        ),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (name, columns, period, n_columns, values) in known {
        assert_eq!(1 + columns.iter().map(|(_, n, _)| n).sum::<usize>(), n_columns, "{name}");
        let path = folder.path().join(format!("{name}.csv"));
        std::fs::write(&path, table(&columns, period)).unwrap();
        let imported = import(&path, &ImportOptions::default(), Metadata::default()).unwrap();
        assert_eq!(imported.columns, name);
        let recording = &imported.recording;
        for (channel, value) in values {
            let found = recording.require(channel).unwrap()[7];
            // The factors of the registers are exact to their sixteen digits.
            assert!((found - value).abs() < 1e-12, "{name} {channel}: {found}");
        }
        assert!(recording.channel("force_x_n").is_none(), "{name}: no label is not no force");
        assert_eq!(recording.require("force_z_n").unwrap()[7], -4.9);
        assert_eq!(recording.require("force_z_labelled_ratio").unwrap()[7], 1.0);
    }
}
