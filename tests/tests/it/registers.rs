//! Registers that were changed after the calibration: no verb switches torque on, and `rig check --restore` is the
//! way out.

#![cfg(unix)]

use std::path::Path;

use hysteron_rig::LiveRig;
use hysteron_rig::bus::xl430::{self, ControlRegister};
use hysteron_rig::config::RigConfig;
use hysteron_rig::teleoperation::{ArmPair, ArmsConfig};
use hysteron_tests::emulated::{EmulatedArms, EmulatedRig};
use hysteron_tests::{root, run};

/// Writes a register of a servo, as Dynamixel Wizard would.
fn touch(rig: &Path, servo: u8, register: ControlRegister, value: u32) {
    let config = RigConfig::read(rig).unwrap();
    LiveRig::open(&config).unwrap().bus().write(servo, register, value).unwrap();
}

#[test]
fn no_verb_moves_a_rig_whose_registers_were_touched_and_restore_is_the_way_out() {
    let rig = EmulatedRig::start("", 0.5);
    let file = rig.file("rig/rig.toml");
    let scene = root().join("meshes/tpu80/scene.toml").display().to_string();
    let verbs: [&[&str]; 4] = [
        &["record", "--rig", "rig/rig.toml", "--plan", "plan.toml", "--out", "out.parquet"],
        &[
            "track",
            "--nominal",
            "--scene",
            &scene,
            "--target",
            "circle:20",
            "--rig",
            "rig/rig.toml",
            "--out",
            "tracked",
        ],
        &["rig", "calibrate", "--rig", "rig/rig.toml"],
        &["rig", "check", "--rig", "rig/rig.toml"],
    ];
    for (register, value, part) in [
        (xl430::HOMING_OFFSET, 200, "servo 2: Homing Offset (register 20): expected 0, got 200"),
        (xl430::DRIVE_MODE, 1, "servo 2: Drive Mode (register 10): expected 0, got 1"),
    ] {
        touch(&file, 2, register, value);
        for verb in verbs {
            let refused = run(rig.path(), verb);
            let why = refused.error(1);
            assert!(why.contains(part) && why.contains("rig check --rig FILE --restore"), "{verb:?}: {why}");
        }
        let check = ["rig", "check", "--rig", "rig/rig.toml", "--restore"];
        // Nobody is there to be asked.
        assert!(run(rig.path(), &check).error(2).contains("--yes"));
        let restored = run(rig.path(), &[&check[..], &["--yes"]].concat()).succeeded();
        assert!(restored.stdout.contains("registers written back: 1; torque off"), "{}", restored.stdout);
        let checked = run(rig.path(), verbs[3]).succeeded();
        assert!(checked.stdout.contains("registers: as expected"), "{}", checked.stdout);
        assert!(checked.stdout.contains("poses at"), "{}", checked.stdout);
    }
    assert!(rig.torques().iter().all(|(_, on)| !on));
    // And then it moves.
    let recorded = run(rig.path(), verbs[0]).succeeded();
    assert!(recorded.stderr.contains("has no record of the servos' registers"), "{}", recorded.stderr);
}

#[test]
fn no_arm_is_led_whose_registers_were_touched() {
    let arms = EmulatedArms::start(&[]);
    let file = arms.path().join("arms/patient.toml");
    let config = ArmsConfig::read(&file).unwrap();
    let touch = |arm: usize, servo: u8, register: ControlRegister, value: u32| {
        ArmPair::open(&config).unwrap().buses()[arm].write(servo, register, value).unwrap();
    };
    let record = ["arm", "record", "--arms", "arms/patient.toml", "--seconds", "1", "--out", "out.parquet"];
    let check = ["rig", "check", "--rig", "arms/patient.toml"];
    // Of the leader, whose angles the follower is sent to, and of the follower.
    for (arm, servo, register, value, part) in [
        (0, 3, xl430::HOMING_OFFSET, 200, "servo 3: Homing Offset (register 20): expected 0, got 200"),
        (1, 12, xl430::DRIVE_MODE, 1, "servo 12: Drive Mode (register 10): expected 0, got 1"),
        (1, 13, xl430::CURRENT_LIMIT, 500, "servo 13: Current Limit (register 38): expected 1193, got 500"),
    ] {
        touch(arm, servo, register, value);
        for verb in [&record[..], &check[..]] {
            let refused = run(arms.path(), verb);
            assert!(refused.error(1).contains(part), "{verb:?}: {}", refused.stderr);
        }
        assert!(!arms.is_under_torque());
        run(arms.path(), &[&check[..], &["--restore", "--yes"]].concat()).succeeded();
    }
    run(arms.path(), &check).succeeded();
    // The values of a servo in the file are expected of it.
    let text = std::fs::read_to_string(&file).unwrap();
    let mounted = "follower = { id = 12, model = \"XM430-W350\", zero_ticks = 2048, turns = \"positive\" }";
    assert!(text.contains(mounted));
    let other = mounted.replace(" }", ", registers = { current_limit = 900 } }");
    std::fs::write(&file, text.replace(mounted, &other)).unwrap();
    assert!(
        run(arms.path(), &check)
            .error(1)
            .contains("servo 12: Current Limit (register 38): expected 900, got 1193")
    );
    touch(1, 12, xl430::CURRENT_LIMIT, 900);
    run(arms.path(), &check).succeeded();
}
