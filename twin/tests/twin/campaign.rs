//! Thousands of wild commands: an accurate equilibrium or an honest error, never anything else.

use hysteron_base::{MaterialLaw, PointForce};
use hysteron_fem::Order;
use hysteron_twin::{Error, StepReport, Target};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Robot, check_report, rng, scenes};

/// Counts of a campaign's steps, by how they were solved.
#[derive(Debug, Default)]
struct Shares {
    fast: usize,
    newton: usize,
    sub_stepped: usize,
    no_equilibrium: usize,
    clarabel: usize,
}

impl Shares {
    fn count(&mut self, report: &StepReport) {
        self.fast += usize::from(report.newton_iterations == 0);
        self.newton += usize::from(report.newton_iterations > 0 && report.sub_steps == 1);
        self.sub_stepped += usize::from(report.sub_steps > 1);
        self.clarabel += report.clarabel_solves;
    }

    fn print(&self, name: &str) {
        let all = (self.fast + self.newton + self.sub_stepped + self.no_equilibrium) as f64;
        let share = |n: usize| 100.0 * n as f64 / all;
        println!(
            "{name}: {all} commands, {:.1} % fast, {:.1} % Newton, {:.1} % in parts, {:.1} % no equilibrium, {} QPs by clarabel",
            share(self.fast),
            share(self.newton),
            share(self.sub_stepped),
            share(self.no_equilibrium),
            self.clarabel
        );
    }
}

/// One command, evaluated.
fn try_step(robot: &mut Robot, targets: &[Target], shares: &mut Shares) {
    match robot.try_step(targets) {
        Ok(report) => {
            check_report(&robot.twin, &report);
            assert_eq!(robot.state.load, 1.0);
            shares.count(&report);
        }
        Err(Error::NoEquilibrium { reached, .. }) => {
            if std::env::var("SHOW").is_ok() {
                println!("no equilibrium beyond {reached}: {targets:?} from {:?}", robot.strokes());
            }
            assert!((0.0..1.0).contains(&reached), "{reached}");
            shares.no_equilibrium += 1;
        }
        Err(other) => panic!("{other} for {targets:?}"),
    }
    let state = &robot.state;
    let finite = state.positions.iter().flatten().chain(&state.tensions).all(|number| number.is_finite());
    assert!(finite, "a number is not finite after {targets:?}");
    for (tension, tendon) in state.tensions.iter().zip(&robot.twin.tendons) {
        assert!(tendon.tension.contains(*tension), "{tension} N after {targets:?}");
    }
}

fn wander(robot: &mut Robot, name: &str, steps: usize, jump: f64, range: f64) -> Shares {
    let mut rng = rng(name);
    let mut shares = Shares::default();
    let mut command = [0.0f64; 4];
    for _ in 0..steps {
        for stroke in &mut command {
            *stroke = (*stroke + rng.random_range(-jump..jump)).clamp(-range, range);
        }
        try_step(robot, &super::strokes(&command), &mut shares);
    }
    shares.print(name);
    shares
}

#[test]
fn small_steps_are_fast() {
    let shares = wander(&mut Robot::new(&scenes::robot()), "steps of 0.05 mm", 300, 5e-5, 1.5e-3);
    assert_eq!(shares.no_equilibrium, 0);
    // Only the first step, from the unloaded body, and a few where several tendons change at once.
    assert!(shares.fast >= 290, "{shares:?}");
}

#[test]
fn moderate_jumps_always_succeed() {
    let shares = wander(&mut Robot::new(&scenes::robot()), "jumps of 1 mm", 300, 1e-3, 2e-3);
    assert_eq!(shares.no_equilibrium, 0);
}

#[test]
fn large_jumps_end_in_equilibrium_or_error() {
    let shares = wander(&mut Robot::new(&scenes::robot()), "jumps of 6 mm", 200, 6e-3, 6e-3);
    assert!(shares.no_equilibrium < 60, "{shares:?}");
}

#[test]
fn loads_and_gravity_do_not_disturb() {
    let (mut scene, mesh) = scenes::robot();
    scene.gravity = [3.0, -9.0, 0.0];
    scene.point_forces.push(PointForce { at: [0.0, 0.0045, scenes::LENGTH], force: [0.0, 0.0, -1.0] });
    let shares = wander(&mut Robot::new(&(scene, mesh)), "loaded, jumps of 1 mm", 150, 1e-3, 2e-3);
    assert_eq!(shares.no_equilibrium, 0);
}

#[test]
fn neo_hookean_body_survives() {
    let scene = scenes::robot_with(MaterialLaw::NeoHookean, Order::Linear, 12);
    let shares = wander(&mut Robot::new(&scene), "neo-Hookean, jumps of 2 mm", 150, 2e-3, 3e-3);
    assert!(shares.no_equilibrium < 30, "{shares:?}");
}

/// A target of any kind.
fn any_target(rng: &mut ChaCha8Rng) -> Target {
    match rng.random_range(0..10) {
        0 => Target::Free,
        1 => Target::Tension(0.0),
        2..5 => Target::Tension(rng.random_range(0.0..8.0)),
        5 => Target::Stroke(0.0),
        6 => Target::Stroke(rng.random_range(-0.05..0.0)),
        _ => Target::Stroke(rng.random_range(-2e-3..4e-3)),
    }
}

#[test]
fn any_mixture_of_drives_ends_in_equilibrium_or_error() {
    let mut rng = rng("mixture");
    let mut robot = Robot::new(&scenes::robot());
    let mut shares = Shares::default();
    for k in 0..300 {
        let targets: Vec<Target> = match k % 10 {
            // All go slack at once, and are pulled together.
            0 => vec![Target::Tension(0.0); 4],
            1 => vec![Target::Stroke(rng.random_range(0.0..1e-3)); 4],
            _ => (0..4).map(|_| any_target(&mut rng)).collect(),
        };
        try_step(&mut robot, &targets, &mut shares);
    }
    shares.print("mixed drives");
    assert!(shares.no_equilibrium < 30, "{shares:?}");
}

#[test]
fn robot_with_auxiliary_cables_survives() {
    let mut rng = rng("auxiliary");
    let mut robot = Robot::of(super::layout::paper_robot());
    let mut shares = Shares::default();
    let mut command = vec![0.0f64; 40];
    for _ in 0..60 {
        for (j, stroke) in command.iter_mut().enumerate() {
            let (jump, range) = if j < 4 { (5e-4, 3e-3) } else { (2e-5, 1e-4) };
            *stroke = (*stroke + rng.random_range(-jump..jump)).clamp(-range, range);
        }
        try_step(&mut robot, &super::strokes(&command), &mut shares);
    }
    shares.print("40 cables");
    assert_eq!(shares.no_equilibrium, 0);
}

#[test]
fn release_returns_to_rest() {
    let mut rng = rng("release");
    let mut robot = Robot::new(&scenes::robot());
    for _ in 0..20 {
        let command: Vec<f64> = (0..4).map(|_| rng.random_range(-4e-3..4e-3)).collect();
        try_step(&mut robot, &super::strokes(&command), &mut Shares::default());
        robot.go(&[Target::Tension(0.0); 4]);
        // With no force at all, residuals count against those of a mean strain of 1e-7: a bend that moves
        // the tip by a few nanometres.
        let off = super::distance(robot.tip(), robot.twin.tip_of(&robot.twin.rest()));
        assert!(off < super::tolerance(1e-8), "{off} after {command:?}");
    }
}
