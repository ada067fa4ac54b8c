//! An emulated rig as a process of its own, and what it notes of its servos.

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::{program, run};

/// The positions of the servos at power-on are drawn from the seed. With this one all four are far enough from where
/// their count wraps that the emulator mounts their horns as the simulation does: one calibration fits both.
const SEED: &str = "3";

/// Calibration of the simulated rig, the same for all.
fn calibration() -> &'static [u8] {
    static TEXT: OnceLock<Vec<u8>> = OnceLock::new();
    TEXT.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let out = ["--seed", SEED, "--out", "calibration.toml"];
        run(folder.path(), &[&["rig", "calibrate", "--rig", "virtual:typical"], &out[..]].concat())
            .succeeded();
        std::fs::read(folder.path().join("calibration.toml")).unwrap()
    })
}

/// A plan of one circle that is sustained for so long [s]; 1.6 s more are rest, rise and fall.
fn plan(sustain: f64) -> String {
    format!(
        "format = \"hysteron-plan\"\nversion = 1\nname = \"short\"\nseed = 1\nrate_hz = 100\n\
         tendon_angles_deg = [0, 90, 180, 270]\nrelease = 1.0\nscale = 1.0\nrest_before_s = 0.2\n\
         rest_after_s = 0.2\nstroke_max_mm = 8\nstroke_rate_max_mm_s = 8\n[[trajectory]]\nname = \"circle\"\n\
         role = \"training\"\nfamily = \"circle\"\namplitude_mm = 1.5\nfrequency_hz = 0.4\nphase_deg = 0\n\
         direction = \"counter_clockwise\"\nattack_s = 0.6\nsustain_s = {sustain:?}\ndecay_s = 0.6\n"
    )
}

/// Starts an emulator in a folder, and waits for its first line.
fn spawn(folder: &Path, arguments: &[&str]) -> (Child, String) {
    let mut process = Command::new(program())
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
    (process, line)
}

/// The rig `typical`, calibrated, in `rig/` of a folder with `plan.toml`. Dropping it ends it.
#[derive(Debug)]
pub struct EmulatedRig {
    folder: tempfile::TempDir,
    emulator: Child,
    /// When its clock began, to the time that a process takes to report it.
    pub started: Instant,
}

impl EmulatedRig {
    /// Starts one with this list of faults (the text of a file without its head), and a circle of that length [s].
    pub fn start(faults: &str, sustain: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let head = "format = \"hysteron-faults\"\nversion = 1\n";
        std::fs::write(folder.path().join("faults.toml"), format!("{head}{faults}")).unwrap();
        std::fs::write(folder.path().join("plan.toml"), plan(sustain)).unwrap();
        // Somebody else may take a free port before it is used.
        let emulator = (0..5).find_map(|_| Self::emulate(folder.path())).unwrap();
        let started = Instant::now();
        std::fs::write(folder.path().join("rig/calibration.toml"), calibration()).unwrap();
        Self { folder, emulator, started }
    }

    fn emulate(folder: &Path) -> Option<Child> {
        let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port().to_string();
        let arguments =
            ["rig", "emulate", "--dir", "rig", "--relaxed", "--return-delay-us", "0", "--seed", SEED];
        let more = ["--faults", "faults.toml", "--port-tracker", &free];
        let (mut emulator, line) = spawn(folder, &[&arguments[..], &more[..]].concat());
        if line.starts_with("servos 1 to 4") {
            return Some(emulator);
        }
        emulator.wait().unwrap();
        None
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// A file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    /// Replaces text that the rig file must have.
    pub fn replace(&self, from: &str, to: &str) {
        let text = std::fs::read_to_string(self.file("rig/rig.toml")).unwrap();
        assert!(text.contains(from), "{from}");
        std::fs::write(self.file("rig/rig.toml"), text.replace(from, to)).unwrap();
    }

    /// `hysteron record` of the circle to this file, ready to start.
    pub fn record(&self, out: &str) -> Command {
        self.command(&["record", "--rig", "rig/rig.toml", "--plan", "plan.toml", "--out", out])
    }

    /// `hysteron rig calibrate` to this file, ready to start.
    pub fn calibrate(&self, out: &str) -> Command {
        self.command(&["rig", "calibrate", "--rig", "rig/rig.toml", "--out", out])
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(program());
        command
            .args(arguments)
            .current_dir(self.path())
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// Lines of the log of torques: when [s], and whether any servo was under torque.
    pub fn torques(&self) -> Vec<(f64, bool)> {
        let text = std::fs::read_to_string(self.file("rig/torque.jsonl")).unwrap();
        // A line that is being written has no end yet.
        let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
        let time = |line: &str| line.strip_prefix("{\"time_s\":")?.split(',').next()?.parse().ok();
        whole.lines().map(|line| (time(line).unwrap(), line.contains("true"))).collect()
    }

    /// Waits until servos are under torque or not; returns how long that took.
    pub fn wait_for_torque(&self, on: bool) -> Duration {
        let start = Instant::now();
        while self.torques().last().is_none_or(|last| last.1 != on) {
            assert!(start.elapsed() < Duration::from_secs(20), "torque never {on}: {:?}", self.torques());
            std::thread::sleep(Duration::from_millis(5));
        }
        start.elapsed()
    }
}

impl Drop for EmulatedRig {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.emulator.kill();
        let _ = self.emulator.wait();
    }
}

/// Sends a signal by name.
pub fn signal(process: &Child, name: &str) {
    let sent = Command::new("kill").args([&format!("-{name}"), &process.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Longest wait for what a busy machine does in its time.
const PATIENCE: Duration = Duration::from_secs(30);

/// Both emulated arms in `arms/` of a folder. Dropping it ends them.
#[derive(Debug)]
pub struct EmulatedArms {
    folder: tempfile::TempDir,
    process: Child,
}

impl EmulatedArms {
    /// Starts them; `arguments` are further ones of `hysteron arm emulate`.
    pub fn start(arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let emulate = ["arm", "emulate", "--dir", "arms", "--relaxed", "--begins-s", "3"];
        let (process, line) = spawn(folder.path(), &[&emulate[..], arguments].concat());
        assert!(line.starts_with("leader at"), "{line}");
        let arms = Self { folder, process };
        // A busy machine answers late and pauses at times, which is not tested here.
        let file = arms.path().join("arms/patient.toml");
        let text = std::fs::read_to_string(arms.path().join("arms/arms.toml")).unwrap();
        let text = text
            .replace("reply_timeout_ms = 4.0", "reply_timeout_ms = 100.0")
            .replace("bus_watchdog_ms = 200.0", "bus_watchdog_ms = 2540.0")
            .replace("approach_deg_s = 30.0", "approach_deg_s = 90.0");
        std::fs::write(file, text).unwrap();
        arms
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Starts a command that works on the arms and writes to `out`; comes back when it has written rows, under torque.
    pub fn at_work(&self, arguments: &[&str], out: &str) -> Child {
        let mut command = crate::command(self.path(), &[arguments, &["--out", out]].concat());
        let process = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let journal = self.path().join(out).with_extension("journal");
        wait_until("rows", || std::fs::metadata(&journal).is_ok_and(|file| file.len() > 20_000));
        assert!(self.is_under_torque());
        process
    }

    /// Whether any servo of the follower was under torque last.
    pub fn is_under_torque(&self) -> bool {
        let text = std::fs::read_to_string(self.path().join("arms/torque.jsonl")).unwrap();
        let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
        whole.lines().last().is_some_and(|line| line.contains("true"))
    }
}

impl Drop for EmulatedArms {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Waits until something is so.
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < PATIENCE, "never {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
