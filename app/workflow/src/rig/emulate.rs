//! `hysteron rig emulate`: the virtual rig on ports, for any program that speaks to the real one.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hysteron_base::{BadInput, Lock, file};
use hysteron_rig::emulator::{
    Counts, DeviceClock, Emulator, FAULTS_LOG, Faults, Format, Options as EmulatorOptions, PoseDelivery,
    PoseServerSettings, TORQUE_LOG, Timing,
};
use hysteron_rig::virtual_rig::{VirtualRobot, World, rig_file};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;

/// Emulate servos and tracker of a rig on their ports
///
/// Needs nothing; makes a serial port and a TCP port that behave like the real servos and the real tracker, in real
/// time, and writes the rig file to go with them.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// How much friction, play and noise the virtual rig has
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = Preset::Typical, conflicts_with = "robot"))]
    pub preset: Preset,
    /// Virtual robot to emulate, instead of a preset
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub robot: Option<PathBuf>,
    /// Seed of noise and of drawn faults
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
    /// Folder for the port, the rig file and the logs
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR", default_value = "out/rig"))]
    pub dir: PathBuf,
    /// Baud of the servos
    #[cfg_attr(feature = "clap", arg(long, value_name = "BAUD", default_value_t = 1_000_000))]
    pub baud: u32,
    /// Time that a servo waits before it answers
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "US", default_value_t = 500.0, allow_negative_numbers = true)
    )]
    pub return_delay_us: f64,
    /// Faults to inject (.toml)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub faults: Option<PathBuf>,
    /// Draw that many faults, spread over the time of --for-s
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0, requires = "for_s"))]
    pub draw_faults: u32,
    /// Sleep through every wait: answers come some 0.1 ms late, and the processor is free for others
    #[cfg_attr(feature = "clap", arg(long))]
    pub relaxed: bool,
    /// TCP port on which the tracker serves its poses, by OpenIGTLink; 0 for any that is free
    #[cfg_attr(feature = "clap", arg(long, value_name = "PORT", default_value_t = 18944))]
    pub port_tracker: u16,
    /// End after that many seconds [default: at Ctrl-C]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SECONDS", allow_negative_numbers = true))]
    pub for_s: Option<f64>,
}

/// How far the virtual rig is from an ideal one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Preset {
    /// Little of each
    Mild,
    /// As the rigs that the presets were made after
    Typical,
    /// More than most
    Harsh,
    /// A robot drawn from the wide population
    Wide,
}

impl Preset {
    fn name(self) -> &'static str {
        match self {
            Self::Mild => "mild",
            Self::Typical => "typical",
            Self::Harsh => "harsh",
            Self::Wide => "wide",
        }
    }
}

/// Longest run: a year [s].
const LONGEST: f64 = 31_536_000.0;
/// Most faults that are drawn.
const MAX_FAULTS: u32 = 100_000;
/// Name of the tip in the tracker; as in the rig file.
const TRACKER_DEVICE: &str = "Tip";
/// Its clock started before this program [s].
const TRACKER_OFFSET: f64 = 1000.0;
/// And is a little fast [-].
const TRACKER_DRIFT: f64 = 20e-6;

/// The outcome of `rig emulate`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome(pub Counts);

impl crate::shared::outcome::Outcome for Outcome {}

/// Carries out the verb.
///
/// # Errors
/// Bad input; ports that cannot be opened; emulated servos that stop by themselves.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let end = options.for_s.map(duration).transpose()?;
    let robot = robot(options)?;
    let world = World::new(&robot, options.seed);
    let setting = emulator_options(options, &world)?;
    let n_faults = setting.faults.list.len();
    // The link, the rig file and the logs in it are those of one emulator.
    let _folder = Lock::folder(&options.dir)?;
    check_rig_file(&options.dir, &robot)?;
    context.listen();
    let n_servos = world.n_servos();
    let emulator = Emulator::start(world, setting)?;
    let (_poses, tracker) = serve_poses(options, &emulator)?;
    let rig_file = write_rig_file(options, &robot, tracker)?;

    context.print(format_args!(
        "servos 1 to {n_servos} at {}, {} baud",
        emulator.servo_port().display(),
        options.baud
    ));
    context.print(format_args!("tracker \"{TRACKER_DEVICE}\" at {tracker}, OpenIGTLink"));
    context.print(format_args!("try: hysteron rig calibrate --rig {}", rig_file.display()));
    context.print(format_args!(
        "faults to come: {n_faults}; logs: {0}/{FAULTS_LOG}, {0}/{TORQUE_LOG}",
        options.dir.display()
    ));
    let start = Instant::now();
    while !context.is_cancelled() && end.is_none_or(|end| start.elapsed() < end) {
        anyhow::ensure!(emulator.is_running(), "the emulated servos stopped by themselves");
        std::thread::sleep(Duration::from_millis(20));
    }
    let counts = emulator.counts();
    print_counts(&counts, context);
    Ok(Outcome(counts))
}

