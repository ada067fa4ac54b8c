//! Friction along the tendons: capstan, stick and slip, memory, and no work out of nothing.

use hysteron_base::{Friction, Scene};
use hysteron_fem::Mesh;
use hysteron_twin::{Error, Stepper, Target, TipGoal, TwinState};
use rand::RngExt;

use super::scenes::ROUGH;
use super::{Robot, assert_close, distance, rng, scenes, strokes, tolerance};

const COMPLIANCE: f64 = 2e-4;
/// Equilibria of the same commands differ by a residual of 1e-8 of 5 N on a body that 5 N bend by 20 mm.
const SAME_TIP: f64 = 1e-8;
const NONE: Friction = Friction {
    coefficient: 0.0,
    coulomb: 0.0,
    points: 0,
    sheath_exponent: 0.0,
    sheath_coulomb: 0.0,
    sheath_compliance_share: 0.0,
    backlash: 0.0,
};

fn rubbing(friction: Friction, compliance: f64) -> (Scene, Mesh) {
    let (mut scene, mesh) = scenes::robot();
    for tendon in &mut scene.tendons {
        tendon.compliance = compliance;
    }
    scene.friction = Some(friction);
    (scene, mesh)
}

/// Tendon 1 pulled, the others released as far as it bends the body, and slack.
fn bend(stroke: f64) -> Vec<Target> {
    strokes(&[stroke, -6e-3, -9e-3, -6e-3])
}

/// Length of each segment of a tendon, and its turn at each point [rad] (both ends included, as zero).
fn geometry(robot: &Robot, j: usize) -> (Vec<f64>, Vec<f64>) {
    let line = robot.twin.cables.polyline(j, &robot.state.positions);
    let segments: Vec<[f64; 3]> =
        line.windows(2).map(|pair| std::array::from_fn(|c| pair[1][c] - pair[0][c])).collect();
    let dot = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
    let lengths: Vec<f64> = segments.iter().map(|way| dot(way, way).sqrt()).collect();
    let turn =
        |k: usize| (dot(&segments[k - 1], &segments[k]) / (lengths[k - 1] * lengths[k])).min(1.0).acos();
    let inner = (1..segments.len()).map(turn);
    let turns = [0.0].into_iter().chain(inner).chain([0.0]).collect();
    (lengths, turns)
}

/// Length of tendon `j` from its point `first` on, when the nodes are at `x` [m].
fn way_behind(robot: &Robot, j: usize, first: usize, x: &[[f64; 4]]) -> f64 {
    let line = robot.twin.cables.polyline(j, x);
    line[first..].windows(2).map(|pair| distance(pair[0], pair[1])).sum()
}

#[test]
fn tension_at_the_tip_follows_the_capstan_equation_to_first_order_in_the_step() {
    for points in [1, 3, 9] {
        let error = |steps: u32| {
            let mut robot = Robot::new(&rubbing(Friction { coefficient: 0.4, points, ..NONE }, 0.0));
            for k in 1..=steps {
                robot.go(&bend(4e-3 * f64::from(k) / f64::from(steps)));
            }
            let turn: f64 = geometry(&robot, 0).1.iter().sum();
            assert!(turn > 0.4, "a bend that tests something: {turn}");
            let tensions = robot.twin.tensions_along(0, &robot.state);
            assert_eq!(tensions.len(), points + 1);
            tensions[points] / (tensions[0] * f64::exp(-0.4 * turn)) - 1.0
        };
        let (coarse, fine) = (error(40), error(80));
        println!("capstan, {points} points: {coarse:.1e} after 40 steps, {fine:.1e} after 80");
        // Turns and tensions are those of one step before, that is 1/80 of the whole, of an exponent of 0.3.
        assert!(fine.abs() < tolerance(0.4 / 80.0), "{fine}");
        assert!((coarse / fine - 2.0).abs() < tolerance(0.2), "{coarse} {fine}");
    }
}

#[test]
fn points_without_friction_change_nothing() {
    let mut rubbing = Robot::new(&rubbing(Friction { points: 4, ..NONE }, 0.0));
    let mut plain = Robot::new(&scenes::robot());
    for k in 0..20 {
        let angle = 0.3 * f64::from(k);
        let (x, y) = (1.5e-3 * angle.cos(), 1.5e-3 * angle.sin());
        rubbing.go(&strokes(&[x, y, -x, -y]));
        plain.go(&strokes(&[x, y, -x, -y]));
        assert!(distance(rubbing.tip(), plain.tip()) < tolerance(SAME_TIP));
        assert!(rubbing.state.tensions[4..].iter().all(|jump| *jump == 0.0));
    }
}

