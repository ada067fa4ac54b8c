//! A tendon on its own: capstan profile, slip fronts, slack, energy.

use hysteron_actuator::law::{Capstan, Law, holding_range};
use hysteron_actuator::{
    Bridge, Drive, DriveLoad, DriveState, FrictionLaw, Gear, Guide, LoopSpec, Motor, Supply, TendonModel,
    TendonSpec, TendonTrial, Winding,
};
use proptest::prelude::*;

const M: usize = 9;
const LENGTH: f64 = 0.01;
/// Stiffness that slack segments keep where statuses cycle, times the largest stretch here [N].
const TRACE: f64 = 2e-6;

fn tendon(friction: f64) -> TendonModel {
    tendon_of(friction, FrictionLaw::Coulomb)
}

fn tendon_of(friction: f64, law: FrictionLaw) -> TendonModel {
    let mut rest_lengths = vec![LENGTH; M];
    rest_lengths[0] = 0.3;
    TendonModel::new(TendonSpec {
        rest_lengths,
        axial_stiffness: 5000.0,
        friction,
        friction_force: 0.01,
        law,
    })
    .unwrap()
}

fn wraps() -> Vec<f64> {
    (0..=M).map(|j| if j == 1 { 0.8 } else { 0.03 + 0.01 * j as f64 }).collect()
}

struct Pulled {
    tendon: TendonModel,
    trial: TendonTrial,
    lengths: Vec<f64>,
    work: f64,
    /// Tensions before the last step.
    before: (Vec<f64>, f64, Vec<f64>),
}

impl Pulled {
    fn new(friction: f64) -> Self {
        let tendon = tendon(friction);
        let lengths = tendon.spec.rest_lengths.clone();
        let before = (vec![0.0; M], 0.0, lengths.clone());
        Self { trial: tendon.trial(), tendon, lengths, work: 0.0, before }
    }

    /// One increment; returns what the guides turned into heat.
    fn step(&mut self, stroke: f64) -> f64 {
        let heat = self.tendon.dissipated;
        self.tendon.solve(&self.lengths, &wraps(), stroke, &mut self.trial);
        self.tendon.commit(&self.trial);
        // Work by the mean of the tensions: exact where they are linear over the step.
        let tensions = &self.tendon.tensions;
        self.work += 0.5 * (tensions[0] + self.before.0[0]) * (stroke - self.before.1);
        for i in 0..M {
            self.work += 0.5 * (tensions[i] + self.before.0[i]) * (self.lengths[i] - self.before.2[i]);
        }
        self.before = (tensions.clone(), stroke, self.lengths.clone());
        self.tendon.dissipated - heat
    }
}

/// One law, once around a guide of a tendon of the virtual rig and once in the gear of a motor: pulled past every other guide, the tension
/// before the guide is the motor's torque that just drives a joint under the tension behind it.
#[test]
fn one_law_holds_as_much_in_a_joint_as_at_a_guide() {
    let (friction, constant, wrap) = (0.3, 0.01, 0.8);
    let mut pulled = Pulled::new(friction);
    (1..=400).for_each(|k| {
        pulled.step(1e-5 * f64::from(k));
    });
    let [before, behind] = [pulled.tendon.tensions[0], pulled.tendon.tensions[1]];
    assert!(behind > 1.0, "{behind}");
    let law = Law::Capstan(Capstan { wrap });
    let parameters = [friction, constant];
    let range = holding_range(&law, &parameters, behind);
    // The tendon is balanced to rounding of its stiffness.
    assert!((range.drive.unwrap() - before).abs() < 1e-8 * before, "{range:?} {before}");
    // A motor with that law in its gear is at rest with slightly less torque, and turns with slightly more.
    let gear = Gear { armature: 1e-3, backlash: 0.0, law, friction: parameters.to_vec() };
    let motor = Motor::new(1.0, 1.0, 1.0);
    let supply = Supply { voltage: before, resistance: 0.0 };
    let drive = Drive { motor, supply, winding: Winding::COLD, gear, position_loop: LoopSpec::XL430 };
    let turned = |duty: f64| {
        let mut state = DriveState::resting(0.0, 25.0);
        drive.step(&mut state, Bridge::Driven(duty), DriveLoad::torque(-behind), 1e-3);
        state.angle
    };
    assert_eq!(turned(1.0 - 1e-6), 0.0);
    assert!(turned(1.0 + 1e-6) > 0.0);
}

