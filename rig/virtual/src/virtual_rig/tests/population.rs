//! The wide population: every quantity within its range, and every new effect against a closed form.

use super::super::body::BodySpec;
use super::super::{Population, Ranges, SimulatedRig, VirtualRobot, rig_file};
use super::bench::Bench;
use super::{body, body_of_law, spec};
use hysteron_actuator::FrictionLaw;
use hysteron_rig::calibration::calibrate;
use hysteron_rig::config::RigConfig;
use std::path::Path;

fn wide() -> (VirtualRobot, Ranges) {
    let robot = VirtualRobot::preset("wide").unwrap();
    let Population::Wide(ranges) = robot.population else { panic!("{:?}", robot.population) };
    (robot, ranges)
}

/// Fails unless a value lies in its range, but for rounding; what has been seen of it grows.
fn within(what: &str, value: f64, [min, max]: [f64; 2], seen: &mut [f64; 2]) {
    let room = 1e-9 * (max - min);
    assert!((min - room..=max + room).contains(&value), "{what}: {value} of {min} to {max}");
    let at = (value - min) / (max - min);
    *seen = [seen[0].min(at), seen[1].max(at)];
}

#[test]
fn members_lie_within_the_ranges_and_fill_them() {
    let (middle, ranges) = wide();
    let mut seen = [[1.0, 0.0]; 14];
    let mut laws = [0; 2];
    let mut down = [[0.0f64; 2]; 3];
    for seed in 0..200 {
        let robot = middle.draw(seed);
        assert_eq!(robot, middle.draw(seed));
        assert_ne!(robot.body, middle.draw(seed + 1).body);
        let (body, tendons, servos) = (&robot.body, &robot.tendons, &robot.servos);
        let mut next = seen.iter_mut();
        let mut check = |what: &str, values: &[f64], range: [f64; 2]| {
            let seen = next.next().unwrap();
            values.iter().for_each(|value| within(what, *value, range, seen));
        };
        check("stiffness", &[body.axial_stiffness / middle.body.axial_stiffness], ranges.stiffness);
        let [b1, b2] = body.bending_stiffness;
        check("bending ratio", &[b1 / b2], ranges.bending_ratio);
        check("section", &body.section_factors, ranges.section);
        check("curvature", &body.natural_curvature, ranges.natural_curvature);
        check("creep", &[body.prony.weights[0] / middle.body.prony.weights[0]], ranges.creep);
        let offsets: Vec<f64> = tendons.offsets.iter().flatten().copied().collect();
        check("offset", &offsets, ranges.guide_offset);
        let turned: Vec<f64> =
            tendons.angles.iter().zip(&middle.tendons.angles).map(|(a, b)| a - b).collect();
        check("angle", &turned, ranges.guide_angle);
        check("friction", &[tendons.friction / middle.tendons.friction], ranges.friction);
        check("presliding", &[tendons.law.presliding()], ranges.presliding);
        check("play", &[tendons.play], ranges.play);
        let pulleys: Vec<f64> = servos.true_radii.iter().map(|r| r / servos.pulley_radius).collect();
        check("pulley", &pulleys, ranges.pulley);
        let [breakaway, before] = [&robot, &middle].map(|robot| robot.servos.spec.friction.breakaway);
        check("gears", &[breakaway / before], ranges.servo_friction);
        let stiffness = tendons.axial_stiffness / middle.tendons.axial_stiffness;
        check("tendon stiffness", &[stiffness], ranges.tendon_stiffness);
        check("tracker", &robot.tracker.robot_position, ranges.tracker_position);
        let [slackest, tightest] = [f64::min, f64::max]
            .map(|most: fn(f64, f64) -> f64| tendons.zero_errors.iter().copied().reduce(most).unwrap());
        assert!(
            slackest <= -ranges.slack_tendon[0] && tightest <= ranges.zero_error[1],
            "{:?}",
            tendons.zero_errors
        );
        laws[usize::from(matches!(tendons.law, FrictionLaw::Dahl(_)))] += 1;
        for (ends, part) in down.iter_mut().zip(body.gravity.map(|g| g / 9.81)) {
            *ends = [ends[0].min(part), ends[1].max(part)];
        }
        let size = body.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        assert!((size - 9.81).abs() < 1e-9, "{size}");
    }
    // 200 even draws leave a gap of more than 5 % at an end once in 28 000 times.
    assert!(seen.iter().all(|[low, high]| *low < 0.05 && *high > 0.95), "{seen:?}");
    // A fair coin is off by four deviations once in 16 000 times.
    assert!(laws.iter().all(|n| (72..=128).contains(n)), "{laws:?}");
    assert!(down.iter().all(|[low, high]| *low < -0.9 && *high > 0.9), "{down:?}");
}

