//! Motion in time: order of the integrators, energy, friction, stops.

use hysteron_arm_dynamics::*;

use hysteron_arm_fixtures::robots::model;

fn arm() -> Model {
    model("three_link")
}

/// State after a second of free motion from rest in steps of `h`.
fn fall(model: &Model, integrator: Integrator, steps: usize) -> Vec<f64> {
    let n = model.n_joints();
    let mut stepper = ArmStepper::new(model, integrator, (1.0 / steps as f64, 1), 0, 0.0);
    let (mut q, mut dq, mut tape) = (vec![0.4; n], vec![0.0; n], Vec::new());
    for _ in 0..steps {
        stepper.step(model, [&mut q, &mut dq], &vec![0.0; n], &[], &mut tape);
        tape.clear();
    }
    [q, dq].concat()
}

#[test]
fn integrators_converge_with_their_order() {
    let model = arm();
    let truth = fall(&model, Integrator::RungeKutta4, 20_000);
    let error = |integrator, steps| {
        let state = fall(&model, integrator, steps);
        state.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    for (integrator, order, steps) in
        [(Integrator::SemiImplicitEuler, 1.0, 2000), (Integrator::RungeKutta4, 4.0, 1600)]
    {
        let measured = (error(integrator, steps) / error(integrator, 2 * steps)).log2();
        assert!((measured - order).abs() < 0.25, "{integrator:?}: {measured}");
    }
}

fn energy(model: &Model, q: &[f64], dq: &[f64]) -> f64 {
    let mut data = Data::new(model, 0.0);
    kinetic_energy(model, &mut data, q, dq) + potential_energy(model, &mut data, q)
}

#[test]
fn energy_of_free_motion_is_kept() {
    let model = arm();
    let state = fall(&model, Integrator::RungeKutta4, 4000);
    let (before, after) = (energy(&model, &[0.4; 3], &[0.0; 3]), energy(&model, &state[..3], &state[3..]));
    // Fourth order: 1e-13 of the energy at this step, and the rounding of 4000 steps.
    assert!((after - before).abs() < 1e-9 * before.abs(), "{before} {after}");
}

/// The arm with friction in every joint, and its range as wide as it likes.
fn rubbing(friction: f64, damping: f64) -> Model {
    let text = std::fs::read_to_string(hysteron_arm_fixtures::robots::file("three_link")).unwrap();
    let dynamics = format!("<dynamics friction=\"{friction}\" damping=\"{damping}\"/></joint>");
    let mut joints = text.split("</joint>").collect::<Vec<_>>();
    let last = joints.pop().unwrap();
    Model::from_urdf(&(joints.join(&dynamics) + &dynamics + last), "rubbing.urdf").unwrap()
}

#[test]
fn a_loaded_arm_stays_to_the_last_bit_and_releases_at_the_bound() {
    let friction = 1.0;
    let model = rubbing(friction, 0.0);
    let start = [0.9, 0.7, -0.4];
    let mut weight = [0.0_f64; 3];
    gravity_torque(&model, &mut Data::new(&model, 0.0), &start, &mut weight);
    assert!(weight.iter().any(|w| w.abs() > 0.1), "nothing to hold: {weight:?}");
    // Torques that leave gravity all but a part of the bound.
    for (part, moves) in [(0.0, false), (0.999_999, false), (1.000_001, true)] {
        let mut simulator = Simulator::new(&model, 2e-3, 2, EndStops::Rigid);
        let (mut q, mut dq) = (start.to_vec(), vec![0.0; 3]);
        let tau = [weight[0] + part * friction, weight[1] - 0.5 * friction, weight[2] + 0.3 * friction];
        for _ in 0..1000 {
            simulator.step([&mut q, &mut dq], &tau, &[]);
            if !moves {
                assert!(q == start && dq == [0.0; 3], "{part}: {q:?} {dq:?}");
            }
        }
        assert_eq!(q[0] != start[0], moves, "{part}: {q:?}");
    }
}

#[test]
fn friction_takes_energy_and_brings_the_arm_to_rest() {
    let model = rubbing(0.2, 0.02);
    let mut simulator = Simulator::new(&model, 1e-3, 1, EndStops::None);
    let (mut q, mut dq) = (vec![0.5, -0.4, 0.9], vec![2.0, -1.0, 3.0]);
    let mut last = energy(&model, &q, &dq);
    for _ in 0..20_000 {
        simulator.step([&mut q, &mut dq], &[0.0; 3], &[]);
        let now = energy(&model, &q, &dq);
        // The integrator is symplectic of first order: its energy swings by h², here below 1e-5 J in a step.
        assert!(now <= last + 1e-5, "{now} {last}");
        last = now;
    }
    assert_eq!(dq, [0.0; 3]);
}

#[test]
fn friction_is_coulombs_law() {
    // One joint without gravity: v falls by f h / I in every step, and stops exactly.
    let model = Model::builtin("scara").unwrap().with_locked(&[("joint_2", 0.0)]).unwrap();
    let mut mass = [0.0];
    mass_matrix(&model, &mut Data::new(&model, 0.0), &[0.0], &mut mass);
    let text = std::fs::read_to_string(hysteron_arm_fixtures::robots::file("scara")).unwrap();
    let text = text.replacen("</joint>", "<dynamics friction=\"0.5\"/></joint>", 1);
    let model = Model::from_urdf(&text, "scara").unwrap().with_locked(&[("joint_2", 0.0)]).unwrap();
    let mut simulator = Simulator::new(&model, 1e-3, 1, EndStops::Rigid);
    let (mut q, mut dq) = (vec![0.0], vec![1.0]);
    let mut expected = 1.0;
    for _ in 0..3000 {
        simulator.step([&mut q, &mut dq], &[0.0], &[]);
        expected = f64::max(expected - 0.5 * 1e-3 / mass[0], 0.0);
        assert!((dq[0] - expected).abs() < 1e-12, "{dq:?} {expected}");
    }
    assert_eq!(dq[0], 0.0);
}

#[test]
fn joints_stop_at_the_ends_of_their_ranges() {
    let model = arm();
    let mut simulator = Simulator::new(&model, 1e-3, 1, EndStops::Rigid);
    let (mut q, mut dq) = (vec![0.1, 0.0, 0.0], vec![0.0; 3]);
    for _ in 0..20_000 {
        simulator.step([&mut q, &mut dq], &[0.0; 3], &[]);
        assert!(q.iter().all(|q| (-2.5..=2.5).contains(q)), "{q:?}");
    }
    // Damped by nothing but the stops, the first joint falls to one side.
    assert!(q[0].abs() <= 2.5 && q.iter().all(|x| x.is_finite()));
}

/// A gripper of two fingers on a hinge, the second of which follows the first, mirrored and half a centimetre off.
pub fn gripper(friction: f64) -> Model {
    let finger = |name: &str, range: &str, follows: &str| {
        format!(
            r#"<link name="{name}"><inertial><origin xyz="0.1 0.02 0.03"/><mass value="0.3"/>
            <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
            <joint name="{name}_joint" type="prismatic"><parent link="hand"/><child link="{name}"/><axis xyz="0 1 1"/>
            <limit {range}/><dynamics damping="0.4" friction="{friction}"/>{follows}</joint>"#
        )
    };
    let left = finger("left", r#"lower="-0.05" upper="0.05""#, "");
    let right = finger(
        "right",
        r#"lower="-0.02" upper="1""#,
        r#"<mimic joint="left_joint" multiplier="-2" offset="0.005"/>"#,
    );
    Model::from_urdf(
        &format!(
            r#"<robot name="gripper"><link name="base"/><link name="hand"><inertial><mass value="1"/>
            <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
            <joint name="turn" type="continuous"><parent link="base"/><child link="hand"/><axis xyz="1 0 0"/></joint>{left}{right}</robot>"#
        ),
        "gripper.urdf",
    )
    .unwrap()
}

#[test]
fn a_follower_moves_with_its_leader_and_takes_part_in_the_energy() {
    let model = gripper(0.0);
    let mut simulator = Simulator::new(&model, 1e-3, 4, EndStops::None);
    let (mut q, mut dq) = (vec![0.7, 0.01, 9.0], vec![1.5, -0.2, 0.0]);
    let torque = [0.1, 0.8, -0.3];
    simulator.step([&mut q, &mut dq], &torque, &[]);
    let (mut before, mut work) = (energy(&model, &q, &dq), 0.0);
    for _ in 0..300 {
        let old = q.clone();
        simulator.step([&mut q, &mut dq], &torque, &[]);
        assert_eq!((q[2], dq[2]), (-2.0 * q[1] + 0.005, -2.0 * dq[1]));
        let taken: f64 =
            (0..3).map(|i| (torque[i] - if i > 0 { 0.4 * dq[i] } else { 0.0 }) * (q[i] - old[i])).sum();
        work += taken;
    }
    let after = energy(&model, &q, &dq);
    before += work;
    // First order in the substep of 0.25 ms, over 0.3 s of a motion with energies of some joules.
    assert!((after - before).abs() < 5e-3, "{after} {before}");
}

#[test]
fn lagranges_equations_of_the_coupled_gripper() {
    // q = G u + o: Gᵀ (M G u'' + c + g) = Gᵀ τ, solved here by hand from M and the bias torque of the uncoupled arm.
    let model = gripper(0.0);
    let (mut q, mut dq) = (vec![0.7, 0.01, -0.015], vec![1.5, -0.2, 0.4]);
    let (mut mass, mut bias, mut data) = (vec![0.0; 9], vec![0.0; 3], Data::new(&model, 0.0));
    mass_matrix(&model, &mut data, &q, &mut mass);
    bias_torque(&model, &mut data, [&q, &dq], &[], &mut bias);
    let g = [[1.0, 0.0], [0.0, 1.0], [0.0, -2.0]];
    let (h, tau, mut a, mut b) = (1e-4, [0.1, 0.8, -0.3], [[0.0; 2]; 2], [0.0; 2]);
    let damping = [0.0, 0.4, 0.4];
    for i in 0..3 {
        for u in 0..2 {
            b[u] += g[i][u] * (tau[i] - bias[i] - damping[i] * dq[i]);
            for w in 0..2 {
                let implicit = |j: usize| if i == j { h * damping[i] } else { 0.0 };
                a[u][w] += (0..3).map(|j| g[i][u] * (mass[3 * i + j] + implicit(j)) * g[j][w]).sum::<f64>();
            }
        }
    }
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    let expected = [
        dq[0] + h * (a[1][1] * b[0] - a[0][1] * b[1]) / determinant,
        dq[1] + h * (a[0][0] * b[1] - a[1][0] * b[0]) / determinant,
    ];
    Simulator::new(&model, h, 1, EndStops::Rigid).step([&mut q, &mut dq], &tau, &[]);
    for u in 0..2 {
        assert!((dq[u] - expected[u]).abs() < 1e-13, "{dq:?} {expected:?}");
    }
}

#[test]
fn friction_and_range_of_a_follower_hold_its_leader() {
    let model = gripper(0.5);
    let start = [0.0, 0.01, -0.015];
    let mut weight = [0.0; 3];
    gravity_torque(&model, &mut Data::new(&model, 0.0), &start, &mut weight);
    // The leader's own friction, and that of its follower at twice the speed: 0.5 + 2 * 0.5 N.
    for (force, moves) in [(1.499_999, false), (1.500_001, true)] {
        let mut simulator = Simulator::new(&model, 1e-3, 1, EndStops::Rigid);
        let (mut q, mut dq) = (start.to_vec(), vec![0.0; 3]);
        for _ in 0..100 {
            simulator.step([&mut q, &mut dq], &[weight[0], weight[1] + force, weight[2]], &[]);
        }
        assert_eq!(q[1] != start[1], moves, "{force}: {q:?}");
    }
    // The follower ends at -0.02 m: its leader at 0.0125 m, before the end of its own range.
    let mut simulator = Simulator::new(&model, 1e-3, 1, EndStops::Rigid);
    let (mut q, mut dq) = (start.to_vec(), vec![0.0; 3]);
    for _ in 0..2000 {
        simulator.step([&mut q, &mut dq], &[weight[0], 20.0, 0.0], &[]);
    }
    assert!((q[1] - 0.0125).abs() < 1e-15 && (q[2] + 0.02).abs() < 1e-15 && dq[1] == 0.0, "{q:?} {dq:?}");
}