#[test]
fn monotone_pull_has_the_capstan_profile() {
    let (mut pulled, friction) = (Pulled::new(0.25), 0.25);
    for k in 1..=50 {
        pulled.step(0.06e-3 * k as f64);
    }
    let tensions = &pulled.tendon.tensions;
    assert!(tensions[0] > 20.0, "{tensions:?}");
    let wraps = wraps();
    for i in 1..M {
        assert_eq!(pulled.tendon.guides[i], Guide::Pulls);
        // The part of the friction that needs no tension is compounded the same way.
        let (a, b) = (tensions[i - 1], tensions[i]);
        let factor = f64::tanh(0.5 * friction * wraps[i]);
        assert!(((1.0 - factor) * a - (1.0 + factor) * b - 0.01).abs() < 1e-9);
    }
    let total: f64 = wraps[1..M].iter().sum();
    let expected = tensions[0] * f64::exp(-friction * total);
    assert!((tensions[M - 1] - expected).abs() < 0.01 * M as f64, "{} {expected}", tensions[M - 1]);
}

#[test]
fn after_reversal_the_slip_front_moves_from_the_pulley() {
    let mut pulled = Pulled::new(0.25);
    for k in 1..=50 {
        pulled.step(0.06e-3 * k as f64);
    }
    let mut reached = 0;
    for k in 1..=400 {
        pulled.step(3e-3 - 0.006e-3 * k as f64);
        let guides = &pulled.tendon.guides[1..M];
        let front = guides.iter().take_while(|&&guide| guide == Guide::Releases).count();
        assert!(front >= reached, "{guides:?}");
        assert!(guides[front..].iter().all(|&guide| guide == Guide::Sticks), "{guides:?}");
        reached = front;
        if front == M - 1 {
            // A front that crosses guide by guide leaves the far end at its old tension until then.
            assert!(k > 5, "all guides slipped after {k} steps");
            return;
        }
    }
    panic!("the front stopped at guide {reached}");
}

#[test]
fn slack_tendon_carries_exactly_nothing() {
    let mut pulled = Pulled::new(0.25);
    pulled.step(1e-3);
    // What friction holds behind the guides goes when the body eats the slack.
    pulled.step(-1e-3);
    assert_eq!(pulled.tendon.tensions[0], 0.0);
    pulled.lengths.iter_mut().for_each(|length| *length *= 0.9);
    pulled.step(-1e-3);
    assert_eq!(pulled.tendon.tensions, vec![0.0; M]);
    assert!(pulled.tendon.slips.iter().all(|slip| slip.is_finite()));
}

#[test]
fn work_over_a_closed_cycle_is_heat() {
    let mut misses = Vec::new();
    for n in [200, 400] {
        let mut pulled = Pulled::new(0.2);
        let (mut heat, mut start) = (0.0, 0.0);
        let mut stored = 0.0;
        for k in 0..=3 * n {
            let phase = std::f64::consts::TAU * k as f64 / n as f64;
            let increment = pulled.step(1.5e-3 * (1.0 - phase.cos()) + 0.5e-3);
            assert!(increment >= -1e-15);
            if k == 2 * n {
                (start, stored, heat) = (pulled.work, pulled.tendon.stored_energy(), 0.0);
            } else {
                heat += increment;
            }
        }
        let rest = pulled.tendon.stored_energy() - stored;
        let miss = (pulled.work - start - rest - heat) / heat;
        assert!(heat > 1e-3, "{heat}");
        misses.push(miss.abs());
    }
    // Slip is integrated by its end values: first order.
    assert!(misses[1] < 0.02 && misses[1] < 0.7 * misses[0], "{misses:?}");
}

