//! Reference measurements of the presets: new physics must leave them unchanged.

use super::super::VirtualRobot;
use super::bench::Bench;
use hysteron_base::file::sha256_hex;
use std::fmt::Write;

/// Robot, member of its population, and the hash of [`measured`], made at commit 824e975 on Linux, x86-64.
const GOLDEN: [(&str, Option<u64>, &str); 5] = [
    ("mild", None, "7b922b1676627f42072ef786bfd096b05eeaf1f7f39b8d9c5191ab5442b93ab1"),
    ("typical", None, "00e2cacffe6f9c858f30541f420a1ec832f785b52c088e5f43b1fe2678718d1c"),
    ("harsh", None, "9b5db33e01934c30ccd25f106a38dd39d7c7fd91727aa0a5f683869904e7dc38"),
    ("typical", Some(3), "93ff49e256e7cbb89210fcd8db15c81a7f5d408ad6cbfaba89f0c9378d3ca47c"),
    ("harsh", Some(11), "04848ff40614e000d0b67dc751284871d45405607b7350c7a3bc3ad4fdbe0e3a"),
];

/// Poses, strokes and loads of two circles of strokes and a rest, in nanometres, and in hundredths of ticks and of
/// per cents:
/// coarse enough for another library of elementary functions, fine enough for any change of the physics.
fn measured(robot: &VirtualRobot) -> String {
    let mut bench = Bench::new(robot, 5);
    let (mut text, mut poses) = (String::new(), Vec::new());
    for i in 0..600 {
        let (angle, amplitude) = (0.02 * f64::from(i), 4e-3 * (f64::from(i) / 200.0).min(1.0));
        let at = |k: usize| amplitude * (angle - std::f64::consts::FRAC_PI_2 * k as f64).cos();
        bench.command(&[0, 1, 2, 3].map(|k| if i < 500 { at(k) } else { 0.0 }));
        bench.world.take_poses(&mut poses);
        for k in 0..4 {
            let (stroke, load) = (bench.world.stroke(k), bench.world.load(k));
            write!(text, "{:.0} {:.0} ", 1e9 * stroke, 1e4 * load).unwrap();
        }
    }
    for tracked in &poses {
        for coordinate in tracked.pose.position {
            write!(text, "{:.0} ", 1e9 * coordinate).unwrap();
        }
    }
    text
}

/// SHA-256 over every bit of the same, tensions and truth of the tip among it; made at commit 092eb0f, before the servos became presets of
/// `hysteron_actuator::Drive`, on the machine of [`GOLDEN`].
const BITS: [(&str, &str); 2] = [
    ("typical", "16fa8181de97881b993ce1c2d28e960579ad70a91cd8bfbeec3f75aaa50d456e"),
    ("harsh", "07e9938ab2b2f0ca9ec6e7c28d80500989a808ab1647f984f74fde3c077aa79d"),
];

/// Bytes of the quantities that [`measured`] rounds, unrounded, little endian.
fn bits(robot: &VirtualRobot) -> Vec<u8> {
    let mut bench = Bench::new(robot, 9);
    let (mut bytes, mut poses) = (Vec::new(), Vec::new());
    for i in 0..600 {
        let (angle, amplitude) = (0.05 * f64::from(i), 5e-3 * (f64::from(i) / 300.0).min(1.0));
        let at = |k: usize| amplitude * (angle - std::f64::consts::FRAC_PI_2 * k as f64).cos();
        bench.world.set_disturbance(i as usize % 4, 0.05 * angle.sin());
        bench.world.command_mut(3).torque_on = !(400..450).contains(&i);
        bench.command(&[0, 1, 2, 3].map(|k| if i < 500 { at(k) } else { 0.0 }));
        bench.world.take_poses(&mut poses);
        let world = &bench.world;
        let of_servo = |k: usize| [world.stroke(k), world.load(k), world.tension(k), bench.present(k)];
        for x in (0..4).flat_map(of_servo).chain(bench.tip()) {
            bytes.extend_from_slice(&x.to_le_bytes());
        }
    }
    for x in
        poses.iter().flat_map(|tracked| tracked.pose.position.into_iter().chain(tracked.pose.orientation))
    {
        bytes.extend_from_slice(&x.to_le_bytes());
    }
    bytes
}

#[test]
fn servos_and_body_do_to_the_last_bit_what_they_did_before_they_shared_a_drive() {
    let found = BITS.map(|(preset, _)| (preset, sha256_hex(&bits(&VirtualRobot::preset(preset).unwrap()))));
    assert_eq!(found.each_ref().map(|(preset, hash)| (*preset, hash.as_str())), BITS);
}

#[test]
fn presets_and_their_members_measure_what_they_always_did() {
    for (preset, member, golden) in GOLDEN {
        let robot = VirtualRobot::preset(preset).unwrap();
        let robot = member.map_or(robot.clone(), |member| robot.draw(member));
        let found = sha256_hex(measured(&robot).as_bytes());
        println!("{preset} {member:?}: {found}");
        assert_eq!(found, golden, "{preset} {member:?}");
    }
}