#[test]
fn friction_beyond_all_tensions_holds_the_tendons_where_they_are() {
    let mut rubbing = Robot::new(&rubbing(Friction { coulomb: 1e5, points: 9, ..NONE }, 0.0));
    let mut plain = Robot::new(&scenes::robot());
    let rest = plain.tip();
    for k in 1..=10 {
        rubbing.go(&bend(5e-5 * f64::from(k)));
        plain.go(&bend(5e-5 * f64::from(k)));
    }
    assert!(rubbing.state.slip.iter().all(|slide| *slide == 0.0), "{:?}", rubbing.state.slip);
    // Of ten segments only the first can shorten.
    for point in &rubbing.twin.friction {
        let length = |x: &[[f64; 4]]| way_behind(&rubbing, point.tendon, point.first, x);
        let (now, before) = (length(&rubbing.state.positions), length(&rubbing.twin.body.rest));
        assert_close("way behind a point", now, before, 1.1e-10);
    }
    let (moved, free) = (distance(rubbing.tip(), rest), distance(plain.tip(), rest));
    assert!(moved > 1e-5 && (moved - free).abs() > 0.05 * free, "{moved} {free}");
}

#[test]
fn reversals_within_the_band_of_the_sheath_do_not_move_the_tip() {
    let friction = Friction { sheath_coulomb: 0.8, sheath_compliance_share: 0.6, ..NONE };
    let mut robot = Robot::new(&rubbing(friction, COMPLIANCE));
    for k in 1..=20 {
        robot.go(&bend(1e-4 * f64::from(k)));
    }
    let (tip, top) = (robot.tip(), robot.state.tensions[0]);
    // Both ways the sheath slips at 0.8 N, and the tendon before it stretches by 0.6 of its compliance.
    let band = 2.0 * 0.8 * 0.6 * COMPLIANCE;
    for part in [0.3, 0.9, 0.1, 0.95, 0.0] {
        robot.go(&bend(2e-3 - part * band));
        assert!(distance(robot.tip(), tip) < tolerance(SAME_TIP), "{part}");
        assert_close("tension at the servo", robot.state.tensions[0], top - part * 1.6, 1e-5);
    }
    robot.go(&bend(2e-3 - 1.5 * band));
    assert!(distance(robot.tip(), tip) > 1e-5, "beyond the band it moves");
    robot.go(&bend(2e-3));
    robot.go(&bend(2e-3 + 1e-9));
    assert!(distance(robot.tip(), tip) < 1e-6, "a minor loop closes: {}", distance(robot.tip(), tip));
}

/// Work at the pulled ends and heat at the points over a cycle of pulls and releases, the first one not counted,
/// and the largest energy that the points gave back in a step.
fn cycle(friction: Friction, steps: u32) -> (f64, f64, f64) {
    let mut robot = Robot::new(&rubbing(friction, COMPLIANCE));
    let (mut work, mut heat, mut gained) = (0.0, 0.0, 0.0f64);
    let mut before = (robot.twin.commands_of(&robot.state), robot.state.clone());
    for k in 0..=2 * steps {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(steps);
        let pull = 1.5e-3 * (1.0 - angle.cos()) + 2e-4;
        robot.go(&strokes(&[pull, 1e-4, -pull, -1e-4]));
        let now = (robot.twin.commands_of(&robot.state), robot.state.clone());
        if k > steps {
            for j in 0..4 {
                work += 0.5 * (before.1.tensions[j] + now.1.tensions[j]) * (now.0[j] - before.0[j]);
            }
            for i in 0..now.1.slip.len() {
                let warmth = -now.1.tensions[4 + i] * (now.1.slip[i] - before.1.slip[i]);
                heat += warmth;
                gained = gained.max(-warmth);
            }
        }
        before = now;
    }
    (work, heat, gained)
}