#[test]
fn tangent_is_the_derivative_of_the_tensions() {
    // Not between: guides that have slid and not yet slid back are on the edge of their cone.
    for (stroke, back) in [(2e-3, -0.1e-3), (2e-3, 1.2e-3)] {
        let mut pulled = Pulled::new(0.3);
        for k in 1..=20 {
            pulled.step(stroke * k as f64 / 20.0);
        }
        let stroke = stroke - back;
        pulled.tendon.solve(&pulled.lengths, &wraps(), stroke, &mut pulled.trial);
        pulled.trial.tangent(&pulled.tendon);
        let tangent = pulled.trial.tangent.clone();
        let h = 1e-9;
        for column in 0..M {
            let mut shifted = |sign: f64| {
                let mut lengths = pulled.lengths.clone();
                lengths[column] += sign * h;
                pulled.tendon.solve(&lengths, &wraps(), stroke, &mut pulled.trial);
                pulled.trial.tensions.clone()
            };
            let (high, low) = (shifted(1.0), shifted(-1.0));
            for i in 0..M {
                let difference = (high[i] - low[i]) / (2.0 * h);
                let miss = (tangent[i * M + column] - difference).abs();
                assert!(
                    miss < 1e-4 * 5e5,
                    "{back} [{i}][{column}]: {} {difference}",
                    tangent[i * M + column]
                );
            }
        }
    }
}

#[test]
fn tendon_rejects_guides_without_friction_force() {
    let spec = TendonSpec {
        rest_lengths: vec![1.0, 1.0],
        axial_stiffness: 1.0,
        friction: 0.1,
        friction_force: 0.0,
        law: FrictionLaw::Coulomb,
    };
    let reject = |change: fn(&mut TendonSpec)| {
        let mut spec = TendonSpec { friction_force: 0.1, ..spec.clone() };
        change(&mut spec);
        TendonModel::new(spec).unwrap_err().place
    };
    assert_eq!(reject(|spec| spec.friction_force = 0.0), "tendon.friction_force");
    assert_eq!(reject(|spec| spec.friction = -0.1), "tendon.friction");
    assert_eq!(reject(|spec| spec.axial_stiffness = f64::NAN), "tendon.axial_stiffness");
    assert_eq!(reject(|spec| spec.rest_lengths[1] = 0.0), "tendon.rest_lengths[1]");
    assert_eq!(reject(|spec| spec.rest_lengths.truncate(1)), "tendon.rest_lengths");
}

proptest! {
    /// Random pulls and random bodies: balance at every guide, heat never negative, sweeps never needed twice.
    #[test]
    fn guides_only_ever_dissipate(
        steps in prop::collection::vec((-1.5e-3..3e-3f64, prop::array::uniform9(-0.03..0.03f64)), 1..30),
        friction in 0.0..0.8f64,
    ) {
        let mut pulled = Pulled::new(friction);
        for (stroke, strains) in steps {
            for i in 1..M {
                pulled.lengths[i] = LENGTH * (1.0 + strains[i]);
            }
            let old = pulled.tendon.slips.clone();
            let heat = pulled.step(stroke);
            prop_assert!(heat >= -1e-12, "{heat}");
            let tendon = &pulled.tendon;
            for j in 1..M {
                let (a, b) = (tendon.tensions[j - 1], tendon.tensions[j]);
                let bound = 0.01 + f64::tanh(0.5 * friction * wraps()[j]) * (a + b);
                prop_assert!((a - b).abs() <= bound + TRACE, "guide {}: {} {} {}", j, a, b, bound);
                let slip = tendon.slips[j] - old[j];
                if slip.abs() > 1e-12 {
                    prop_assert!((a - b - bound.copysign(slip)).abs() < TRACE, "guide {}: {} {} {}", j, a, b, slip);
                }
            }
        }
    }
}