/// The virtual robot of a preset or of a file.
fn robot(options: &Options) -> anyhow::Result<VirtualRobot> {
    Ok(match &options.robot {
        Some(path) => VirtualRobot::read(path)?,
        None => VirtualRobot::preset(options.preset.name())?,
    })
}

/// Puts the tracker of the virtual rig on its port.
fn serve_poses(options: &Options, emulator: &Emulator) -> anyhow::Result<(PoseDelivery, SocketAddr)> {
    let clock = DeviceClock { offset: TRACKER_OFFSET, drift: TRACKER_DRIFT };
    let (port, device) = (options.port_tracker, TRACKER_DEVICE.to_owned());
    Ok(emulator.serve_poses(PoseServerSettings { port, device, clock, format: Format::Transform })?)
}

/// Name of the rig file in the folder of an emulator.
const RIG_FILE: &str = "rig.toml";
/// Timing lines of the preset's rig file for hardware, each with its replacement for an emulator: it shares a
/// computer with its clients, and a delay of that computer is no fault of the servos.
pub(crate) const PATIENT: [(&str, &str); 3] = [
    ("reply_timeout_ms = 4.0", "reply_timeout_ms = 100.0"),
    ("bus_watchdog_ms = 200.0", "bus_watchdog_ms = 2540.0"),
    ("stale_ms = 300.0", "stale_ms = 2000.0"),
];
/// Keys that differ between runs of one emulator.
const OF_A_RUN: [&str; 2] = ["address = ", "baud = "];

/// Refuses a folder whose rig file is not one that this emulator would write: it is somebody else's.
fn check_rig_file(folder: &Path, robot: &VirtualRobot) -> anyhow::Result<()> {
    let path = folder.join(RIG_FILE);
    if !path.exists() {
        return Ok(());
    }
    let (found, own) = (file::read_text(&path)?, patient_rig_file(robot));
    let lasting = |text: &str| -> Vec<String> {
        let is_lasting = |line: &&str| !OF_A_RUN.iter().any(|key| line.starts_with(key));
        text.lines().filter(is_lasting).map(str::to_owned).collect()
    };
    if lasting(&found) == lasting(&own) {
        return Ok(());
    }
    Err(BadInput::new(path.display().to_string(), "the rig file of this virtual robot, or none", "another")
        .hint("move it away, or choose another --dir")
        .into())
}

/// The rig file of a virtual robot on ports.
fn patient_rig_file(robot: &VirtualRobot) -> String {
    PATIENT.iter().fold(rig_file(robot), |text, (from, to)| text.replace(from, to))
}

/// The rig file with which this program finds what is emulated.
fn write_rig_file(options: &Options, robot: &VirtualRobot, tracker: SocketAddr) -> anyhow::Result<PathBuf> {
    let text = patient_rig_file(robot)
        .replace("127.0.0.1:18944", &tracker.to_string())
        .replace("baud = 1000000", &format!("baud = {}", options.baud));
    let path = options.dir.join(RIG_FILE);
    file::write_bytes(&path, text)?;
    Ok(path)
}

fn emulator_options(options: &Options, world: &World) -> anyhow::Result<EmulatorOptions> {
    let mut faults = match &options.faults {
        Some(path) => Faults::read(path)?,
        None => Faults::default(),
    };
    let n_servos = u8::try_from(world.n_servos()).unwrap_or(u8::MAX);
    if let Some(path) = &options.faults {
        faults.check_servos(&(1..=n_servos)).map_err(|bad| bad.within(path.display()))?;
    }
    if options.draw_faults > MAX_FAULTS {
        let expected = format!("at most {MAX_FAULTS}");
        return Err(BadInput::new("--draw-faults", expected, options.draw_faults.to_string()).into());
    }
    if let Some(span) = options.for_s {
        faults.add(Faults::draw(options.seed, options.draw_faults as usize, span, n_servos));
    }
    Ok(EmulatorOptions {
        baud: options.baud,
        return_delay: 1e-6 * options.return_delay_us,
        timing: if options.relaxed { Timing::Relaxed } else { Timing::Wire },
        faults,
        seed: options.seed,
        logs: Some(options.dir.clone()),
        ..EmulatorOptions::new(options.dir.join("servos"))
    })
}

fn duration(seconds: f64) -> Result<Duration, BadInput> {
    let wrong = || BadInput::new("--for-s", format!("0 to {LONGEST} s"), format!("{seconds} s"));
    if seconds > LONGEST {
        return Err(wrong());
    }
    Duration::try_from_secs_f64(seconds).map_err(|_| wrong())
}

fn print_counts(counts: &Counts, context: &Context) {
    context.print(format_args!(
        "{} instructions, {} damaged packets, {} answers; {} of {} rounds of reading complete",
        counts.instructions,
        counts.bad_packets,
        counts.answers,
        counts.complete_rounds,
        counts.complete_rounds + counts.broken_rounds,
    ));
    if counts.slipped_ms > 0 {
        context.print(format_args!("this machine was too slow: {} ms were left out", counts.slipped_ms));
    }
}