#[test]
fn members_calibrate_and_move_in_balance() {
    let (middle, _) = wide();
    for seed in [1, 2, 3] {
        let robot = middle.draw(seed);
        let rig = RigConfig::from_toml(&rig_file(&robot), Path::new("")).unwrap();
        // The rig file knows the drawing alone.
        assert!(rig.tendons.iter().all(|tendon| tendon.pulley_radius == 0.01));
        let mut hardware = SimulatedRig::new(&robot, &rig, seed);
        let found = calibrate(&mut hardware, &rig, "today".into(), &|| false, &mut |_| {}).unwrap();
        assert!(found.registration.is_some());
        let mut bench = Bench::new(&robot, seed);
        let tips = bench.circle(4e-3, 6.0);
        assert!(tips.iter().all(|tip| tip.iter().all(|x| x.is_finite())));
        let counts = bench.world.balance_counts();
        assert_eq!(counts.failures, 0, "member {seed}: {counts:?}");
    }
}

#[test]
fn a_hanging_body_stretches_and_a_level_one_sags_by_the_closed_forms() {
    let (weight, length) = (1e-2, 0.08);
    let tip = |gravity: [f64; 3], n: usize| {
        let mut spec = spec();
        (spec.n_sections, spec.section_factors) = (n, vec![1.0; n]);
        (spec.mass, spec.gravity) = (weight / 9.81, gravity.map(|g| 9.81 * g));
        spec.guides.clear();
        let (bending, stretch) = (spec.stiffness[0], spec.stiffness[3]);
        let mut body = body(spec, 0.0, 0.01);
        assert_eq!(body.step(&[], 1.0).failures, 0);
        (body.tip().1, bending, stretch)
    };
    // Hanging: W L/(2 E A), which weights at the section ends give exactly; standing on it: the same the other way.
    for sign in [1.0, -1.0] {
        let (found, _, stretch) = tip([0.0, 0.0, sign], 8);
        let exact = sign * weight * length / (2.0 * stretch);
        assert!(((found[2] - length) / exact - 1.0).abs() < 1e-6, "{} {exact}", found[2] - length);
    }
    // Level: W L³/(8 E I), up to the square of the slope: what weights at the ends add, sections of constant
    // curvature take away.
    for n in [8, 16] {
        let (found, bending, _) = tip([0.0, 1.0, 0.0], n);
        let exact = weight * length.powi(3) / (8.0 * bending);
        println!("sag of a level body of {n} sections: off by {:.1e}", found[1] / exact - 1.0);
        assert!((found[1] / exact - 1.0).abs() < (2.0 * exact / length).powi(2), "{} {exact}", found[1]);
    }
}

#[test]
fn sections_of_their_own_stiffness_bend_and_stretch_by_their_sum() {
    let factors = vec![0.7, 0.8, 1.1, 1.3, 0.9, 1.2, 1.0, 0.6];
    let (force, of_body) = (1e-3, spec());
    let (part, [bending, _, _, stretch]) = (of_body.length / 8.0, of_body.stiffness);
    let tip = |tip_load: [f64; 3]| {
        let spec = BodySpec { section_factors: factors.clone(), tip_load, guides: Vec::new(), ..spec() };
        let mut body = body(spec, 0.0, 0.01);
        assert_eq!(body.step(&[], 1.0).failures, 0);
        body.tip().1
    };
    // A small force across bends section s by P (L - x) over its own stiffness, x its middle, and the tip goes by
    // that times the same lever, up to the square of the slope; one along stretches each by P/(E A).
    let lever = |s: usize| (7.5 - s as f64) * part;
    let bent: f64 = (0..8).map(|s| force * part * lever(s).powi(2) / (bending * factors[s])).sum();
    let stretched: f64 = (0..8).map(|s| force * part / (stretch * factors[s])).sum();
    let uniform = force * of_body.length.powi(3) / (3.0 * bending);
    assert!((bent / uniform - 1.0).abs() > 0.02, "factors that test nothing");
    let across = tip([force, 0.0, 0.0])[0];
    assert!((across / bent - 1.0).abs() < (2.0 * bent / of_body.length).powi(2), "{across} {bent}");
    let along = tip([0.0, 0.0, force])[2] - of_body.length;
    assert!((along / stretched - 1.0).abs() < 1e-6, "{along} {stretched}");
}