#[test]
fn work_of_a_closed_cycle_is_the_heat_of_friction() {
    let (work, heat, gained) = cycle(NONE, 100);
    let (scale, _, _) = cycle(ROUGH, 100);
    assert!(work.abs() < 1e-6 * scale && heat == 0.0 && gained == 0.0, "{work} {heat} {scale}");
    let errors: Vec<f64> = [100, 200]
        .into_iter()
        .map(|steps| {
            let (work, heat, gained) = cycle(ROUGH, steps);
            println!(
                "cycle of {steps} steps: work {work:.6e} J, heat {heat:.6e} J, given back {gained:.1e} J"
            );
            assert!(heat > 0.0 && work > 0.0);
            // A jump of 1 N within the stroke accuracy of 1e-10 m.
            assert!(gained < tolerance(1e-9), "{gained}");
            (work / heat - 1.0).abs()
        })
        .collect();
    // Slip takes the friction at the end of each step: first order, 1/100 of the way per step.
    assert!(errors[0] < tolerance(0.03) && errors[1] < tolerance(0.015), "{errors:?}");
}

#[test]
fn friction_only_takes_energy_on_any_way() {
    let mut robot = Robot::new(&rubbing(ROUGH, COMPLIANCE));
    let mut rng = rng("rubbing");
    let (mut command, mut n_stuck, mut n_slipping) = ([0.0; 4], 0, 0);
    for _ in 0..80 {
        for stroke in &mut command {
            *stroke = f64::clamp(*stroke + rng.random_range(-4e-4..4e-4), -6e-4, 2e-3);
        }
        let before = robot.state.clone();
        robot.go(&strokes(&command));
        for i in 0..robot.state.slip.len() {
            let moved = robot.state.slip[i] - before.slip[i];
            assert!(-robot.state.tensions[4 + i] * moved > -tolerance(1e-9));
            *if moved == 0.0 { &mut n_stuck } else { &mut n_slipping } += 1;
        }
    }
    assert!(n_stuck > 100 && n_slipping > 100, "the drive must meet both: {n_stuck} {n_slipping}");
}

#[test]
fn tensions_along_a_tendon_are_those_of_the_actuators_own_model() {
    // A point at every inner point of the tendon; the other model gets the lengths and turns of the body.
    let (coefficient, coulomb) = (0.3, 0.09);
    let error = |steps: u32| {
        let friction = Friction { coefficient, coulomb, points: 9, ..NONE };
        let mut robot = Robot::new(&rubbing(friction, COMPLIANCE));
        let mut other = hysteron_actuator::TendonModel::new(hysteron_actuator::TendonSpec {
            rest_lengths: geometry(&robot, 0).0,
            axial_stiffness: robot.twin.cables.rest_lengths[0] / COMPLIANCE,
            friction: coefficient,
            friction_force: coulomb / 9.0,
            law: hysteron_actuator::FrictionLaw::Coulomb,
        })
        .unwrap();
        let mut trial = other.trial();
        let (mut error, mut largest) = (0.0f64, 0.0f64);
        for k in 1..=steps {
            let stroke = 2e-3 * (1.5 * std::f64::consts::TAU * f64::from(k) / f64::from(steps)).sin().abs();
            robot.go(&bend(stroke));
            let (lengths, turns) = geometry(&robot, 0);
            other.solve(&lengths, &turns, stroke, &mut trial);
            other.commit(&trial);
            for (mine, its) in robot.twin.tensions_along(0, &robot.state).iter().zip(&other.tensions) {
                error = error.max((mine - its).abs());
                largest = largest.max(*its);
            }
        }
        assert!(largest > 1.0, "{largest}");
        error / largest
    };
    let (coarse, fine) = (error(150), error(600));
    println!("against the actuator's tendon: {coarse:.1e} with 150 steps, {fine:.1e} with 600");
    assert!(fine < tolerance(0.01) && fine < 0.5 * coarse, "{coarse} {fine}");
}

#[test]
fn backlash_is_crossed_before_the_tendon_follows() {
    let friction = Friction { backlash: 4e-4, ..NONE };
    let mut robot = Robot::new(&rubbing(friction, 0.0));
    let mut plain = Robot::new(&scenes::robot());
    robot.go(&bend(1.7e-3));
    plain.go(&bend(1.5e-3));
    let held = robot.state.backlash.clone();
    assert_close("play", held[0], 1.5e-3, 1e-18);
    for stroke in [1.5e-3, 1.31e-3, 1.69e-3] {
        robot.go(&bend(stroke));
        assert_eq!(robot.state.backlash[0], held[0]);
    }
    for (command, output) in [(1.0e-3, 1.2e-3), (1.2e-3, 1.2e-3), (1.6e-3, 1.4e-3)] {
        robot.go(&bend(command));
        plain.go(&bend(output));
        assert_close("play", robot.state.backlash[0], output, 1e-18);
        assert!((robot.tip()[0] - plain.tip()[0]).abs() < tolerance(SAME_TIP));
    }
}

