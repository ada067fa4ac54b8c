//! Registers that were changed: each one of the table is noticed before any torque is on, and can be written
//! back; and two servos with one id are distinguished from silence and from damage.

use super::session::Stand;
use hysteron_rig::bus::registers::{RegisterRole, RegisterSpec, StoredRegisters, TABLE};
use hysteron_rig::bus::xl430::{self, ControlRegister, drive};
use hysteron_rig::bus::{RegisterBaseline, TorqueState};
use hysteron_rig::session::RigSession;
use hysteron_rig::{Error, Hardware, LiveRig};
use hysteron_virtual_rig::emulator::{BusFault, FaultKind};

/// The servo whose registers are touched.
const TOUCHED: u8 = 2;

fn open(stand: &Stand) -> LiveRig {
    LiveRig::open(&stand.rig).unwrap()
}

/// Writes a register of the changed servo as another program would.
fn touch(stand: &Stand, register: ControlRegister, value: i64) -> Result<(), Error> {
    open(stand).bus().write(TOUCHED, register, (value as i32).cast_unsigned())
}

fn read(stand: &Stand, register: ControlRegister) -> i64 {
    i64::from(open(stand).bus().read(TOUCHED, register).unwrap().cast_signed())
}

/// Gives a register another value than it has, one that the servo takes; returns it.
fn changed(stand: &Stand, spec: &RegisterSpec) -> i64 {
    let before = read(stand, spec.register);
    // All above 252 mean no secondary id.
    let other_id = (spec.register == xl430::SECONDARY_ID).then_some(7);
    let mut candidates = other_id.into_iter().chain([before + 1, before - 1]);
    let taken = candidates.find(|value| touch(stand, spec.register, *value).is_ok());
    taken.unwrap_or_else(|| panic!("{} takes no other value than {before}", spec.name))
}

fn refusal(rig: &mut LiveRig) -> String {
    rig.prepare().unwrap_err().to_string()
}

#[test]
fn every_register_that_is_stored_is_noticed_when_it_changes_and_is_written_back() {
    let stand = Stand::new();
    let calibration = stand.calibration(&mut open(&stand)).unwrap();
    assert!(calibration.registers.iter().all(|registers| !registers.is_empty()));
    let mut n_checked = 0;
    let is_checked = |spec: &&RegisterSpec| {
        // The firmware cannot be written, and only this protocol is spoken here: both below.
        let is_fixed = [xl430::FIRMWARE, xl430::PROTOCOL].contains(&spec.register);
        matches!(spec.role, RegisterRole::Stored(_))
            && spec.is_of(&hysteron_rig::bus::model::XL430_W250)
            && !is_fixed
    };
    for spec in TABLE.iter().filter(is_checked) {
        let before = read(&stand, spec.register);
        let value = changed(&stand, spec);
        for baseline in [calibration.register_baseline(), RegisterBaseline::Factory] {
            let mut rig = open(&stand).expecting(baseline);
            let why = refusal(&mut rig);
            let named = format!("servo {TOUCHED}: {} (register {})", spec.name, spec.register.address);
            assert!(why.contains(&named) && why.contains(&format!("got {value}")), "{why}");
            assert!(why.contains("--restore"), "{why}");
            assert_eq!(why.matches("(register ").count(), 1, "one difference alone: {why}");
            // Nor can the torque be switched on by a direct call.
            assert!(rig.enable_torque().unwrap_err().to_string().contains("no torque goes on"));
        }
        let mut rig = open(&stand);
        rig.bus().self_check(&stand.rig.servo_bounds()).unwrap();
        let different = rig.bus().register_differences(&calibration.register_baseline()).unwrap();
        rig.bus().restore_registers(&different).unwrap();
        drop(rig);
        let meaning = |value: i64| if spec.register == xl430::SECONDARY_ID { value.max(253) } else { value };
        assert_eq!(meaning(read(&stand, spec.register)), meaning(before), "{}", spec.name);
        open(&stand).expecting(calibration.register_baseline()).prepare().unwrap();
        n_checked += 1;
    }
    assert_eq!(n_checked, 13);
    assert!(stand.emulator.torque_log().iter().all(|record| record.torque_on.iter().all(|on| !on)));
}

