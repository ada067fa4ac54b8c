//! The whole world: clock, seeds, servos on a body, tracker.

use super::super::{TrackedPose, VirtualRobot, World};
use super::bench::{Bench, distance};

fn typical() -> VirtualRobot {
    VirtualRobot::preset("typical").unwrap()
}

/// Commands something and lets time pass in parts of `dt` [s]; all poses, and the tip.
fn lived(seed: u64, dt: f64) -> (Vec<TrackedPose>, [f64; 3]) {
    let mut world = World::new(&typical(), seed);
    let mut poses = Vec::new();
    for k in 0..4 {
        let command = world.command_mut(k);
        command.torque_on = true;
        command.goal += 100 * k as i32 - 150;
        command.profile_velocity = 1.0;
        command.profile_acceleration = 5.0;
    }
    for _ in 0..(2.0 / dt).round() as usize {
        world.advance(dt);
        world.take_poses(&mut poses);
    }
    assert!((world.time() - 2.0).abs() < 1e-9, "{}", world.time());
    (poses, world.tip().position)
}

#[test]
fn same_seed_gives_the_same_world_however_time_is_cut() {
    let reference = lived(7, 0.01);
    assert_eq!(reference, lived(7, 0.01));
    assert_eq!(reference, lived(7, 0.0025));
    assert_eq!(reference, lived(7, 0.1));
    assert_ne!(reference.0, lived(8, 0.01).0);
    // Another seed has other angles and another tracker, but the same body.
    assert!(distance(reference.1, lived(8, 0.01).1) < 0.2e-3);
}

#[test]
fn copy_of_a_world_lives_the_same_life() {
    let mut bench = Bench::new(&typical(), 1);
    bench.pull(0, 3e-3, 1.0);
    let mut copy = bench.world.clone();
    bench.world.advance(0.5);
    copy.advance(0.5);
    let (mut here, mut there) = (Vec::new(), Vec::new());
    bench.world.take_poses(&mut here);
    copy.take_poses(&mut there);
    assert_eq!(here, there);
    assert_eq!(bench.world.tip(), copy.tip());
}

#[test]
fn poses_come_late_in_order_and_with_the_stated_noise() {
    let robot = typical();
    let mut world = World::new(&robot, 3);
    let mut poses = Vec::new();
    for _ in 0..6000 {
        world.advance(0.01);
        let before = poses.len();
        world.take_poses(&mut poses);
        assert!(poses[before..].iter().all(|pose: &TrackedPose| pose.sent_at <= world.time()));
    }
    assert!((4780..=4800).contains(&poses.len()), "{}", poses.len());
    for pair in poses.windows(2) {
        assert!(pair[1].pose.time > pair[0].pose.time && pair[1].sent_at >= pair[0].sent_at);
    }
    assert!(poses.iter().all(|pose| pose.sent_at - pose.pose.time >= robot.tracker.latency));
    // Successive differences hide the slow error: deviation √2 σ.
    let square = |pair: &[TrackedPose]| (pair[1].pose.position[0] - pair[0].pose.position[0]).powi(2);
    let deviation = (poses.windows(2).map(square).sum::<f64>() / (2.0 * poses.len() as f64)).sqrt();
    assert!((deviation / robot.tracker.position_noise - 1.0).abs() < 0.05, "{deviation}");
    // In the tracker's frame, not in the robot's.
    assert!(distance(poses[0].pose.position, world.tip().position) > 0.05);
    let norm: f64 = poses[9].pose.orientation.iter().map(|x| x * x).sum();
    assert!((norm - 1.0).abs() < 1e-12);
}

#[test]
fn distance_between_poses_is_that_between_tips() {
    let mut robot = typical();
    (robot.tracker.position_noise, robot.tracker.bias, robot.tracker.dropout) = (0.0, 0.0, 0.0);
    let mut bench = Bench::new(&robot, 1);
    let last = |bench: &mut Bench| {
        bench.rest(1.0);
        let mut poses = Vec::new();
        bench.world.take_poses(&mut poses);
        poses[poses.len() - 1].pose.position
    };
    let (tip, pose) = (bench.tip(), last(&mut bench));
    bench.pull(1, 6e-3, 2.0);
    for _ in 0..100 {
        bench.command(&[0.0, 5e-3, 0.0, -5e-3]);
    }
    let moved = bench.tip();
    let mut poses = Vec::new();
    bench.world.take_poses(&mut poses);
    let found = distance(poses[poses.len() - 1].pose.position, pose);
    assert!(distance(moved, tip) > 0.01);
    assert!((found - distance(moved, tip)).abs() < 0.1e-3, "{found} {}", distance(moved, tip));
}

