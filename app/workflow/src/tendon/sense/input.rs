//! A recording as input of the sensor: strokes, servos, tip, and the truth where it is known.

use std::f64::consts::TAU;
use std::time::Instant;

use hysteron_actuator::{TICKS_PER_TURN, stroke_per_tick};
use hysteron_base::statistics::nearest_quantile;
use hysteron_base::{BadInput, Recording};
use hysteron_twin::sense::{RecordingObservations, SenseSample, SensingTruth, TwinObserver};
use hysteron_twin::{RobotMotion, Twin};
use nalgebra::Vector3;

use crate::shared::error::Cancelled;
use crate::shared::network::{self, Network};
use crate::{Context, Progress};

/// Servos of a recording: what each pulley has turned and its load, both positive where it pulls.
pub struct Servos {
    /// Sample by sample (n_samples × n_primary) [rad].
    angles: Vec<Vec<f64>>,
    /// See `angles` [-].
    loads: Vec<Vec<f64>>,
    /// Radius of the pulleys [m].
    pub radius: f64,
}

/// A recording to be sensed.
pub struct SensingInput {
    /// Name in messages.
    pub name: String,
    /// Commands and tip.
    pub motion: RobotMotion,
    /// Servos, where they were recorded.
    pub servos: Option<Servos>,
    /// Force on the tip and tensions, where they are known.
    pub truth: SensingTruth,
}

impl SensingInput {
    /// Takes a recording apart.
    pub fn new(twin: &Twin, recording: &Recording, name: &str) -> anyhow::Result<Self> {
        if recording.rate_hz().is_none() {
            let expected = "equal time steps, within 1 %";
            return Err(BadInput::new(format!("{name}: time_s"), expected, "unequal ones")
                .hint("resample the recording")
                .into());
        }
        let n = twin.n_primary;
        let axis = |stem: &str| -> Option<[&[f64]; 3]> {
            let of = |axis: &str| recording.channel(&format!("{stem}_{axis}_n"));
            Some([of("x")?, of("y")?, of("z")?])
        };
        let force = axis("tip_force").or_else(|| axis("true_tip_force"));
        let force = force.map(|[x, y, z]| (0..x.len()).map(|i| Vector3::new(x[i], y[i], z[i])).collect());
        let tensions = recording.numbered("true_tension", "n");
        let tensions = (tensions.len() == n).then(|| tensions.into_iter().map(<[f64]>::to_vec).collect());
        Ok(Self {
            motion: RobotMotion::new(twin, recording, name)?,
            servos: servos(recording, n).map_err(|bad| bad.within(name))?,
            name: name.to_owned(),
            truth: SensingTruth { force, tensions },
        })
    }

    /// Duration of a sample [s].
    pub fn period(&self) -> f64 {
        self.motion.step
    }

    /// Goes through the recording with the twin; `on` receives every observation.
    pub fn observe(
        &self,
        twin: &Twin,
        network: Option<&Network>,
        context: &Context,
        bar: &dyn Progress,
    ) -> anyhow::Result<RecordingObservations> {
        let plant = network::plant(network, twin, self.period()).map_err(|bad| bad.within(&self.name))?;
        let mut observer = TwinObserver::new(twin, plant, self.motion.strokes_at(0), self.period())?;
        let mut samples = Vec::with_capacity(self.motion.len());
        let mut times = Vec::with_capacity(self.motion.len());
        for i in 0..self.motion.len() {
            if context.is_cancelled() {
                return Err(Cancelled::new("; nothing is written").into());
            }
            let start = Instant::now();
            samples.push(observer.step(&self.sample(i))?);
            times.push(1e3 * start.elapsed().as_secs_f64());
            bar.inc(1);
        }
        log_times(&self.name, &mut times, self.period());
        Ok(RecordingObservations { name: self.name.clone(), samples })
    }

    /// Commands and measurements of sample `i`.
    pub fn sample(&self, i: usize) -> SenseSample<'_> {
        SenseSample {
            strokes: self.motion.strokes_at(i),
            angles: self.servos.as_ref().map(|servos| servos.angles[i].as_slice()),
            loads: self.servos.as_ref().map(|servos| servos.loads[i].as_slice()),
            tip: (!self.motion.gap[i]).then_some(self.motion.tips[i]),
        }
    }
}