#[test]
fn every_register_that_a_run_sets_is_noted_and_holds_that_afterwards() {
    let stand = Stand::new();
    let set = |spec: &&RegisterSpec| matches!(spec.role, RegisterRole::Set(_));
    let mut expected = Vec::new();
    open(&stand).prepare().unwrap();
    for spec in TABLE.iter().filter(set) {
        expected.push(read(&stand, spec.register));
    }
    for (spec, expected) in TABLE.iter().filter(set).zip(&expected) {
        let value = changed(&stand, spec);
        let mut rig = open(&stand);
        rig.bus().self_check(&stand.rig.servo_bounds()).unwrap();
        let notes = rig.bus().settings_to_change();
        let note = format!("servo {TOUCHED}: {} (register {}) is {value}", spec.name, spec.register.address);
        // A servo that would not answer is made to before anything else is read of it.
        let is_noted =
            notes.iter().any(|line| line.starts_with(&note)) || spec.register == xl430::STATUS_RETURN;
        assert!(is_noted, "{note}: {notes:?}");
        rig.prepare().unwrap();
        drop(rig);
        assert_eq!(read(&stand, spec.register), *expected, "{}", spec.name);
    }
}

#[test]
fn an_offset_and_a_reversed_direction_say_what_they_would_do() {
    let stand = Stand::new();
    let calibration = stand.calibration(&mut open(&stand)).unwrap();
    touch(&stand, xl430::HOMING_OFFSET, 200).unwrap();
    let why = refusal(&mut open(&stand).expecting(calibration.register_baseline()));
    // 200 of 4096 ticks: 17.6 degrees.
    assert!(
        why.contains("expected 0, got 200: every position is shifted by 200 ticks, 17.6 degrees"),
        "{why}"
    );
    touch(&stand, xl430::HOMING_OFFSET, 0).unwrap();
    touch(&stand, xl430::DRIVE_MODE, i64::from(drive::REVERSE)).unwrap();
    let why = refusal(&mut open(&stand).expecting(calibration.register_baseline()));
    assert!(why.contains("expected 0, got 1: its direction is turned round"), "{why}");
    // A report of other registers is refused by the calibration, too.
    let mut rig = open(&stand).expecting(RegisterBaseline::AsFound);
    let servos = rig.prepare().unwrap();
    assert!(calibration.check(&stand.rig, &servos).unwrap_err().to_string().contains("Drive Mode"));
}

#[test]
fn registers_changed_on_purpose_are_accounted_for_by_the_calibration_that_found_them() {
    let stand = Stand::new();
    touch(&stand, xl430::HOMING_OFFSET, -300).unwrap();
    assert!(refusal(&mut open(&stand)).contains("Homing Offset"));
    let mut rig = open(&stand).expecting(RegisterBaseline::AsFound);
    let calibration = stand.calibration(&mut rig).unwrap();
    drop(rig);
    open(&stand).expecting(calibration.register_baseline()).prepare().unwrap();
    // Back as from the factory it is another servo to this calibration.
    touch(&stand, xl430::HOMING_OFFSET, 0).unwrap();
    let why = refusal(&mut open(&stand).expecting(calibration.register_baseline()));
    assert!(why.contains("expected -300, got 0"), "{why}");
}

#[test]
fn what_drives_a_motor_unasked_is_never_accounted_for() {
    for (register, value, part) in [
        (xl430::DRIVE_MODE, i64::from(drive::TORQUE_ON_BY_GOAL), "a goal switches its torque on"),
        (xl430::STARTUP, i64::from(xl430::TORQUE_ON_AT_START), "its torque goes on with the supply"),
        (xl430::SECONDARY_ID, 1, "it obeys instructions to another servo"),
    ] {
        let stand = Stand::new();
        touch(&stand, register, value).unwrap();
        let why = refusal(&mut open(&stand).expecting(RegisterBaseline::AsFound));
        assert!(why.contains(part), "{why}");
        assert!(!stand.emulator.torque_on().contains(&true));
    }
}

#[test]
fn another_firmware_than_the_calibration_s_is_a_difference_that_cannot_be_written_back() {
    let stand = Stand::new();
    let mut calibration = stand.calibration(&mut open(&stand)).unwrap();
    let mut keys = calibration.registers[1].to_keys();
    keys.insert("firmware_version".into(), 44);
    calibration.registers[1] = StoredRegisters::from_keys("registers", &keys).unwrap();
    let why = refusal(&mut open(&stand).expecting(calibration.register_baseline()));
    assert!(why.contains("servo 2: Firmware Version (register 6): expected 44, got 45"), "{why}");
    let mut rig = open(&stand);
    rig.bus().self_check(&stand.rig.servo_bounds()).unwrap();
    let different = rig.bus().register_differences(&calibration.register_baseline()).unwrap();
    let why = rig.bus().restore_registers(&different).unwrap_err().to_string();
    assert!(why.contains("cannot be written: calibrate again"), "{why}");
}

