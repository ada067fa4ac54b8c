//! `hysteron rig emulate`: the virtual rig on ports, for any program that speaks to the real one.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hysteron_base::{BadInput, Lock, file};
use hysteron_rig::virtual_rig::emulator::{
    Counts, DeviceClock, Emulator, FAULTS_LOG, Faults, Format, Options, PoseDelivery, PoseServerSettings,
    TORQUE_LOG, Timing,
};
use hysteron_rig::virtual_rig::{VirtualRobot, World, rig_file};

use crate::interrupt;
use crate::terminal::say;

const HELP: &str = "\
Four Dynamixel XL430-W250 with the ids 1 to 4 appear on a pseudo-terminal; DIR/servos is a link to it, and stays the \
name when a fault unplugs the bus and plugs it in again. They speak protocol 2.0 at the speed of the wire: any driver \
can be tried on them, the Dynamixel SDK and Wizard included. Switch a servo's torque on before it moves; the EEPROM \
is as from the factory except for id and baud. The tracker \"Tip\" serves its poses by OpenIGTLink.

Faults come from a file, a draw, or both:
  format = \"hysteron-faults\"
  version = 1

  [[fault]]
  at_s = 1.5
  kind = \"drop_packet\"
  servo = 2
  count = 3

Kinds: drop_packet, corrupt_packet, drop_instruction (count, servo), delay_packet (delay_ms, count, servo), noise \
(count), unplug_bus (duration_s), unplug_servo, overheat (servo, duration_s), overload (servo), hold (servo, \
torque_nm, duration_s), brown_out (volts or servo, duration_s), unplug_tracker, tracker_dropout, tracker_invalid, \
tracker_freeze, tracker_jump, tracker_corrupt (duration_s).

Writes DIR/rig.toml, for --rig of the other verbs; DIR/faults.jsonl, what broke when; and DIR/torque.jsonl, which \
servos drove their motors when, one line per change. A folder in which another emulator runs is refused. Runs until Ctrl-C or --for-s; then the link is removed and the traffic is summed up.

Examples, from the root of the repository:
  hysteron rig emulate --dir out/rig --for-s 1
  hysteron rig emulate --dir out/rig --preset harsh --draw-faults 5 --for-s 2

Exit codes: 0 ended as asked, 1 failed, 2 bad input (nothing was started).";

/// Emulate servos and tracker of a rig on their ports
///
/// Needs nothing; makes a serial port and a TCP port that behave like the real servos and the real tracker, in real
/// time, and writes the rig file to go with them.
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// How much friction, play and noise the virtual rig has
    #[arg(long, value_enum, default_value_t = Preset::Typical, conflicts_with = "robot")]
    preset: Preset,
    /// Virtual robot to emulate, instead of a preset
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Seed of noise and of drawn faults
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Folder for the port, the rig file and the logs
    #[arg(long, value_name = "DIR", default_value = "out/rig")]
    dir: PathBuf,
    /// Baud of the servos
    #[arg(long, value_name = "BAUD", default_value_t = 1_000_000)]
    baud: u32,
    /// Time that a servo waits before it answers
    #[arg(long, value_name = "US", default_value_t = 500.0, allow_negative_numbers = true)]
    return_delay_us: f64,
    /// Faults to inject (.toml)
    #[arg(long, value_name = "FILE")]
    faults: Option<PathBuf>,
    /// Draw that many faults, spread over the time of --for-s
    #[arg(long, value_name = "N", default_value_t = 0, requires = "for_s")]
    draw_faults: u32,
    /// Sleep through every wait: answers come some 0.1 ms late, and the processor is free for others
    #[arg(long)]
    relaxed: bool,
    /// TCP port on which the tracker serves its poses, by OpenIGTLink; 0 for any that is free
    #[arg(long, value_name = "PORT", default_value_t = 18944)]
    port_tracker: u16,
    /// End after that many seconds [default: at Ctrl-C]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    for_s: Option<f64>,
}

