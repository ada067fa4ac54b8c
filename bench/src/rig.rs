//! The virtual rig on a commanded circle: how much faster than the real one it lives.

use std::f64::consts::TAU;
use std::time::Instant;

use anyhow::{Result, ensure};
use hysteron_virtual_rig::virtual_rig::{VirtualRobot, World};

use crate::table::{FigureTarget, TableRow};

/// Time between two commands [s].
pub const PERIOD: f64 = 0.01;
/// Amplitude of the strokes [m]: the tip goes about 22 mm out.
pub const AMPLITUDE: f64 = 6.5e-3;
/// Time of one circle [s].
const CIRCLE: f64 = 10.0;

/// A world whose servos go round and round.
#[derive(Debug, Clone)]
pub struct Circling {
    /// The world.
    pub world: World,
    /// Of the strokes, after the first circle [m].
    pub amplitude: f64,
    zeros: Vec<i32>,
    ticks_per_metre: Vec<f64>,
    cycle: u32,
}

impl Circling {
    /// The preset `typical`, with torque on.
    ///
    /// # Errors
    /// The preset is bad.
    pub fn new() -> Result<Self> {
        let robot = VirtualRobot::preset("typical")?;
        let mut world = World::new(&robot, 1);
        let mut zeros = Vec::new();
        for k in 0..world.n_servos() {
            let command = world.command_mut(k);
            command.torque_on = true;
            zeros.push(command.goal);
        }
        let per_metre = 4096.0 / (TAU * robot.servos.pulley_radius);
        let ticks_per_metre = robot.servos.directions.iter().map(|sign| sign * per_metre).collect();
        Ok(Self { world, amplitude: AMPLITUDE, zeros, ticks_per_metre, cycle: 0 })
    }

    /// One command, and the time until the next.
    pub fn cycle(&mut self) {
        let time = f64::from(self.cycle) * PERIOD;
        let amplitude = self.amplitude * (time / CIRCLE).min(1.0);
        for (k, zero) in self.zeros.iter().enumerate() {
            let stroke = amplitude * (TAU * (time / CIRCLE - 0.25 * k as f64)).cos();
            self.world.command_mut(k).goal = zero + (stroke * self.ticks_per_metre[k]).round() as i32;
        }
        self.world.advance(PERIOD);
        self.cycle += 1;
    }

    /// World time over the time that `n` cycles take.
    fn speed(&mut self, n: u32) -> f64 {
        let start = Instant::now();
        (0..n).for_each(|_| self.cycle());
        f64::from(n) * PERIOD / start.elapsed().as_secs_f64()
    }
}

/// Speed of the virtual rig compared with that of the same rig with plain Newton iterations, alternating.
///
/// # Errors
/// The preset is bad, or a balance of the body failed.
pub fn rows(repetitions: usize) -> Result<Vec<TableRow>> {
    let mut kept = Circling::new()?;
    (0..1000).for_each(|_| kept.cycle());
    let mut plain = kept.clone();
    plain.world.always_factorise();
    let (mut fast, mut slow) = (0.0f64, 0.0f64);
    for _ in 0..repetitions.max(2) {
        fast = fast.max(kept.speed(1000));
        slow = slow.max(plain.speed(1000));
    }
    let counts = kept.world.balance_counts();
    ensure!(counts.failures == 0, "{} balances of the virtual rig failed", counts.failures);
    let row = TableRow::new("virtual rig, times real time", fast, "-")
        .against(slow, "the same rig, a new factor in every iteration")
        .goal(FigureTarget::AtLeast(50.0));
    let [there, here] = [plain, kept].map(|circling| circling.world.tip().position);
    let apart = (0..3).map(|i| (there[i] - here[i]).powi(2)).sum::<f64>().sqrt();
    // Proof that both did the same work.
    Ok(vec![
        row,
        TableRow::new("virtual rig, tips of both apart", 1e3 * apart, "mm").goal(FigureTarget::AtMost(1e-3)),
    ])
}
