//! Random plans for the stability of the loop.

use hysteron_base::rng;
use rand::RngExt;

/// How long each trajectory lasts [s].
pub(super) const RANDOM_S: f64 = 60.0;

/// Sinusoids, circles, ellipses and squares with drawn amplitude, frequency and orientation.
pub(super) fn random_plan(n: usize) -> String {
    let mut text = "format = \"hysteron-plan\"\nversion = 1\nname = \"random\"\nseed = 1\nrate_hz = 100\n\
                    tendon_angles_deg = [0, 90, 180, 270]\nrelease = 1.0\nscale = 1.3\nrest_before_s = 1.32\n\
                    rest_after_s = 2\nstroke_max_mm = 9\nstroke_rate_max_mm_s = 9\n"
        .to_owned();
    let mut stream = rng(1, "bench/random-plan");
    // Largest amplitude of training, 5 mm before scaling.
    let mut draw = |low: f64, high: f64| stream.random_range(low..high);
    for k in 0..n {
        let family = ["sinusoid", "circle", "ellipse", "square"][k % 4];
        let amplitude = if k % 2 == 0 { draw(1.5, 5.0) } else { draw(5.0, 6.0) };
        let frequency = draw(0.05, 0.15);
        text += &format!(
            "\n[[trajectory]]\nname = \"random-{k}\"\nrole = \"validation\"\nfamily = \"{family}\"\n\
             amplitude_mm = {amplitude:.3}\nfrequency_hz = {frequency:.4}\n{} = {:.1}\nattack_s = 10\n\
             sustain_s = {}\ndecay_s = 10\n",
            if family == "circle" { "phase_deg" } else { "orientation_deg" },
            draw(0.0, 180.0),
            RANDOM_S - 23.32
        );
        if family == "ellipse" {
            text += &format!("aspect = {:.2}\n", draw(0.3, 0.9));
        }
        if family != "sinusoid" {
            text += "direction = \"clockwise\"\n";
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_of_random_plans_are_as_long_as_they_say() -> anyhow::Result<()> {
        let plan = hysteron_control::MotionPlan::from_toml(&random_plan(8), "random")?;
        assert_eq!(plan.trajectories().len(), 8);
        for trajectory in plan.trajectories() {
            assert!((trajectory.duration() - RANDOM_S).abs() < 0.02, "{}", trajectory.duration());
        }
        Ok(())
    }
}
