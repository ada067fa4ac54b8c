//! The emulation: virtual robot and faults, ports, until it ends.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use hysteron_base::{BadInput, Lock};
use hysteron_virtual_rig::emulator::{
    DeviceClock, FAULTS_LOG, Faults, Format, Options as EmulatorOptions, PoseDelivery, PoseServerSettings,
    ServoEmulator, TORQUE_LOG, Timing, TrafficCounts,
};
use hysteron_virtual_rig::virtual_rig::{VirtualRobot, World};

use super::options::Options;
use super::outcome::Outcome;
use super::rig_file;
use crate::{Context, WorkflowError};

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

/// Runs the verb.
///
/// # Errors
/// Bad input; ports that cannot be opened; emulated servos that stop by themselves.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(emulate(options, context)?)
}

fn emulate(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let end = options.for_s.map(duration).transpose()?;
    let robot = robot(options)?;
    let world = World::new(&robot, options.seed);
    let setting = emulator_options(options, &world)?;
    let n_faults = setting.faults.list.len();
    // The link, the rig file and the logs in it are those of one emulator.
    let _folder = Lock::folder(&options.dir)?;
    rig_file::check(&options.dir, &robot)?;
    context.listen();
    let n_servos = world.n_servos();
    let emulator = ServoEmulator::start(world, setting)?;
    let (_poses, tracker) = serve_poses(options, &emulator)?;
    let rig_file = rig_file::write(options, &robot, tracker)?;

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
fn serve_poses(options: &Options, emulator: &ServoEmulator) -> anyhow::Result<(PoseDelivery, SocketAddr)> {
    let clock = DeviceClock { offset: TRACKER_OFFSET, drift: TRACKER_DRIFT };
    let (port, device) = (options.port_tracker, TRACKER_DEVICE.to_owned());
    Ok(emulator.serve_poses(PoseServerSettings { port, device, clock, format: Format::Transform })?)
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

fn print_counts(counts: &TrafficCounts, context: &Context) {
    context.print(format_args!(
        "{} instructions, {} damaged packets, {} answers; {} of {} rounds of reading complete",
        counts.instructions,
        counts.bad_packets,
        counts.answers,
        counts.complete_rounds,
        counts.complete_rounds + counts.broken_rounds,
    ));
    if counts.slipped_ms > 0 {
        context.print(format_args!("this machine was too slow: {} ms were skipped", counts.slipped_ms));
    }
}
