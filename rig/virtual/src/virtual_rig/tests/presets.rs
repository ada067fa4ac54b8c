//! Behaviour of the presets, measured as on a bench.

use super::super::VirtualRobot;
use super::bench::{Bench, distance};

/// Quantities that distinguish a mild preset from a harsh one.
#[derive(Debug)]
struct Figures {
    /// Mean radius of the commanded circle at the diagonals over that at the tendons' axes [-].
    diamond: f64,
    /// Median over the tendons of the loop's width over its excursion [-].
    loop_width: f64,
    /// The same of its mean width [-].
    mean_width: f64,
    /// Median over the tendons of the miss of the way back to zero over the excursion [-].
    zero_miss: f64,
    /// Excursions [m].
    excursions: [f64; 4],
}

fn median(mut values: [f64; 4]) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[1] + values[2])
}

/// Commands that bring the tip about 20 mm out.
const STROKE: f64 = 6.5e-3;

fn figures(robot: &VirtualRobot, seed: u64) -> Figures {
    let mut bench = Bench::new(robot, seed);
    let (mut loops, mut means, mut misses, mut excursions) = ([0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]);
    for k in 0..4 {
        let before = bench.rest(2.0);
        let found = bench.pull(k, STROKE, 16.0);
        let after = bench.rest(2.0);
        (loops[k], excursions[k]) = (found.relative(), found.excursion);
        means[k] = found.mean_width / found.excursion;
        misses[k] = distance(before, after) / found.excursion;
    }
    let mut bench = Bench::new(robot, seed);
    let tips = bench.circle(STROKE, 16.0);
    let diameter = |degree: usize| distance(tips[degree], tips[degree + 180]);
    let diamond = (diameter(45) + diameter(135)) / (diameter(0) + diameter(90));
    Figures {
        diamond,
        loop_width: median(loops),
        mean_width: median(means),
        zero_miss: median(misses),
        excursions,
    }
}

#[test]
fn presets_show_what_hardware_showed() {
    let of = |name: &str| {
        let figures = figures(&VirtualRobot::preset(name).unwrap(), 1);
        println!("{name}: {figures:.4?}");
        figures
    };
    let (mild, typical, harsh) = (of("mild"), of("typical"), of("harsh"));
    // CoReAct paper: tips between 21 and 29 mm out in training; here with room to both sides.
    assert!(typical.excursions.iter().all(|x| (0.015..0.03).contains(x)));
    assert!(typical.diamond < 0.9);
    assert!((0.05..0.09).contains(&typical.loop_width));
    assert!((0.01..0.06).contains(&typical.zero_miss));
    assert!((0.05..0.09).contains(&typical.mean_width)); // whichever way a loop's width is meant
    assert!(mild.loop_width < 0.6 * typical.loop_width && harsh.loop_width > 1.4 * typical.loop_width);
    assert!(mild.zero_miss < typical.zero_miss && harsh.zero_miss > typical.zero_miss);
    // Friction rounds the corners that slack and axial compression make: the harsh diamond is not the sharpest.
    assert!(mild.diamond > typical.diamond && harsh.diamond < mild.diamond);
}

#[test]
fn members_of_a_population_differ_but_keep_the_character() {
    let typical = VirtualRobot::preset("typical").unwrap();
    assert_eq!(typical.draw(3), typical.draw(3));
    let mut loops = Vec::new();
    for seed in 1..=4 {
        let member = typical.draw(seed);
        assert_ne!(member.body, typical.body);
        let figures = figures(&member, seed);
        println!("member {seed}: {figures:.4?}");
        loops.push(figures.loop_width);
        // Friction within 2.5 deviations of 0.2: a factor of 1.65; play and stiffness add to it.
        assert!(figures.diamond < 0.95 && (0.04..0.17).contains(&figures.loop_width));
    }
    assert!(loops.iter().any(|x| (x - loops[0]).abs() > 0.005));
}