fn command(k: usize) -> Vec<Target> {
    let angle = 0.15 * k as f64;
    let (x, y) = (1.8e-3 * angle.cos(), 1.8e-3 * (0.7 * angle).sin());
    strokes(&[x, y, -x, -y])
}

#[test]
fn resumed_trajectory_with_friction_is_the_uninterrupted_one() {
    let scene = rubbing(Friction { backlash: 1e-4, ..ROUGH }, COMPLIANCE);
    let (mut whole, mut interrupted) = (Robot::new(&scene), Robot::new(&scene));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.bin");
    let mut largest = 0.0f64;
    for k in 0..50 {
        whole.go(&command(k));
        interrupted.go(&command(k));
        if k % 10 == 5 {
            interrupted.state.write(&path, &interrupted.twin, "hash", "hysteron simulate").unwrap();
            interrupted.stepper = Stepper::new(&interrupted.twin);
            let read = TwinState::read(&path, &interrupted.twin, "hash").unwrap();
            assert_eq!(read, interrupted.state);
            interrupted.state = read;
        }
        largest = largest.max(distance(whole.tip(), interrupted.tip()));
    }
    println!("tip after resuming with friction: {largest:.1e} m apart");
    // As without friction, each iteration stops elsewhere within 1e-8 of the forces.
    assert!(largest < tolerance(1e-8), "{largest}");
    // A state without the memory is of another robot.
    let error = TwinState::read(&path, &Robot::new(&scenes::robot()).twin, "hash").unwrap_err();
    assert!(error.bad_input().unwrap().place.ends_with("size"), "{error}");
}

#[test]
fn step_that_fails_leaves_the_memory_at_the_last_equilibrium() {
    let mut robot = Robot::new(&rubbing(Friction { backlash: 1e-4, ..ROUGH }, 0.0));
    for k in 0..10 {
        robot.go(&command(k));
    }
    let squeezed = strokes(&[2.5e-2, 2.5e-2, 2.5e-2, 2.5e-2]);
    let error = robot.try_step(&squeezed).expect_err("no equilibrium");
    assert!(matches!(error, Error::NoEquilibrium { .. }), "{error}");
    // Tendons that keep their length have slid as far past a point as their way behind it is shorter.
    for (point, slide) in robot.twin.friction.iter().zip(&robot.state.slip) {
        let length = |x: &[[f64; 4]]| way_behind(&robot, point.tendon, point.first, x);
        let reached = length(&robot.twin.body.rest) - length(&robot.state.positions);
        assert_close("slide", *slide, reached, 1.1e-10);
    }
    for (j, stroke) in robot.strokes().iter().enumerate().filter(|(j, _)| robot.state.tensions[*j] > 0.0) {
        assert_close("play", robot.state.backlash[j], *stroke, 1.1e-10);
    }
    robot.go(&command(10));
}

#[test]
fn goals_are_approached_as_far_as_friction_lets_the_search() {
    let scene = rubbing(ROUGH, COMPLIANCE);
    let mut maker = Robot::new(&scene);
    for k in 1..=10 {
        maker.go(&strokes(&[1e-4 * f64::from(k), 1.2e-4 * f64::from(k), -5e-3, -5e-3]));
    }
    let mut robot = Robot::new(&scene);
    robot.go(&[Target::Free; 4]);
    let goal =
        TipGoal { position: maker.tip().map(Some), tolerance: 1e-6, regularisation: 1e-6, least_gain: 0.0 };
    let start = distance(robot.tip(), maker.tip());
    let report = robot.reach(&goal, &[Target::Free; 4]).unwrap();
    println!("goal with friction: {:.1e} m left of {start:.1e} m", report.tip_error);
    // The linearisation lets the tendons slip; of the way, what they hold at the end is left.
    assert!(report.tip_error < tolerance(0.02 * start), "{report:?}");
    let tip = robot.tip();
    robot.go(&strokes(&report.strokes));
    assert!(distance(robot.tip(), tip) < 1e-6, "the strokes keep it there");
}
