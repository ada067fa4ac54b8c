//! End-to-end tests of `hysteron`, through the built program.
//!
//! This library finds the program and the repository, runs commands and looks at what they leave. The tests lie in
//! `tests/`, one file per subject.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

#[cfg(unix)]
pub mod emulated;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::Duration;
#[cfg(unix)]
use std::time::Instant;

/// Root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// The program, built like the tests that ask for it: same profile, same folder.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        // .../<profile>/deps/<test>
        let test = std::env::current_exe().unwrap();
        let folder = test.parent().unwrap().parent().unwrap();
        let mut build = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        build.args(["build", "--package", "hysteron", "--bin", "hysteron", "--target-dir"]);
        build.arg(folder.parent().unwrap()).current_dir(root());
        if folder.file_name().is_some_and(|name| name == "release") {
            build.arg("--release");
        }
        let built = build.stdin(Stdio::null()).output().unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        folder.join(format!("hysteron{}", std::env::consts::EXE_SUFFIX))
    })
}

/// Result of a run of the program: exit code and output.
#[derive(Debug)]
pub struct Outcome {
    /// Exit code; none if a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

/// Runs the program in `folder` with these arguments.
pub fn run(folder: &Path, arguments: &[&str]) -> Outcome {
    Outcome::of(command(folder, arguments).output().unwrap())
}

/// The same, and the most memory that it had [MB]; 0 where the system does not report it.
pub fn measured(folder: &Path, arguments: &[&str]) -> (Outcome, u64) {
    let mut command = command(folder, arguments);
    let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let status = format!("/proc/{}/status", process.id());
    let mut peak = 0;
    while process.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        peak = peak.max(kilobytes.unwrap_or(0) / 1024);
        std::thread::sleep(Duration::from_millis(2));
    }
    (Outcome::of(process.wait_with_output().unwrap()), peak)
}

/// The same, and asks it to stop, as Ctrl-C does, once there is a file `sign`.
#[cfg(unix)]
pub fn interrupt(folder: &Path, arguments: &[&str], sign: &str) -> Outcome {
    let mut command = command(folder, arguments);
    let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while !folder.join(sign).exists() {
        assert!(process.try_wait().unwrap().is_none(), "it has ended without {sign}");
        assert!(start.elapsed() < Duration::from_secs(60), "no {sign}");
        std::thread::sleep(Duration::from_millis(2));
    }
    emulated::signal(&process, "INT");
    Outcome::of(process.wait_with_output().unwrap())
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    command.args(arguments).current_dir(folder).env_remove("RUST_LOG").stdin(Stdio::null());
    command
}

impl Outcome {
    fn of(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    /// Fails unless the program succeeded.
    pub fn succeeded(self) -> Self {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        self
    }

    /// The one error, `error: …` with the indented lines below it; fails unless the exit code is this one.
    pub fn error(&self, code: i32) -> &str {
        assert_eq!(self.code, Some(code), "{}\n{}", self.stdout, self.stderr);
        let is_error = |line: &&str| line.contains("error: ");
        assert_eq!(self.stderr.lines().filter(is_error).count(), 1, "not one error: {}", self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        let at = self.stderr.find("error: ").unwrap_or_default();
        assert!(at == 0 || self.stderr[..at].ends_with('\n'), "{}", self.stderr);
        let error = &self.stderr[at..];
        let below = error.split_inclusive('\n').skip(1).take_while(|line| line.starts_with("  "));
        let first = error.find('\n').map_or(error.len(), |end| end + 1);
        error[..first + below.map(str::len).sum::<usize>()].trim_end()
    }
}

/// Names of everything in a folder, sorted.
pub fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Folders of the crates of the workspace, from its root.
pub fn members() -> Vec<String> {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let list = manifest.split_once("members = [").unwrap().1.split_once(']').unwrap().0;
    let names = list.split(',').map(|name| name.trim().trim_matches('"').to_owned());
    names.filter(|name| !name.is_empty()).collect()
}

/// A folder of its own with the scene `meshes/tpu80/scene.toml` and its mesh.
pub struct Workplace(tempfile::TempDir);

impl Default for Workplace {
    fn default() -> Self {
        Self::new()
    }
}

impl Workplace {
    /// Copies scene and mesh into a new folder.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in ["scene.toml", "scene-coreact.toml", "scene-friction.toml", "tpu80.msh"] {
            std::fs::copy(root().join("meshes/tpu80").join(name), folder.path().join(name)).unwrap();
        }
        Self(folder)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path().join(name), content).unwrap();
    }

    /// Reads a file.
    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path().join(name)).unwrap()
    }

    /// Replaces text that a file must have.
    pub fn replace(&self, name: &str, from: &str, to: &str) {
        let text = String::from_utf8(self.read(name)).unwrap();
        assert!(text.contains(from), "{name} without {from:?}");
        self.write(name, text.replacen(from, to, 1));
    }

    /// Writes strokes: a circle of 2 mm, `n` samples at 100 Hz.
    pub fn write_circle(&self, name: &str, n: usize) {
        let mut csv = String::from("time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n");
        for i in 0..n {
            let (t, a) = (i as f64 / 100.0, 2.0 * (i as f64 / 30.0).min(1.0));
            let (c, s) = ((6.0 * t).cos(), (6.0 * t).sin());
            csv.push_str(&format!("{t:.2},{:.4},{:.4},{:.4},{:.4}\n", a * c, a * s, -a * c, -a * s));
        }
        self.write(name, csv);
    }

    /// Runs the program here.
    pub fn run(&self, arguments: &[&str]) -> Outcome {
        run(self.path(), arguments)
    }

    /// Simulates `scene.toml` with these strokes.
    pub fn simulate(&self, strokes: &str, out: &str) -> Outcome {
        self.run(&["simulate", "scene.toml", "--strokes", strokes, "--out", out])
    }
}
