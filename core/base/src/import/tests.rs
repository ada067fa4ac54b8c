//! Files of other programs as recordings, and the errors of those that are refused.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/tables").join(name)
}

fn imported(files: &[(&str, &str)], map: &str, change: impl FnOnce(&mut Request)) -> Result<Vec<Assembled>> {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = files
        .iter()
        .map(|(name, text)| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        })
        .collect();
    let columns =
        if map.contains("[columns]") { ColumnMap::parse(map, "test")? } else { ColumnMap::named(map)? };
    let mut request = Request { columns: Some(columns), ..Request::default() };
    change(&mut request);
    read(&paths, &request, Metadata::default())
}

fn one(files: &[(&str, &str)], map: &str) -> Recording {
    let mut all = imported(files, map, |_| ()).unwrap();
    assert_eq!(all.len(), 1);
    all.remove(0).recording
}

const HEAD: &str = "format = \"hysteron-columns\"\nversion = 1\n";

#[test]
fn a_semicolon_table_with_decimal_commas_is_read() {
    let columns = Some(ColumnMap::named(&data("cols.toml").display().to_string()).unwrap());
    let request = Request { columns, ..Request::default() };
    let all = read(&[data("semicolon_decimal_comma.csv")], &request, Metadata::default()).unwrap();
    let recording = &all[0].recording;
    assert_eq!(recording.channel("tau_1_n_m").unwrap()[1], 0.03999733338666616);
    assert_eq!(recording.channel("q_2_rad").unwrap()[1], 0.49977501687449377);
    assert!((recording.rate_hz().unwrap() - 100.0).abs() < 1e-6);
    assert_eq!(all[0].n_left_out, 0);
}

#[test]
fn a_repeated_stamp_is_named_with_both_rows_and_a_hint_that_helps() {
    let request = Request { columns: Some(ColumnMap::named("lerobot-deg").unwrap()), ..Request::default() };
    let error =
        read(&[data("repeated_stamp.parquet")], &request, Metadata::default()).unwrap_err().to_string();
    assert!(error.contains("expected one after ") && error.contains(" s of row "), "{error}");
    assert!(error.contains("--leave-out-bad-rows") && !error.contains("episode"), "{error}");
    let lenient = Request { bad_rows: BadRows::LeaveOut, ..request };
    let all = read(&[data("repeated_stamp.parquet")], &lenient, Metadata::default()).unwrap();
    assert_eq!(all[0].n_left_out, 1);
}

#[test]
fn rows_that_are_no_numbers_throughout_are_not_cured_by_leaving_them_out() {
    let text = "t,x\n0,1.000,5\n";
    let error = imported(&[("a.csv", text)], "time_s=t; tip_x_mm=x", |_| ()).unwrap_err().to_string();
    assert!(!error.contains("--leave-out-bad-rows"), "{error}");
    let words = "t,x\n0,near\n1,far\n2,near\n";
    let error = imported(&[("a.csv", words)], "time_s=t; tip_x_mm=x", |_| ()).unwrap_err().to_string();
    assert!(error.contains("\"near\"") && error.contains("their format or their columns"), "{error}");
}

#[test]
fn a_map_in_line_has_units_signs_and_wildcards() {
    let text = "t,X,cmd1,cmd2\n0,80,1,2\n10,81,3,4\n20,82,5,6\n";
    let recording = one(&[("a.csv", text)], "time_ms=t; tip_x_mm=X; stroke_*_mm=-cmd*");
    assert_eq!(recording.time(), [0.0, 0.01, 0.02]);
    assert_eq!(recording.channel("tip_x_m").unwrap(), [0.08, 0.081, 0.082]);
    assert_eq!(recording.strokes(), [[-0.001, -0.003, -0.005], [-0.002, -0.004, -0.006]]);
    // From 0, with leading zeros, or by any text, in the order of the file.
    for text in ["t,c0,c1\n0,1,2\n1,3,4\n", "t,c01,c02\n0,1,2\n1,3,4\n", "t,cleft,cright\n0,1,2\n1,3,4\n"] {
        let recording = one(&[("a.csv", text)], "time_s=t; stroke_*_m=c*");
        assert_eq!(recording.strokes(), [[1.0, 3.0], [2.0, 4.0]], "{text}");
    }
    let error = imported(&[("a.csv", text)], "tip_x_mm", |_| ()).unwrap_err().to_string();
    assert!(error.contains("a file, or one of"), "{error}");
}

