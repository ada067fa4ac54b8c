//! Emulates the servos of both arms on two ports, in real time.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hysteron_base::{BadInput, Lock, file};
use hysteron_rig::teleoperation::ARMS_FILE;
use hysteron_virtual_rig::emulator::{Faults, Options as EmulatorOptions, ServoEmulator, TORQUE_LOG, Timing};
use hysteron_virtual_rig::virtual_arm::{JointFault, N_SERVOS, data_set, fault_set};

use super::outcome::PortCounts;
use super::{Options, Outcome};
use crate::arm::virtual_arm::read_arm;
use crate::rig::emulate::PATIENT;
use crate::{Context, WorkflowError};

/// Longest run, and longest wait of the hand: a year [s].
const LONGEST: f64 = 31_536_000.0;
/// Ids of the first servo of the leader and of the follower.
const FIRST_IDS: [u8; 2] = [1, 11];
/// Name of the file of both arms in the folder.
const ARMS: &str = "arms.toml";

/// Runs the verb.
///
/// # Errors
/// Bad input; ports that cannot be opened; emulated servos that stop by themselves.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(emulate(options, context)?)
}

fn emulate(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let end = options.for_s.map(|seconds| duration("--for-s", seconds)).transpose()?;
    let begins = duration("--begins-s", options.begins_s)?.as_secs_f64();
    let (general, _) = read_arm(&options.arm)?;
    let mut planned = data_set().into_iter().chain(fault_set());
    let planned = planned.find(|one| one.name() == options.trajectory).ok_or_else(|| {
        let found = format!("\"{}\"", options.trajectory);
        BadInput::new("--trajectory", "SUBSET/TASK/SPLIT/NUMBER of NAD or of motor_faults", found).hint(
            "as in weight/pick_place_object_200g/test/001; `hysteron arm generate --out DIR` makes NAD's, with --subsets motor_faults the others",
        )
    })?;
    let arm = general.individual(options.seed);
    let (leader, follower) = arm.arms(&planned.trial, options.seed, &options.trajectory, begins);
    let over = leader.end();
    let fault = follower.fault().map(JointFault::describe);
    let [leads, follows] = emulator_options(options)?;
    // The links, the file and the log in it are those of one emulator.
    let _folder = Lock::folder(&options.dir)?;
    let path = arms_file(&options.dir)?;
    context.listen();
    let leader = ServoEmulator::start(leader, leads)?;
    let follower = ServoEmulator::start(follower, follows)?;
    file::write_bytes(&path, patient_arms_file())?;
    for (name, emulator) in [("leader", leader.servo_port()), ("follower", follower.servo_port())] {
        context.print(format_args!("{name} at {}, 1000000 baud", emulator.display()));
    }
    if let Some(fault) = fault {
        context.print(format_args!("the follower has {fault}"));
    }
    context.print(format_args!(
        "the hand moves from {begins:.0} to {over:.0} s; log: {}/{TORQUE_LOG}",
        options.dir.display()
    ));
    let out = options.dir.join("motion.parquet");
    context.print(format_args!(
        "try: hysteron arm record --arms {} --out {} --seconds 10",
        path.display(),
        out.display()
    ));
    let start = Instant::now();
    while !context.is_cancelled() && end.is_none_or(|end| start.elapsed() < end) {
        anyhow::ensure!(
            leader.is_running() && follower.is_running(),
            "the emulated servos stopped by themselves"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
    let [leader, follower] = [leader.counts(), follower.counts()];
    context.print(format_args!(
        "leader: {} instructions, {} answers; follower: {} and {}",
        leader.instructions, leader.answers, follower.instructions, follower.answers
    ));
    Ok(Outcome { leader: PortCounts::new(&leader), follower: PortCounts::new(&follower) })
}

/// Of the leader and of the follower.
fn emulator_options(options: &Options) -> anyhow::Result<[EmulatorOptions; 2]> {
    let mut faults = Faults::default();
    if let Some(path) = &options.faults {
        faults = Faults::read(path)?;
        let last = FIRST_IDS[1] + N_SERVOS as u8 - 1;
        faults.check_servos(&(FIRST_IDS[1]..=last)).map_err(|bad| bad.within(path.display()))?;
    }
    let both = ["leader", "follower"].map(|name| EmulatorOptions {
        timing: if options.relaxed { Timing::Relaxed } else { Timing::Wire },
        // As both arms are set by the programs that lead them.
        return_delay: 0.0,
        seed: options.seed,
        ..EmulatorOptions::new(options.dir.join(name))
    });
    let [leads, follows] = both;
    Ok([
        EmulatorOptions { first_id: FIRST_IDS[0], ..leads },
        EmulatorOptions { first_id: FIRST_IDS[1], faults, logs: Some(options.dir.clone()), ..follows },
    ])
}

/// The file of both arms, with an emulator's waits in place of those of hardware.
fn patient_arms_file() -> String {
    PATIENT.iter().fold(ARMS_FILE.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// Where the file of both arms goes; refuses a folder with another one.
fn arms_file(folder: &Path) -> anyhow::Result<PathBuf> {
    let path = folder.join(ARMS);
    if path.exists() && file::read_text(&path)? != patient_arms_file() {
        return Err(BadInput::new(
            path.display().to_string(),
            "the file of the virtual arms, or none",
            "another",
        )
        .hint("move it away, or choose another --dir")
        .into());
    }
    Ok(path)
}

fn duration(option: &str, seconds: f64) -> Result<Duration, BadInput> {
    let wrong = || BadInput::new(option, format!("0 to {LONGEST} s"), format!("{seconds} s"));
    if seconds > LONGEST {
        return Err(wrong());
    }
    Duration::try_from_secs_f64(seconds).map_err(|_| wrong())
}
