//! Synthetic data: the Jacobian next to the tip, and which rollouts are no data.

use hysteron_base::{Channel, Metadata, Recording};
use hysteron_twin::residual::{FollowLimits, PathController};
use hysteron_twin::synthetic::{RecordedStrokes, StrokeSource, SyntheticOutcome, Unphysical, synthesise};
use hysteron_twin::{
    FrictionPoints, PhysicsTwin, Plant, PlantStep, TipResponse, Twin, TwinState, relax_to_equilibrium,
};

use super::{Robot, distance, scenes, strokes, tolerance};

/// Change of a stroke in central differences [m]. Strokes of 4 mm bend the body by about a radian; a thousandth of that
/// changes the Jacobian to second order by 1e-6 of itself.
const STEP: f64 = 4e-6;
/// One per cent: ten times what the adjoint solves leave.
const EXACT: f64 = 0.01;

/// Largest difference of J from central differences at `bent`, over its largest entry. A fresh stepper has the
/// factor of this very shape; `adjoint.rs` tests old ones.
fn error_at(robot: &mut Robot, bent: &[f64]) -> (f64, [Vec<f64>; 3]) {
    robot.stepper = super::stepper_at(&robot.twin, &robot.state);
    robot.go(&strokes(bent));
    let jacobian =
        robot.stepper.tip_response(&robot.twin, FrictionPoints::AsTheyAre).expect("a stiffness").per_stroke;
    let size = jacobian.iter().flatten().fold(0.0f64, |max, value| max.max(value.abs()));
    let mut largest = 0.0f64;
    for k in 0..bent.len() {
        let tip = |by: f64| {
            let mut moved = bent.to_vec();
            moved[k] += by;
            robot.twin.tip_of(&super::after(&robot.twin, &robot.state, &strokes(&moved)))
        };
        let (ahead, behind) = (tip(STEP), tip(-STEP));
        for c in 0..3 {
            let difference = (ahead[c] - behind[c]) / (2.0 * STEP);
            largest = largest.max((difference - jacobian[c][k]).abs() / size);
        }
    }
    println!("Jacobian at {bent:?}: relative error {largest:.1e}");
    assert!(largest > 0.0, "a difference that tests nothing");
    (largest, jacobian)
}

#[test]
fn the_jacobian_is_the_derivative_of_the_tip_by_strokes() {
    for bent in [[1e-3, 0.5e-3, 0.2e-3, 0.3e-3], [4e-3, 1e-3, -3e-3, 1e-3]] {
        let mut robot = Robot::new(&scenes::robot());
        assert!(error_at(&mut robot, &bent).0 < tolerance(EXACT));
    }
}

#[test]
fn a_slack_tendon_moves_nothing() {
    let mut robot = Robot::new(&scenes::robot());
    let (error, jacobian) = error_at(&mut robot, &[4e-3, 0.0, -8e-3, 0.0]);
    assert!(error < tolerance(EXACT));
    assert!(robot.state.tensions[2] == 0.0);
    assert!(jacobian.iter().all(|row| row[2] == 0.0 && row[0] != 0.0), "{jacobian:?}");
}

#[test]
fn where_a_tendon_sticks_its_stroke_moves_the_tip_less() {
    let (mut scene, mesh) = scenes::robot();
    for tendon in &mut scene.tendons {
        tendon.compliance = 2e-4;
    }
    let smooth = (scene.clone(), mesh.clone());
    scene.friction = Some(scenes::STUCK);
    let (mut rough, mut smooth) = (Robot::new(&(scene, mesh)), Robot::new(&smooth));
    // Pulled, and all released by so little that every point sticks.
    let back = [2.97e-3, 0.97e-3, -2e-3, 0.97e-3];
    for robot in [&mut rough, &mut smooth] {
        robot.go(&strokes(&[3e-3, 1e-3, -2e-3, 1e-3]));
        robot.go(&strokes(&back));
    }
    let (error, stuck) = error_at(&mut rough, &back);
    assert!(error < tolerance(EXACT), "{error}");
    let (_, free) = error_at(&mut smooth, &back);
    // Friction along half of the tendon's compliance keeps that half from giving way: less than all, more than nothing.
    let lost =
        (0..3).flat_map(|c| (0..4).map(move |k| (c, k))).map(|(c, k)| (stuck[c][k] - free[c][k]).abs());
    assert!(lost.fold(0.0, f64::max) > 2.0 * error * stuck[0][0].abs(), "{stuck:?} {free:?}");
}

fn commands(n: usize, of: impl Fn(usize) -> [f64; 4]) -> Recording {
    let series = |k: usize| (0..n).map(|i| of(i)[k]).collect();
    let channels = (0..4).map(|k| Channel::new(format!("stroke_{}_m", k + 1), series(k))).collect();
    let time = (0..n).map(|i| 0.01 * i as f64).collect();
    Recording::new(time, channels, Vec::new(), Metadata::default()).expect("a recording")
}

