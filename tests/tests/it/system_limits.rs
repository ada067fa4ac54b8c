//! A machine that is short of memory, or lets no file grow (`ulimit`): one clear error, and nothing half written.

use std::process::{Command, Stdio};

use hysteron_tests::{Workplace, names_in, program};

/// Largest file [512 byte], of a shell that has no finer unit: 4 kB.
const SMALL_FILE: &str = "ulimit -f 8";
/// Address space that leaves a verb nothing to begin with [kB].
const NO_MEMORY: &str = "ulimit -v 60000";

/// Runs a verb behind a limit; its exit code, what it printed as errors, and what is new in the folder.
fn limited(place: &Workplace, limit: &str, line: &str) -> (Option<i32>, String, Vec<String>) {
    let before = names_in(place.path());
    let script = format!("{limit}; exec {} {line}", program().display());
    let mut command = Command::new("sh");
    command.args(["-c", &script]).current_dir(place.path()).env_remove("RUST_LOG");
    let output = command.stdin(Stdio::null()).output().unwrap();
    let is_new = |name: &String| !before.contains(name);
    let new = names_in(place.path()).into_iter().filter(is_new).collect();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), new)
}

fn errors(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.starts_with("error: ")).collect()
}

#[test]
fn a_file_that_must_not_grow_is_an_error_and_leaves_nothing() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 200);
    place.simulate("strokes.csv", "tip.csv").succeeded();
    // Half as fast as the rig may go, and back.
    let slow = |k: i32| {
        let stroke = 0.05 * f64::from(k.min(100 - k));
        format!("{:.2},{stroke:.4},0,{:.4},0\n", 0.01 * f64::from(k), -stroke)
    };
    let rows: String = (0..=100).map(slow).collect();
    place.write("slow.csv", format!("time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n{rows}"));
    for line in [
        "simulate scene.toml --strokes strokes.csv --out out.csv",
        "simulate scene.toml --strokes strokes.csv --out out.parquet",
        "record --rig virtual:typical --strokes slow.csv --out out.parquet",
        "target circle:40 --out out.csv",
        "mesh --length-mm 80 --outer-diameter-mm 8 --edge-mm 2 --out out.msh",
        "import tip.csv --map time_s=time_s;tip_x_mm=tip_x_mm;tip_y_mm=tip_y_mm --out out.csv",
        "generate scene.toml --plan quick --shard 1/5 --out out",
    ] {
        let (code, text, new) = limited(&place, SMALL_FILE, &line.replace(';', "\\;"));
        assert_eq!(code, Some(1), "{line}: {text}");
        let lines = errors(&text);
        assert!(lines.len() == 1 && lines[0].to_lowercase().contains("file too large"), "{line}: {text}");
        // A journal of what a rig has measured is kept on purpose; a folder may remain, but without half-written files.
        let half_written = |name: &String| {
            let path = place.path().join(name);
            let inside = if path.is_dir() { names_in(&path) } else { vec![name.clone()] };
            inside
                .into_iter()
                .filter(|name| !name.ends_with(".journal") && !name.ends_with(".toml"))
                .collect()
        };
        let left: Vec<String> = new.iter().flat_map(|name| -> Vec<String> { half_written(name) }).collect();
        assert_eq!(left, [""; 0], "{line}");
        for name in new {
            let path = place.path().join(name);
            if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) }.unwrap();
        }
    }
}

#[test]
fn a_machine_without_memory_is_an_error_before_the_work() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 20);
    for line in [
        "simulate scene.toml --strokes strokes.csv --out out.csv",
        "check scene.toml",
        "arm info three-link",
        "record --rig virtual:typical --plan quick --out out",
        "evaluate --target circle:40 strokes.csv --out out",
    ] {
        let (code, text, new) = limited(&place, NO_MEMORY, line);
        assert_eq!(code, Some(2), "{line}: {text}");
        let lines = errors(&text);
        assert!(lines.len() == 1 && lines[0].contains("memory: expected at least"), "{line}: {text}");
        assert_eq!(new, [""; 0], "{line}");
    }
}

/// A recording that is read and computed with in 400 MB of address space only if it is shorter: named, before the work.
#[test]
fn recordings_that_the_memory_has_no_room_for_are_an_error_before_the_work() {
    let place = Workplace::new();
    let row = |k: u32| {
        let (x, y) = f64::from(k % 1000).mul_add(1e-3, -0.5).sin_cos();
        format!(
            "{:.2},{x:.4},{y:.4},{:.4},{:.4},{:.3},{:.3},80\n",
            0.01 * f64::from(k),
            -x,
            -y,
            4.0 * x,
            4.0 * y
        )
    };
    let rows: String = (0..2_000_000).map(row).collect();
    let strokes = "stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm";
    place.write("long.csv", format!("time_s,{strokes},tip_x_mm,tip_y_mm,tip_z_mm\n{rows}"));
    drop(rows);
    for line in [
        "simulate scene.toml --strokes long.csv --out out.csv",
        "reach scene.toml --goals long.csv --out out.csv",
        "evaluate --target circle:40 long.csv --out out",
        "check long.csv",
        "train long.csv --out out.safetensors",
        "import long.csv --out out.csv",
    ] {
        for limit in [150_000, 250_000, 400_000] {
            let (code, text, new) = limited(&place, &format!("ulimit -v {limit}"), line);
            assert_eq!(code, Some(2), "{line}, {limit} kB: {text}");
            let printed = errors(&text);
            let is_named = |line: &str| line.contains("of memory") && line.contains("(hint: ");
            assert!(printed.len() == 1 && is_named(printed[0]), "{line}, {limit} kB: {text}");
            assert_eq!(new, [""; 0], "{line}, {limit} kB");
        }
    }
}