#[test]
fn nothing_comes_from_a_tracker_that_is_gone() {
    let mut world = World::new(&typical(), 1);
    let mut poses = Vec::new();
    world.advance(0.5);
    world.set_tracker_connected(false);
    world.advance(0.5);
    world.take_poses(&mut poses);
    assert!(poses.is_empty());
    world.set_tracker_connected(true);
    world.advance(0.5);
    world.take_poses(&mut poses);
    assert!(poses.len() > 30 && poses.iter().all(|pose| pose.pose.time >= 0.99), "{}", poses.len());
}

#[test]
fn pulled_tendon_loads_its_servo_and_unwinds_it_without_torque() {
    let mut bench = Bench::new(&typical(), 1);
    for i in 0..=300 {
        bench.command(&[2e-5 * f64::from(i), 0.0, -2e-5 * f64::from(i), 0.0]);
    }
    bench.world.advance(1.0);
    let (tension, load) = (bench.world.tension(0), bench.world.load(0));
    assert!(tension > 15.0, "{tension}");
    // Within its own friction the servo carries the tendon.
    let torque = tension * 0.01;
    assert!((load * 1.445 - torque).abs() < 0.07, "{load} {torque}");
    assert!((bench.world.stroke(0) - 6e-3).abs() < 1e-3, "{}", bench.world.stroke(0));
    // Without torque the tendon turns it back until friction holds.
    bench.world.command_mut(0).torque_on = false;
    bench.world.advance(3.0);
    let left = bench.world.tension(0) * 0.01;
    assert!(left < 0.066, "{left}");
    assert!(bench.world.stroke(0) < 3e-3, "{}", bench.world.stroke(0));
}

#[test]
fn power_cycle_takes_the_torque_and_leaves_the_angle() {
    let mut bench = Bench::new(&typical(), 1);
    bench.rest(0.2);
    let angle = bench.world.servo(2).state.angle;
    bench.world.power_cycle(2);
    bench.world.advance(0.1);
    assert!(!bench.world.command_mut(2).torque_on);
    assert!((bench.world.servo(2).state.angle - angle).abs() < 1e-3);
}

#[test]
fn held_pulley_stops_its_servo() {
    let mut bench = Bench::new(&typical(), 1);
    bench.rest(0.2);
    let angle = bench.world.servo(0).state.angle;
    bench.world.set_disturbance(0, -1.6);
    bench.world.set_supply(11.1);
    for _ in 0..50 {
        bench.command(&[5e-3, 0.0, 0.0, 0.0]);
    }
    assert!(bench.world.servo(0).state.angle < angle + 0.01);
    assert!(bench.world.load(0) > 0.9);
}

#[test]
fn heat_only_ever_grows() {
    // 32 guides, slips of 5 mm known to their last digit, tensions of 50 N.
    let rounding = 32.0 * f64::EPSILON * 5e-3 * 50.0;
    let mut bench = Bench::new(&typical(), 1);
    let mut last = bench.world.energy();
    for i in 0..400 {
        let s = 4e-3 * (0.05 * f64::from(i)).sin();
        bench.command(&[s, 0.3 * s, -s, -0.3 * s]);
        let now = bench.world.energy();
        assert!(now.friction_heat >= last.friction_heat - rounding && now.stored.is_finite());
        assert!(now.creep_heat >= last.creep_heat - 1e-9);
        last = now;
    }
    assert!(last.friction_heat > 1e-3 && last.creep_heat > 1e-3, "{last:?}");
}

#[test]
fn kept_factors_lead_to_the_same_balance() {
    let live = |always: bool| {
        let mut bench = Bench::new(&typical(), 1);
        if always {
            bench.world.always_factorise();
        }
        bench.pull(2, 6e-3, 4.0);
        (bench.tip(), bench.world.balance_counts())
    };
    let ((kept, few), (new, many)) = (live(false), live(true));
    // Both are balanced to 1e-9 of a section's strain; paths through stick and slip add up.
    assert!(distance(kept, new) < 1e-6, "{kept:?} {new:?}");
    assert!(3 * few.factorisations < many.factorisations, "{few:?} {many:?}");
}