/// A random walk of pulled length and tendon lengths; after each step the friction of guide j must be within
/// its bound, and the work done on the guides must not fall below what their elements can hold.
fn wander(law: FrictionLaw, friction: f64, seed: u64) -> (TendonModel, usize) {
    let mut tendon = tendon_of(friction, law);
    let mut trial = tendon.trial();
    let mut state = seed;
    let mut draw = || {
        // Knuth's MMIX generator: enough to move a tendon about.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let rest = tendon.spec.rest_lengths.clone();
    let (mut stroke, mut lengths, mut n_stuck) = (1e-3, rest.clone(), 0);
    for _ in 0..2000 {
        stroke = f64::clamp(stroke + 1e-3 * draw(), -2e-3, 5e-3);
        for (length, rest) in lengths.iter_mut().zip(&rest) {
            *length = f64::clamp(*length + 5e-5 * draw(), rest - 2e-4, rest + 2e-4);
        }
        let turns = wraps();
        tendon.solve(&lengths, &turns, stroke, &mut trial);
        n_stuck += usize::from(trial.has_cycled);
        for j in 1..M {
            let (before, after) = (trial.tensions[j - 1], trial.tensions[j]);
            let bound = tendon.spec.friction_force
                + hysteron_actuator::capstan_factor(friction, turns[j]) * (before + after);
            // Rounding of a stretch of a metre's thousandth, times the stiffness.
            assert!((before - after).abs() <= bound + 1e-6, "{law:?}: guide {j}: {before} {after} {bound}");
        }
        tendon.commit(&trial);
    }
    (tendon, n_stuck)
}

#[test]
fn friction_that_gives_way_finds_its_slips_wherever_the_tendon_goes() {
    for law in [
        FrictionLaw::Dahl(5e-5),
        FrictionLaw::Prandtl(5e-5),
        FrictionLaw::Dahl(1e-3),
        FrictionLaw::Prandtl(1e-3),
    ] {
        for seed in 1..=4 {
            let (tendon, n_stuck) = wander(law, 0.3, seed);
            assert_eq!(n_stuck, 0, "{law:?}, seed {seed}: steps without a solution");
            assert!(tendon.dissipated > 0.0, "{law:?}: {} J", tendon.dissipated);
        }
    }
}

#[test]
fn friction_that_gives_way_at_once_is_coulombs() {
    // Slips of millimetres against a hundredth of a micrometre.
    let pulled = |law| {
        let mut tendon = tendon_of(0.3, law);
        let (mut trial, lengths) = (tendon.trial(), tendon.spec.rest_lengths.clone());
        for stroke in [1e-3, 3e-3, 2.5e-3, 0.5e-3, 2e-3] {
            tendon.solve(&lengths, &wraps(), stroke, &mut trial);
            tendon.commit(&trial);
        }
        tendon.tensions
    };
    let coulomb = pulled(FrictionLaw::Coulomb);
    for law in [FrictionLaw::Dahl(1e-8), FrictionLaw::Prandtl(1e-8)] {
        for (found, expected) in pulled(law).iter().zip(&coulomb) {
            // What a slip of 1e-8 m is worth in tension: 5 mN, at each of eight guides.
            assert!((found - expected).abs() < 0.05, "{law:?}: {found} {expected}");
        }
    }
}

#[test]
fn tangent_of_friction_that_gives_way_is_the_derivative() {
    for law in [FrictionLaw::Dahl(2e-4), FrictionLaw::Prandtl(2e-4)] {
        let mut tendon = tendon_of(0.3, law);
        let (mut trial, mut lengths) = (tendon.trial(), tendon.spec.rest_lengths.clone());
        for stroke in [1e-3, 3e-3] {
            tendon.solve(&lengths, &wraps(), stroke, &mut trial);
            tendon.commit(&trial);
        }
        let mut at = |lengths: &[f64]| {
            tendon.solve(lengths, &wraps(), 3.1e-3, &mut trial);
            (trial.tensions.clone(), trial.clone())
        };
        let (_, mut here) = at(&lengths);
        here.tangent(&tendon);
        let step = 1e-9;
        for column in 0..M {
            lengths[column] += step;
            let (ahead, _) = at(&lengths);
            lengths[column] -= 2.0 * step;
            let (behind, _) = at(&lengths);
            lengths[column] += step;
            for row in 0..M {
                let difference = (ahead[row] - behind[row]) / (2.0 * step);
                let exact = here.tangent[row * M + column];
                // Stiffness of a segment: 5000 N over 10 mm; tensions are known to 1e-9 N.
                assert!(
                    (exact - difference).abs() < 1e-4 * 5e5,
                    "{law:?}: {row} {column} {exact} {difference}"
                );
            }
        }
    }
}