#[test]
fn scales_offsets_zeros_and_constants() {
    let map = format!(
        "{HEAD}[constants]\nsupply_mv = 12000\n[columns]\ntime_s = \"t\"\n\
         tip_x_mm = {{ columns = \"x\", scale = -2, offset = 1 }}\nstroke_1_mm = {{ columns = \"s\", zero = \"first\" }}\n"
    );
    let recording = one(&[("a.csv", "t,x,s\n5,10,100\n6,11,103\n")], &map);
    assert_eq!(recording.channel("tip_x_m").unwrap(), [-0.019, -0.021]);
    let stroke = recording.strokes()[0];
    assert!(stroke[0] == 0.0 && (stroke[1] - 0.003).abs() < 1e-16);
    assert_eq!(recording.channel("supply_v").unwrap(), [12.0, 12.0]);
    assert_eq!(recording.meta().extra["time_origin_s"], "5");
}

#[test]
fn a_trackers_frame_is_turned_and_shifted() {
    let map = format!(
        "{HEAD}[tracker]\nrotation_deg = [0, 0, 90]\ntranslation_mm = [0, 0, 5]\n[columns]\ntime_s = \"t\"\n\
         tip_x_mm = \"x\"\ntip_y_mm = \"y\"\ntip_z_mm = \"z\"\n"
    );
    let recording = one(&[("a.csv", "t,x,y,z\n0,1,2,3\n1,1,2,3\n")], &map);
    let tip = recording.tip().unwrap().map(|axis| axis[0]);
    for (found, expected) in tip.iter().zip([-0.002, 0.001, 0.008]) {
        assert!((found - expected).abs() < 1e-17, "{tip:?}");
    }
}

#[test]
fn the_programs_own_names_need_no_map() {
    let text = "time_s,q_1_rad,tau_1_n_m,tip_x_mm,load_1\n0,0.1,1,2,5\n0.01,0.2,2,4,6\n0.02,0.3,3,6,7\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.csv");
    std::fs::write(&path, text).unwrap();
    let all = read(std::slice::from_ref(&path), &Request::default(), Metadata::default()).unwrap();
    let recording = &all[0].recording;
    assert_eq!((all[0].columns.as_str(), recording.channels().len()), ("own names", 4));
    assert_eq!(recording.channel("q_1_rad").unwrap(), [0.1, 0.2, 0.3]);
    assert_eq!(recording.channel("tip_x_m").unwrap(), [2e-3, 4e-3, 6e-3]);
    assert_eq!(recording.channel("load_1").unwrap(), [5.0, 6.0, 7.0]);
    // One unknown name, or no time: the error asks for a map.
    for text in [text.replace("load_1", "load"), text.replace("time_s", "clock_n")] {
        std::fs::write(&path, text).unwrap();
        let error = read(std::slice::from_ref(&path), &Request::default(), Metadata::default()).unwrap_err();
        assert!(error.to_string().contains("--map FILE takes it"), "{error}");
    }
}

#[test]
fn episodes_of_a_file_are_recordings_of_their_own() {
    let text = "t,trial,x\n0,a,1\n1,a,2\n0,b,5\n1,b,6\n2,b,7\n";
    let split = |request: &mut Request| request.episode = Some("trial".into());
    let all = imported(&[("a.csv", text)], "time_s=t; tip_x_m=x", split).unwrap();
    let found: Vec<(Option<&str>, usize)> =
        all.iter().map(|one| (one.episode.as_deref(), one.recording.n_samples())).collect();
    assert_eq!(found, [(Some("a"), 2), (Some("b"), 3)]);
    assert_eq!(all[1].recording.meta().extra["episode"], "b");
    let filter = |request: &mut Request| request.filter = RowFilter::parse("--where", "trial=b").ok();
    let only = imported(&[("a.csv", text)], "time_s=t; tip_x_m=x", filter).unwrap();
    assert_eq!(only[0].recording.channel("tip_x_m").unwrap(), [5.0, 6.0, 7.0]);
}