/// Logs how long samples took [ms], compared with their period [s].
pub fn log_times(name: &str, times: &mut [f64], period: f64) {
    let [median, most, longest] = [0.5, 0.99, 1.0].map(|part| nearest_quantile(times, part).unwrap_or(0.0));
    tracing::info!(
        "{name}: a sample takes {:.2} ms in the median, {:.2} ms in 99 of 100 and {:.2} ms at most; there are {:.1} ms",
        median,
        most,
        longest,
        1e3 * period
    );
}

/// Servos from ticks and loads; strokes and goals give the direction of a pulley.
fn servos(recording: &Recording, n: usize) -> Result<Option<Servos>, BadInput> {
    let (goals, present) = (recording.numbered("tick_goal", ""), recording.numbered("tick_present", ""));
    let (loads, strokes) = (recording.numbered("load", ""), recording.strokes());
    if [goals.len(), present.len(), loads.len(), strokes.len()] != [n; 4] {
        return Ok(None);
    }
    let mut servos = Servos {
        angles: vec![Vec::with_capacity(n); recording.n_samples()],
        loads: vec![Vec::with_capacity(n); recording.n_samples()],
        radius: 0.0,
    };
    let mut radii = Vec::with_capacity(n);
    for k in 0..n {
        let is_constant = |values: &[f64]| values.iter().all(|value| *value == values[0]);
        let stroke_per_tick = match stroke_per_tick(goals[k], strokes[k]) {
            Some(found) => found,
            // A servo that rests throughout does not show its direction; either is valid.
            None if is_constant(goals[k]) && is_constant(strokes[k]) => 0.0,
            None => {
                let place = format!("tick_goal_{}", k + 1);
                return Err(BadInput::new(place, "ticks that follow the strokes", "ones that do not").hint(
                    "leave the columns tick_goal, tick_present and load out, and tensions rest on the twin alone",
                ));
            }
        };
        radii.extend((stroke_per_tick != 0.0).then(|| stroke_per_tick.abs() * TICKS_PER_TURN / TAU));
        for i in 0..recording.n_samples() {
            servos.angles[i].push(stroke_per_tick.signum() * present[k][i] * TAU / TICKS_PER_TURN);
            servos.loads[i].push(stroke_per_tick.signum() * loads[k][i]);
        }
    }
    servos.radius = radii.iter().sum::<f64>() / radii.len() as f64;
    Ok((!radii.is_empty()).then_some(servos))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use hysteron_base::{Channel, Metadata};

    use super::*;

    /// Two servos, the second of which winds the other way.
    fn recording(goals: [fn(usize) -> f64; 2], strokes: [fn(usize) -> f64; 2]) -> Recording {
        let n = 50;
        let of = |name: String, f: &dyn Fn(usize) -> f64| Channel::new(name, (0..n).map(f).collect());
        let mut channels = Vec::new();
        for k in 0..2 {
            channels.push(of(format!("stroke_{}_m", k + 1), &strokes[k]));
            channels.push(of(format!("tick_goal_{}", k + 1), &goals[k]));
            channels.push(of(format!("tick_present_{}", k + 1), &goals[k]));
            channels.push(of(format!("load_{}", k + 1), &|_| 0.1));
        }
        let time = (0..n).map(|i| 0.01 * i as f64).collect();
        Recording::new(time, channels, Vec::new(), Metadata::default()).unwrap()
    }

    #[test]
    fn a_servo_that_rests_throughout_keeps_no_recording_from_being_read() {
        let moving = recording([|i| i as f64, |_| 7.0], [|i| 1e-5 * i as f64, |_| 0.0]);
        let found = servos(&moving, 2).unwrap().unwrap();
        assert!((found.radius - 1e-5 * TICKS_PER_TURN / TAU).abs() < 1e-12, "{}", found.radius);
        assert!(found.angles[9][0] > 0.0 && found.loads[9].len() == 2);
        let resting = recording([|_| 7.0, |_| 7.0], [|_| 0.0, |_| 0.0]);
        assert!(servos(&resting, 2).unwrap().is_none());
        let odd = recording([|i| i as f64, |_| 7.0], [|i| 1e-5 * i as f64, |i| 1e-5 * i as f64]);
        assert_eq!(servos(&odd, 2).map(|_| ()).unwrap_err().place, "tick_goal_2");
    }
}