#[test]
fn a_session_without_a_look_at_the_registers_gets_no_torque() {
    let stand = Stand::new();
    let calibration = stand.calibration(&mut open(&stand)).unwrap();
    let mut rig = open(&stand);
    let why = RigSession::start(&mut rig, &stand.rig, &calibration, 100.0).unwrap_err().to_string();
    assert!(why.contains("have not been read and compared"), "{why}");
    assert!(!stand.emulator.torque_on().contains(&true));
}

#[test]
fn two_servos_with_one_id_are_distinguished_from_silence_and_damage() {
    let check =
        |stand: &Stand| open(stand).bus().self_check(&stand.rig.servo_bounds()).unwrap_err().to_string();
    // Both answer at once.
    let stand = Stand::new();
    touch(&stand, xl430::ID, 1).unwrap();
    let why = check(&stand);
    assert!(
        why.contains("servo 1: two servos seem to have this id") && why.contains("no servo 2 answers"),
        "{why}"
    );
    // One after the other.
    let stand = Stand::new();
    touch(&stand, xl430::RETURN_DELAY, 254).unwrap();
    touch(&stand, xl430::ID, 1).unwrap();
    let why = check(&stand);
    assert!(why.contains("servo 1: two servos") && why.contains("give each a unique id"), "{why}");
    // One without power.
    let stand = Stand::new();
    stand.emulator.inject(BusFault::new(0.0, FaultKind::UnplugServo).of_servo(TOUCHED)).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(50));
    let mut impatient = stand.rig.clone();
    impatient.servos.reply_timeout = 0.1;
    let mut rig = LiveRig::open(&impatient).unwrap();
    let why = rig.bus().self_check(&stand.rig.servo_bounds()).unwrap_err().to_string();
    assert!(why.contains("servo 2: expected an XL430-W250 to answer, got silence"), "{why}");
    assert!(!why.contains("two servos"), "{why}");
    // One with a hardware error.
    let stand = Stand::new();
    stand.emulator.inject(BusFault::new(0.0, FaultKind::Overload).of_servo(TOUCHED)).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(50));
    let why = check(&stand);
    assert!(
        why.contains("servo 2: expected no hardware error, got overload") && !why.contains("two servos"),
        "{why}"
    );
    // A cable that damages the answers of all.
    let stand = Stand::new();
    stand.emulator.inject(BusFault::new(0.0, FaultKind::CorruptPacket).times(10_000)).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(50));
    let why = check(&stand);
    assert!(why.contains("as those of all servos") && !why.contains("two servos"), "{why}");
}

#[test]
fn a_silent_servo_is_named_with_its_state_and_so_are_those_that_are_off() {
    let stand = Stand::new();
    let mut quick = stand.rig.clone();
    quick.servos.reply_timeout = 0.05;
    open(&stand).prepare().unwrap();
    stand.emulator.inject(BusFault::new(0.0, FaultKind::UnplugServo).of_servo(TOUCHED)).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(50));
    let error = LiveRig::open(&quick).unwrap().disable_torque().unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("servo 2 is silent (off, on or without power); servos 1, 3, 4 are off"),
        "{message}"
    );
    let Error::Torque(states) = error else { panic!("{message}") };
    let silent: Vec<u8> =
        states.iter().filter(|one| one.state == TorqueState::Silent).map(|one| one.servo).collect();
    assert_eq!(silent, [TOUCHED]);
}

#[test]
fn the_guide_has_every_register_of_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/rig.md");
    let guide = std::fs::read_to_string(path).unwrap();
    for spec in &TABLE {
        let (name, address) = (spec.name, spec.register.address);
        let is_measured = matches!(spec.role, RegisterRole::Measured | RegisterRole::WithoutEffect);
        let row = if is_measured { format!("{name} ({address})") } else { format!("| {name} | {address} |") };
        assert!(guide.contains(&row), "docs/rig.md has no {row:?}");
        assert!(is_measured || guide.contains(&format!("| {} |\n", spec.effect)), "{}", spec.effect);
    }
}