/// How far the virtual rig is from an ideal one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Preset {
    Mild,
    Typical,
    Harsh,
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
const MOST_FAULTS: u32 = 100_000;
/// What the tracker calls the tip; as in the rig file.
const TRACKER_DEVICE: &str = "Tip";
/// Its clock started before this program [s].
const TRACKER_OFFSET: f64 = 1000.0;
/// And is a little fast [-].
const TRACKER_DRIFT: f64 = 20e-6;

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let end = arguments.for_s.map(duration).transpose()?;
    let robot = robot(arguments)?;
    let world = World::new(&robot, arguments.seed);
    let options = options(arguments, &world)?;
    let n_faults = options.faults.list.len();
    // The link, the rig file and the logs in it are those of one emulator.
    let _folder = Lock::folder(&arguments.dir)?;
    check_rig_file(&arguments.dir, &robot)?;
    interrupt::listen()?;
    let n_servos = world.n_servos();
    let emulator = Emulator::start(world, options)?;
    let (_poses, tracker) = serve_poses(arguments, &emulator)?;
    let rig_file = write_rig_file(arguments, &robot, tracker)?;

    say(format_args!(
        "servos 1 to {n_servos} at {}, {} baud",
        emulator.servo_port().display(),
        arguments.baud
    ));
    say(format_args!("tracker \"{TRACKER_DEVICE}\" at {tracker}, OpenIGTLink"));
    say(format_args!("try: hysteron rig calibrate --rig {}", rig_file.display()));
    say(format_args!(
        "faults to come: {n_faults}; logs: {0}/{FAULTS_LOG}, {0}/{TORQUE_LOG}",
        arguments.dir.display()
    ));
    let start = Instant::now();
    while !interrupt::is_asked() && end.is_none_or(|end| start.elapsed() < end) {
        anyhow::ensure!(emulator.is_running(), "the emulated servos stopped by themselves");
        std::thread::sleep(Duration::from_millis(20));
    }
    print_counts(&emulator.counts());
    Ok(())
}

/// The virtual robot of a preset or of a file.
fn robot(arguments: &Arguments) -> anyhow::Result<VirtualRobot> {
    Ok(match &arguments.robot {
        Some(path) => VirtualRobot::read(path)?,
        None => VirtualRobot::preset(arguments.preset.name())?,
    })
}

/// Puts the tracker of the virtual rig on its port.
fn serve_poses(arguments: &Arguments, emulator: &Emulator) -> anyhow::Result<(PoseDelivery, SocketAddr)> {
    let clock = DeviceClock { offset: TRACKER_OFFSET, drift: TRACKER_DRIFT };
    let (port, device) = (arguments.port_tracker, TRACKER_DEVICE.to_owned());
    Ok(emulator.serve_poses(PoseServerSettings { port, device, clock, format: Format::Transform })?)
}

/// Name of the rig file in the folder of an emulator.
const RIG_FILE: &str = "rig.toml";
/// What differs between runs of one emulator.
const OF_A_RUN: [&str; 2] = ["address = ", "baud = "];

/// Refuses a folder whose rig file is not one that this emulator would write: it is somebody else's.
fn check_rig_file(folder: &Path, robot: &VirtualRobot) -> anyhow::Result<()> {
    let path = folder.join(RIG_FILE);
    if !path.exists() {
        return Ok(());
    }
    let (found, own) = (file::read_text(&path)?, rig_file(robot));
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

/// The rig file with which this program finds what is emulated.
fn write_rig_file(
    arguments: &Arguments,
    robot: &VirtualRobot,
    tracker: SocketAddr,
) -> anyhow::Result<PathBuf> {
    let text = rig_file(robot)
        .replace("127.0.0.1:18944", &tracker.to_string())
        .replace("baud = 1000000", &format!("baud = {}", arguments.baud));
    let path = arguments.dir.join(RIG_FILE);
    file::write_bytes(&path, text)?;
    Ok(path)
}

fn options(arguments: &Arguments, world: &World) -> anyhow::Result<Options> {
    let mut faults = match &arguments.faults {
        Some(path) => Faults::read(path)?,
        None => Faults::default(),
    };
    let n_servos = u8::try_from(world.n_servos()).unwrap_or(u8::MAX);
    if let Some(path) = &arguments.faults {
        faults.check_servos(n_servos).map_err(|bad| bad.within(path.display()))?;
    }
    if arguments.draw_faults > MOST_FAULTS {
        let expected = format!("at most {MOST_FAULTS}");
        return Err(BadInput::new("--draw-faults", expected, arguments.draw_faults.to_string()).into());
    }
    if let Some(span) = arguments.for_s {
        faults.add(Faults::draw(arguments.seed, arguments.draw_faults as usize, span, n_servos));
    }
    Ok(Options {
        baud: arguments.baud,
        return_delay: 1e-6 * arguments.return_delay_us,
        timing: if arguments.relaxed { Timing::Relaxed } else { Timing::Wire },
        faults,
        seed: arguments.seed,
        logs: Some(arguments.dir.clone()),
        ..Options::new(arguments.dir.join("servos"))
    })
}

fn duration(seconds: f64) -> Result<Duration, BadInput> {
    let wrong = || BadInput::new("--for-s", format!("0 to {LONGEST} s"), format!("{seconds} s"));
    if seconds > LONGEST {
        return Err(wrong());
    }
    Duration::try_from_secs_f64(seconds).map_err(|_| wrong())
}

fn print_counts(counts: &Counts) {
    say(format_args!(
        "{} instructions, {} damaged packets, {} answers; {} of {} rounds of reading complete",
        counts.instructions,
        counts.bad_packets,
        counts.answers,
        counts.complete_rounds,
        counts.complete_rounds + counts.broken_rounds,
    ));
    if counts.slipped_ms > 0 {
        say(format_args!("this machine was too slow: {} ms were left out", counts.slipped_ms));
    }
}