#[test]
fn files_with_clocks_of_their_own_are_joined_by_stamp() {
    // The second begins later, runs at half the rate, and has a hole from 0.6 to 1.2 s.
    let first = "t,x\n0.0,0\n0.1,1\n0.2,2\n0.3,3\n0.4,4\n0.5,5\n0.6,6\n0.7,7\n0.8,8\n0.9,9\n1.0,10\n";
    let second = "t,f\n0.2,20\n0.4,40\n0.6,60\n1.2,120\n1.4,140\n";
    let map = format!("{HEAD}[columns]\ntime_s = \"t\"\ntip_x_m = \"x\"\nforce_z_n = \"f\"\n");
    let recording = one(&[("a.csv", first), ("b.csv", second)], &map);
    let force = recording.channel("force_z_n").unwrap();
    assert!((force[3] - 30.0).abs() < 1e-12 && force[2] == 20.0);
    let marks: String = recording.gap().iter().map(|gap| if *gap { 'x' } else { '.' }).collect();
    assert_eq!(marks, "xx.....xxxx");
    // Held, and 0.1 s later.
    let held = format!("{HEAD}[join]\nhold = true\noffset_s = 0.1\n{}", &map[HEAD.len()..]);
    let recording = one(&[("a.csv", first), ("b.csv", second)], &held);
    assert_eq!(recording.channel("force_z_n").unwrap()[4..6], [20.0, 40.0]);
    assert!(!recording.gap()[9]);
    // By a key; rows without one are gaps.
    let by =
        format!("{HEAD}rate_hz = 10\n[join]\nby = \"ID\"\n[columns]\ntip_x_m = \"x\"\nforce_z_n = \"f\"\n");
    let recording = one(&[("a.csv", "ID,x\n7,1\n8,2\n9,3\n"), ("b.csv", "ID,f\n9,30\n7,10\n")], &by);
    assert_eq!(recording.channel("force_z_n").unwrap(), [10.0, 20.0, 30.0]);
    assert_eq!(recording.gap(), [false, true, false]);
    // Columns of one file, a stamp against seconds: absolute times count.
    let streams = format!(
        "{HEAD}[[streams]]\ntime = \"t2\"\ncolumns = [\"f\"]\nhold = true\n[columns]\ntime_s = \"t\"\ntip_x_m = \"x\"\nforce_z_n = \"f\"\n"
    );
    let text = "t,x,t2,f\n2024-01-01T00:00:00Z,1,2024-01-01T01:00:00+01:00,5\n2024-01-01T00:00:01Z,2,2024-01-01T01:00:01.5+01:00,6\n\
                2024-01-01T00:00:02Z,3,,\n";
    let recording = one(&[("a.csv", text)], &streams);
    assert_eq!(recording.channel("force_z_n").unwrap(), [5.0, 5.0, 6.0]);
    assert_eq!(recording.time(), [0.0, 1.0, 2.0]);
}

#[test]
fn dates_and_times_of_day_apart_are_one_time() {
    let text = "day;clock;x\n2024-05-06;23:59:59,5;1,5\n2024-05-07;00:00:00;2,5\n2024-05-07;00:00:00,5;3,5\n";
    let recording = one(&[("a.csv", text)], "time_s=day,clock; tip_x_mm=x");
    assert_eq!(recording.time(), [0.0, 0.5, 1.0]);
    assert_eq!(recording.channel("tip_x_m").unwrap(), [0.0015, 0.0025, 0.0035]);
}

#[test]
fn a_proposed_map_imports_the_file_it_was_made_for() {
    let text =
        "Time [ms],cmd1,cmd2,X [mm],Y [mm],Z [mm],note\n0,1,2,80,1,2,a\n10,3,4,81,1,2,b\n20,5,6,82,1,2,c\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    std::fs::write(&path, text).unwrap();
    let map = propose_for(&path).unwrap();
    assert!(map.contains("\"note\": text") && map.contains("its unit is stated"), "{map}");
    let recording = one(&[("a.csv", text)], &map);
    assert_eq!(recording.time(), [0.0, 0.01, 0.02]);
    assert_eq!(recording.tip().unwrap()[0], [0.08, 0.081, 0.082]);
    assert_eq!(recording.strokes()[1], [0.002, 0.004, 0.006]);
    // Of a LeRobot episode: degrees, by the range.
    let map = propose_for(&data("repeated_stamp.parquet")).unwrap();
    assert!(map.contains("\"q_*_deg\"") && map.contains("observation.state[1]"), "{map}");
    ColumnMap::parse(&map, "test").unwrap();
}

#[test]
fn every_builtin_map_is_short_and_can_be_read() {
    for name in ColumnMap::builtin_names() {
        ColumnMap::named(name).unwrap();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("columns").join(format!("{name}.toml"));
        assert!(std::fs::read_to_string(path).unwrap().lines().count() < 30, "{name}");
    }
}