fn outcome(twin: &Twin, commands: &Recording) -> SyntheticOutcome {
    let mut drive = RecordedStrokes::new(twin, commands).expect("strokes of this robot");
    synthesise(twin, &mut PhysicsTwin::new(twin), &mut drive, Metadata::default(), &mut || true)
        .expect("an outcome")
}

#[test]
fn data_is_what_the_twin_does() {
    let (scene, mesh) = scenes::robot();
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let commands = commands(60, |i| [1.0, 0.3, -1.0, -0.3].map(|part| 5e-5 * part * i as f64));
    let SyntheticOutcome::Made(found) = outcome(&twin, &commands) else { panic!("no data") };
    let mut robot = Robot::of(twin);
    let [x, y, z] = found.tip().expect("a tip");
    for i in 0..60 {
        robot.go(&strokes(&commands.strokes().iter().map(|series| series[i]).collect::<Vec<f64>>()));
        // Steps before the first sample leave another history to the fast iteration, and what it leaves over.
        assert!(distance([x[i], y[i], z[i]], robot.tip()) < tolerance(1e-9), "sample {i}");
    }
    assert_eq!(found.strokes(), commands.strokes());
    for name in ["tip_x_per_stroke", "tip_y_per_stroke", "tip_z_per_stroke"] {
        assert_eq!(found.numbered(name, "ratio").len(), 4, "{name}");
    }
}

#[test]
fn what_the_twin_cannot_do_is_no_data() {
    let (mut scene, mesh) = scenes::robot();
    scene.tendons[0].tension.max = 2.0;
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let pulled = commands(100, |i| [1.0, 0.0, -1.0, 0.0].map(|part| 5e-5 * part * i as f64));
    match outcome(&twin, &pulled) {
        SyntheticOutcome::Dropped(i, Unphysical::Overloaded(name)) => {
            assert!((5..100).contains(&i) && name == "tendon_1", "{i} {name}");
        }
        other => panic!("{other:?}"),
    }
}

/// A robot whose first tendon is already pulled at zero stroke of a recording: its tip rests 2 % of its
/// length and more aside.
fn pretensioned() -> Twin {
    let (mut scene, mesh) = scenes::robot();
    scene.tendons[0].zero = 1e-3;
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let rest =
        relax_to_equilibrium(&twin, &mut PhysicsTwin::new(&twin), &[0.0; 4]).expect("an equilibrium").tip;
    let away = distance(rest, twin.tip_of(&twin.rest()));
    assert!(away > 0.02 * scenes::LENGTH, "a rest that tests nothing: {away}");
    twin
}

#[test]
fn a_trajectory_begins_where_the_robot_rests() {
    let twin = pretensioned();
    let rest =
        relax_to_equilibrium(&twin, &mut PhysicsTwin::new(&twin), &[0.0; 4]).expect("an equilibrium").tip;
    let commands = commands(60, |i| [1.0, 0.3, -1.0, -0.3].map(|part| 2e-5 * part * i as f64));
    let SyntheticOutcome::Made(found) = outcome(&twin, &commands) else { panic!("no data") };
    let [x, y, z] = found.tip().expect("a tip");
    // Two equilibria of the same strokes: within what a step of the fast iteration leaves, 1e-6 mm, and some.
    assert!(distance([x[0], y[0], z[0]], rest) < tolerance(1e-8));
    let step = |i: usize| distance([x[i], y[i], z[i]], [x[i - 1], y[i - 1], z[i - 1]]);
    assert!((1..60).all(|i| step(i) < 0.01 * scenes::LENGTH));
}

/// The twin, but for what its tip does by itself.
struct Moved<'a> {
    uncorrected: PhysicsTwin<'a>,
    sample: usize,
    by: fn(usize) -> f64,
}

impl Plant for Moved<'_> {
    fn step(&mut self, primary: &[f64]) -> hysteron_twin::Result<PlantStep> {
        let mut step = self.uncorrected.step(primary)?;
        step.tip[0] += (self.by)(self.sample);
        self.sample += 1;
        Ok(step)
    }

    fn state(&self) -> &TwinState {
        self.uncorrected.state()
    }

    fn tip_response(&mut self, friction: FrictionPoints) -> Option<TipResponse> {
        self.uncorrected.tip_response(friction)
    }
}

