//! The definition of the loop's width, applied to a real robot.

use super::super::loop_width;
use hysteron_fuzz::recorded;

/// Pull-and-release recordings of single tendons: per tendon the strokes [mm] and the tips [mm].
fn pulls(text: &str) -> Vec<(String, Vec<f64>, Vec<[f64; 3]>)> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut found: Vec<(String, Vec<f64>, Vec<[f64; 3]>)> = Vec::new();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |name: &str| -> f64 {
            cells[names.iter().position(|other| *other == name).unwrap()].parse().unwrap()
        };
        // `rep1_tendon0_id4_pull` moves servo 4; holds in between belong to no pull.
        let label = cells[1];
        let Some(servo) = label.strip_suffix("_pull").and_then(|rest| rest.split("_id").nth(1)) else {
            continue;
        };
        if found.last().is_none_or(|(last, ..)| last != label) {
            found.push((label.to_owned(), Vec::new(), Vec::new()));
        }
        let (_, strokes, tips) = found.last_mut().unwrap();
        strokes.push(number(&format!("servo_{servo}_mm")));
        tips.push(["tip_x", "tip_y", "tip_z"].map(number));
    }
    found
}

#[test]
fn loops_of_a_recorded_robot_are_as_wide_as_described() {
    let Some(path) = recorded("loops_of_a_recorded_robot", "ftdcr-v4/tendon_pull.csv") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let (mut widths, mut means) = (Vec::new(), Vec::new());
    for (label, strokes, tips) in pulls(&text) {
        if let Some(found) = loop_width(&strokes, &tips) {
            let mean = found.mean_width / found.excursion;
            println!(
                "{label}: widest {:.1} %, mean {:.1} % of {:.0} mm",
                100.0 * found.relative(),
                100.0 * mean,
                found.excursion
            );
            widths.push(found.relative());
            means.push(mean);
        }
    }
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (width, mean) = (median(&mut widths), median(&mut means));
    println!("median of {}: widest {:.1} %, mean {:.1} %", widths.len(), 100.0 * width, 100.0 * mean);
    assert!(widths.len() >= 8);
    // The description gives 8.3 % as the median of 62 loops of the whole set, without saying how it measures. These
    // nine are the first of their tendons: they begin slack and end taut, which is where they are widest.
    assert!((0.05..0.3).contains(&width) && mean < width, "{width} {mean}");
}