#[test]
fn friction_that_gives_way_comes_to_the_capstan_and_holds_less_before() {
    let pull = |law: FrictionLaw, stroke: f64| {
        let mut body = body_of_law(spec(), 0.3, 1e-4, law);
        for i in 1..=200 {
            body.step(&[stroke * f64::from(i) / 200.0, -0.05, -0.05, -0.05], 0.01);
        }
        let wrap: f64 = body.work.wraps[0][1..9].iter().sum();
        (body.tendons[0].tensions.clone(), wrap)
    };
    for law in [FrictionLaw::Dahl(2e-5), FrictionLaw::Prandtl(2e-5)] {
        let (tensions, wrap) = pull(law, 5e-3);
        let expected = tensions[0] * f64::exp(-0.3 * wrap);
        // The last guides have slid by some of the slips over which they give way: e^-10 is left of Dahl's.
        assert!((tensions[8] - expected).abs() < 5e-3 * tensions[0], "{law:?}: {} {expected}", tensions[8]);
    }
    // Ten times the length: the tendon has hardly slid by it, and the tension goes through.
    let (tensions, wrap) = pull(FrictionLaw::Dahl(5e-2), 5e-3);
    let lost = 1.0 - tensions[8] / tensions[0];
    assert!(lost < 0.3 * (1.0 - f64::exp(-0.3 * wrap)) && lost > 0.0, "{lost}");
}

#[test]
fn pulleys_wind_by_their_true_radius_and_zeros_move_once() {
    let mut robot = VirtualRobot::preset("typical").unwrap();
    robot.tendons.play = 0.0;
    robot.servos.true_radii = vec![9.7e-3, 10.3e-3, 10e-3, 9.9e-3];
    robot.tendons.zero_errors = vec![0.4e-3, -0.7e-3, 0.0, 0.2e-3];
    let mut bench = Bench::new(&robot, 1);
    bench.rest(0.5);
    let start = bench.world.clone();
    for i in 0..=300 {
        bench.command(&[1e-5 * f64::from(i), -1e-5 * f64::from(i), 0.0, 0.0]);
    }
    bench.world.advance(1.0);
    for k in 0..2 {
        let turned = bench.world.servo(k).state.angle - start.servo(k).state.angle;
        let sign = robot.servos.directions[k];
        let stroke = bench.world.stroke(k) - start.stroke(k);
        assert!((stroke / (sign * turned * robot.servos.true_radii[k]) - 1.0).abs() < 1e-9, "{k}: {stroke}");
        // A servo droops a little under its tendon.
        assert!(turned.abs() > 0.8 * 3e-3 / robot.servos.pulley_radius, "{k}: {turned}");
    }
    // The next day the tip rests elsewhere, the day after where it was then.
    let tip_after = |streams: &[&str]| {
        let mut bench = Bench::new(&robot, 1);
        streams.iter().for_each(|day| bench.world.reseed(1, day));
        bench.rest(3.0)
    };
    let [first, second, third] = [&[][..], &["one"], &["one", "two"]].map(tip_after);
    // Tendons 1 and 2 are at 0 and 90 degrees: the tip goes towards the one that is pulled, and away from the one
    // that goes slack by as much as that one pulled.
    assert!(second[0] - first[0] > 1e-3 && second[1] - first[1] < -1e-4, "{first:?} {second:?}");
    assert_eq!(second, third);
}