#[test]
fn only_a_tip_that_jumps_on_its_way_is_no_data() {
    let twin = pretensioned();
    let commands = commands(60, |i| [1.0, 0.3, -1.0, -0.3].map(|part| 2e-5 * part * i as f64));
    let made = |by| {
        let mut plant = Moved { uncorrected: PhysicsTwin::new(&twin), sample: 0, by };
        let mut drive = RecordedStrokes::new(&twin, &commands).expect("strokes of this robot");
        synthesise(&twin, &mut plant, &mut drive, Metadata::default(), &mut || true).expect("an outcome")
    };
    // A network takes a second to reach its output at rest, 4 mm in all: the robot has rested for long.
    let SyntheticOutcome::Made(found) = made(|sample| 4e-3 * (1.0 - (-0.05 * sample as f64).exp())) else {
        panic!("no data")
    };
    let x = found.tip().expect("a tip")[0];
    let undisturbed = twin.tip_of(&twin.rest())[0];
    assert!((x[0] - undisturbed).abs() > 4e-3, "it has not come to rest: {}", x[0]);
    // A snap by a tenth of the length, long after it has come to rest.
    match made(|sample| if sample > 30 { 0.1 * scenes::LENGTH } else { 0.0 }) {
        SyntheticOutcome::Dropped(i, Unphysical::Jump(by)) => {
            assert!((25..35).contains(&i) && (by / (0.1 * scenes::LENGTH) - 1.0).abs() < 0.2, "{i} {by}");
        }
        other => panic!("{other:?}"),
    }
}

/// A twin whose tendons stick in its first sample: by its Jacobian their strokes have no effect.
struct Sticking<'a> {
    uncorrected: PhysicsTwin<'a>,
    n_asked: usize,
}

impl Plant for Sticking<'_> {
    fn step(&mut self, primary: &[f64]) -> hysteron_twin::Result<PlantStep> {
        self.uncorrected.step(primary)
    }

    fn state(&self) -> &TwinState {
        self.uncorrected.state()
    }

    fn tip_response(&mut self, friction: FrictionPoints) -> Option<TipResponse> {
        self.n_asked += 1;
        let free = self.uncorrected.tip_response(friction)?;
        let per_stroke = if self.n_asked > 1 { free.per_stroke } else { [0; 3].map(|_| vec![0.0; 4]) };
        Some(TipResponse { per_stroke, ..free })
    }
}

#[test]
fn tendons_that_begin_to_slide_are_no_jump() {
    let twin = pretensioned();
    // Bending by a stroke of a tendon at a distance r from the axis moves the tip of a body of length L by L / (2 r) of
    // it: a stroke of 2 r / 100 takes it a hundredth of L. Twice that is certainly above it.
    let stroke = 0.04 * scenes::TENDON_RADIUS;
    let commands = commands(20, |i| [1.0, 0.0, -1.0, 0.0].map(|part| stroke * part * i as f64));
    let mut plant = Sticking { uncorrected: PhysicsTwin::new(&twin), n_asked: 0 };
    let mut drive = RecordedStrokes::new(&twin, &commands).expect("strokes of this robot");
    let found =
        synthesise(&twin, &mut plant, &mut drive, Metadata::default(), &mut || true).expect("an outcome");
    let SyntheticOutcome::Made(found) = found else { panic!("{found:?}") };
    let x = found.tip().expect("a tip")[0];
    assert!((x[1] - x[0]).abs() > 0.01 * twin.cables.longest(), "no test: {} after {}", x[1], x[0]);
    assert!(plant.n_asked == 3, "taken anew once, {} times in all", plant.n_asked);
}

/// A tip that is steered to one place, for as long as it takes.
struct Held<'a>(PathController<'a>);

impl StrokeSource for Held<'_> {
    fn time(&self, i: usize) -> f64 {
        0.01 * i as f64
    }

    fn strokes(&mut self, i: usize, tip: Option<[f64; 3]>, strokes: &mut [f64]) -> bool {
        self.0.step(GOAL, tip, strokes);
        i < 150
    }
}

/// x and y [m].
const GOAL: [f64; 2] = [1.5e-3, -1e-3];

#[test]
fn the_strokes_of_a_steered_tip_lead_there_again() {
    let (scene, mesh) = scenes::robot();
    let twin = Twin::new(&scene, &mesh).expect("a good scene");
    let coordinates = |[a, b]: [f64; 2], strokes: &mut [f64]| strokes.copy_from_slice(&[a, b, -a, -b]);
    let limits = FollowLimits { stroke: 2e-3, rate: 5e-3 };
    let mut held =
        Held(PathController::new(&twin, &coordinates, limits, 0.01).expect("tendons that move the tip"));
    let found = synthesise(&twin, &mut PhysicsTwin::new(&twin), &mut held, Metadata::default(), &mut || true)
        .expect("an outcome");
    let SyntheticOutcome::Made(steered) = found else { panic!("no data") };
    assert_eq!(steered.n_samples(), 150);
    let tip = |recording: &Recording| recording.tip().expect("a tip").map(<[f64]>::to_vec);
    let [x, y, _] = tip(&steered);
    // What is missing shrinks by a factor each sample: nothing but the accuracy of a step is left, some 1e-8 m.
    assert!((x[149] - GOAL[0]).hypot(y[149] - GOAL[1]) < 1e-7, "{} {}", x[149], y[149]);
    let SyntheticOutcome::Made(again) = outcome(&twin, &steered) else { panic!("no data") };
    assert_eq!(tip(&steered), tip(&again));
}
