//! Sensing while a robot is recorded: the rows that become the recording go through the estimators of `hysteron sense`, so both give
//! the same estimates.
//!
//! A sample costs milliseconds, so a separate thread works during the rig's cycle. A rig in real time takes the estimates that are
//! ready; a simulated one waits, and its recordings stay the same bytes.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, SyncSender, TryRecvError, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::Instant;

use anyhow::Context as _;
use hysteron_base::{BadInput, PrescribedQuantity, Recording, Scene};
use hysteron_rig::calibration::RigCalibration;
use hysteron_rig::session::{RigRecorder, Supervisor};
use hysteron_rig::{EventKind, ShutdownAction, Violation};
use hysteron_twin::Twin;
use hysteron_twin::sense::{ForceSensor, SenseSample, SensedSample, TendonSensing, TwinObserver};

use super::file::{self, SensedRobot};
use super::input::log_times;
use crate::shared::network::{self, Network};

/// Estimate contacts and tensions while recording
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct LiveOptions {
    /// Force sensor by hysteron fit-sensor: contacts and tensions are estimated while the robot moves
    #[cfg_attr(feature = "clap", arg(long, required = false, value_name = "FILE", requires = "scene"))]
    pub sensor: PathBuf,
    /// Scene that the sensor was fitted with
    #[cfg_attr(feature = "clap", arg(long, required = false, value_name = "SCENE", requires = "sensor"))]
    pub scene: PathBuf,
    /// Residual network that the sensor was fitted with
    #[cfg_attr(feature = "clap", arg(long, value_name = "CKPT", requires = "sensor"))]
    pub residual: Option<PathBuf>,
    /// End the recording at a contact: slowly back to rest
    #[cfg_attr(feature = "clap", arg(long, requires = "sensor"))]
    pub stop_on_contact: bool,
    /// End the recording, torque off, where the estimated tension of a tendon is larger
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", requires = "sensor"))]
    pub tension_max: Option<f64>,
}

/// Rows that may wait for the thread: ten seconds.
const QUEUE: usize = 1000;
/// How far sensing may lag behind the robot where it is to stop it [s].
const LAG_MAX: f64 = 0.3;

/// Twin, network, sensor and options for sensing a robot while it is recorded.
#[derive(Clone)]
pub struct LiveSensing {
    options: LiveOptions,
    twin: Arc<Twin>,
    network: Option<Arc<Network>>,
    sensor: ForceSensor,
}

/// Whether a rig waits for estimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensingMode {
    /// It does not: its cycles come when they must.
    RealTime,
    /// It does.
    Blocking,
}

impl LiveSensing {
    /// Reads sensor, scene and network, of a rig with `n` tendons.
    pub fn read(options: &LiveOptions, n: usize) -> anyhow::Result<Self> {
        if let Some(limit) = options.tension_max.filter(|limit| !(*limit > 0.0 && limit.is_finite())) {
            return Err(BadInput::new("--tension-max", "a finite number > 0", limit.to_string()).into());
        }
        let scene = Scene::read(&options.scene)?;
        let twin = Twin::from_scene(&scene)?;
        let n_driven =
            twin.tendons[..twin.n_primary].iter().filter(|t| t.drive == PrescribedQuantity::Stroke).count();
        if [twin.n_primary, n_driven] != [n; 2] {
            let expected = format!("{n} tendons driven by strokes, as the rig has");
            let place = options.scene.display().to_string();
            return Err(BadInput::new(place, expected, n_driven.to_string()).into());
        }
        let network = options.residual.as_ref().map(|path| Network::read(path, &scene, &twin)).transpose()?;
        let robot = SensedRobot {
            scene: &scene.hash,
            network: network.as_ref().map(|network| network.hash.as_str()),
        };
        let sensor = file::read(&options.sensor, &robot)?;
        Ok(Self { options: options.clone(), twin: Arc::new(twin), network: network.map(Arc::new), sensor })
    }

    /// Refuses a rate that the sensor was not fitted with.
    pub fn check_rate(&self, name: &str, rate_hz: f64) -> Result<(), BadInput> {
        if (rate_hz * self.sensor.period_s - 1.0).abs() <= 0.01 {
            return Ok(());
        }
        let expected = format!("{:.1} Hz, as the sensor was fitted with", 1.0 / self.sensor.period_s);
        Err(BadInput::new(format!("{name}: samples per second"), expected, format!("{rate_hz:.1} Hz")))
    }

    /// Lets a thread follow what `recorder` records under `commands`; returns when it is ready.
    pub fn follow(
        &self,
        recorder: RigRecorder,
        calibration: &RigCalibration,
        commands: &Recording,
        mode: SensingMode,
    ) -> anyhow::Result<RigRecorder> {
        let layout = Layout::new(recorder.channels(), calibration)?;
        let strokes: Vec<f64> = commands.strokes().iter().map(|channel| channel[0]).collect();
        let (rows, queue) = sync_channel(QUEUE);
        let (answers, estimates) = channel();
        let it = self.clone();
        let thread = std::thread::spawn(move || {
            if let Err(error) = it.work(&layout, &strokes, &queue, &answers) {
                // If the receiver is closed, the recording is over.
                let _ = answers.send(SensorMessage::Failed(format!("{error:#}")));
            }
        });
        if let SensorMessage::Failed(message) =
            estimates.recv().context("the thread that senses has ended")?
        {
            anyhow::bail!("sensing: {message}");
        }
        Ok(recorder.supervised_by(Box::new(Live {
            rows: Some(rows),
            estimates,
            thread: Some(thread),
            mode,
            stop_on_contact: self.options.stop_on_contact,
            tension_max: self.options.tension_max,
            n_waiting: 0,
            time: 0.0,
            estimated_until: 0.0,
            contact: None,
            failure: None,
            is_late: false,
        })))
    }

    /// The thread: row by row until there are no more.
    fn work(
        &self,
        layout: &Layout,
        strokes: &[f64],
        rows: &Receiver<Row>,
        answers: &Sender<SensorMessage>,
    ) -> anyhow::Result<()> {
        let (twin, period) = (&*self.twin, self.sensor.period_s);
        let plant = network::plant(self.network.as_deref(), twin, period)?;
        let mut observer = TwinObserver::new(twin, plant, strokes, period)?;
        let mut sensing = TendonSensing::new(&self.sensor, twin.n_primary)?;
        let mut last = LastValues::default();
        let mut times = Vec::new();
        answers.send(SensorMessage::Ready)?;
        for Row { time, values } in rows {
            let start = Instant::now();
            let (sensed, _) = sensing.sense(&mut observer, &layout.sample(&values, &mut last))?;
            times.push(1e3 * start.elapsed().as_secs_f64());
            if answers.send(SensorMessage::Estimate(TimedEstimate { time, sensed })).is_err() {
                break;
            }
        }
        log_times("sensing", &mut times, period);
        Ok(())
    }
}

/// One row of a recording.
#[derive(Debug)]
struct Row {
    time: f64,
    values: Vec<f64>,
}

/// Force estimate for one sample.
#[derive(Debug)]
struct TimedEstimate {
    time: f64,
    sensed: SensedSample,
}

#[derive(Debug)]
enum SensorMessage {
    Ready,
    Estimate(TimedEstimate),
    Failed(String),
}

/// Columns of the inputs in a row.
struct Layout {
    strokes: Vec<usize>,
    present: Vec<usize>,
    loads: Vec<usize>,
    tip: [usize; 3],
    /// Turned by a pulley for a tick, positive where it pulls [rad] (n).
    angle_per_tick: Vec<f64>,
}

/// Values of the last row, kept where a servo did not answer.
#[derive(Default)]
struct LastValues {
    strokes: Vec<f64>,
    angles: Vec<f64>,
    loads: Vec<f64>,
}

impl Layout {
    fn new(channels: &[String], calibration: &RigCalibration) -> Result<Self, BadInput> {
        let n = calibration.channels.len();
        let place = |name: &str| {
            channels.iter().position(|channel| channel == name).ok_or_else(|| {
                BadInput::new("--sensor", format!("a rig that records {name}"), "one that does not").hint(
                    "forces are estimated from a tracked tip: register a tracker with `hysteron rig calibrate`",
                )
            })
        };
        let numbered = |stem: &str, unit: &str| -> Result<Vec<usize>, BadInput> {
            (1..=n).map(|k| place(&format!("{stem}_{k}{unit}"))).collect()
        };
        let [x, y, z] = ["tip_x_m", "tip_y_m", "tip_z_m"].map(place);
        let turn = calibration.channels.iter();
        Ok(Self {
            strokes: numbered("stroke", "_m")?,
            present: numbered("tick_present", "")?,
            loads: numbered("load", "")?,
            tip: [x?, y?, z?],
            angle_per_tick: turn
                .map(|c| c.stroke_per_tick().signum() * TAU / f64::from(c.ticks_per_turn))
                .collect(),
        })
    }

    fn sample<'a>(&self, row: &[f64], last: &'a mut LastValues) -> SenseSample<'a> {
        let n = self.strokes.len();
        for values in [&mut last.strokes, &mut last.angles, &mut last.loads] {
            values.resize(n, 0.0);
        }
        let mut is_whole = true;
        let mut take = |last_value: &mut f64, value: f64| {
            is_whole &= value.is_finite();
            if value.is_finite() {
                *last_value = value;
            }
        };
        for k in 0..n {
            take(&mut last.strokes[k], row[self.strokes[k]]);
            take(&mut last.angles[k], row[self.present[k]] * self.angle_per_tick[k]);
            let sign = self.angle_per_tick[k].signum();
            take(&mut last.loads[k], row[self.loads[k]] * sign);
        }
        let tip = self.tip.map(|i| row[i]);
        is_whole &= tip.iter().all(|value| value.is_finite());
        SenseSample {
            strokes: &last.strokes,
            angles: Some(&last.angles),
            loads: Some(&last.loads),
            tip: is_whole.then_some(tip),
        }
    }
}

/// A contact that is there.
#[derive(Debug, Clone, Copy)]
struct Contact {
    since: f64,
    largest: f64,
}

/// The rig's side of the thread.
#[derive(Debug)]
struct Live {
    /// None once the recording is over.
    rows: Option<SyncSender<Row>>,
    estimates: Receiver<SensorMessage>,
    thread: Option<JoinHandle<()>>,
    mode: SensingMode,
    stop_on_contact: bool,
    tension_max: Option<f64>,
    /// Rows without an estimate yet.
    n_waiting: usize,
    /// Of the last row, and of the last one with an estimate [s].
    time: f64,
    estimated_until: f64,
    contact: Option<Contact>,
    /// Why there is no more sensing.
    failure: Option<String>,
    /// Whether it was logged that sensing lags behind.
    is_late: bool,
}

impl Supervisor for Live {
    fn take_row(&mut self, time: f64, row: &[f64]) {
        self.time = time;
        let Some(rows) = self.rows.as_ref().filter(|_| self.failure.is_none()) else { return };
        match rows.try_send(Row { time, values: row.to_vec() }) {
            Ok(()) => self.n_waiting += 1,
            Err(_) => self.failure = Some(format!("it is more than {QUEUE} samples behind")),
        }
    }

    fn check(&mut self, notes: &mut Vec<(EventKind, String)>) -> Result<(), Violation> {
        while let Some(estimate) = self.next() {
            self.check_estimate(&estimate, notes)?;
        }
        let lag = self.time - self.estimated_until;
        let problem = match &self.failure {
            Some(failure) => failure.clone(),
            None if lag > LAG_MAX => format!("it is {:.0} ms behind the robot", 1e3 * lag),
            None => {
                self.is_late = false;
                return Ok(());
            }
        };
        let message = format!("sensing: {problem}");
        if self.stop_on_contact || self.tension_max.is_some() {
            let message = format!("{message}, and cannot stop it in time");
            return Err(Violation { tendon: None, message, shutdown: ShutdownAction::ToRest });
        }
        if !std::mem::replace(&mut self.is_late, true) {
            notes.push((EventKind::Late, message));
        }
        Ok(())
    }
}

impl Live {
    /// Next estimate; a simulated rig waits for it.
    fn next(&mut self) -> Option<TimedEstimate> {
        if self.n_waiting == 0 || self.failure.is_some() {
            return None;
        }
        let answer = match self.mode {
            SensingMode::Blocking => self.estimates.recv().map_err(|_| TryRecvError::Disconnected),
            SensingMode::RealTime => self.estimates.try_recv(),
        };
        match answer {
            Ok(SensorMessage::Estimate(estimate)) => {
                self.n_waiting -= 1;
                self.estimated_until = estimate.time;
                return Some(estimate);
            }
            Ok(SensorMessage::Failed(message)) => self.failure = Some(message),
            Err(TryRecvError::Disconnected) => self.failure = Some("its thread has ended".to_owned()),
            Ok(SensorMessage::Ready) | Err(TryRecvError::Empty) => {}
        }
        None
    }

    /// Notes contacts that begin and end, and refuses what is not to be.
    fn check_estimate(
        &mut self,
        estimate: &TimedEstimate,
        notes: &mut Vec<(EventKind, String)>,
    ) -> Result<(), Violation> {
        let TimedEstimate { time, sensed } = estimate;
        let tip = &sensed.tip;
        let largest = tip.force.norm();
        let begins = tip.is_contact && self.contact.is_none();
        let [x, y, z] = tip.force.into();
        let message = format!("contact at {time:.2} s: ({x:.2}, {y:.2}, {z:.2}) N at first");
        if begins {
            notes.push((EventKind::Contact, message.clone()));
            self.contact = Some(Contact { since: *time, largest });
        }
        if let Some(contact) = &mut self.contact {
            contact.largest = contact.largest.max(largest);
        }
        if let Some(contact) = self.contact.take_if(|_| !tip.is_contact) {
            let Contact { since, largest } = contact;
            let message =
                format!("no contact at {time:.2} s: it lasted {:.2} s, {largest:.2} N at most", time - since);
            notes.push((EventKind::Contact, message));
        }
        if begins && self.stop_on_contact {
            return Err(Violation { tendon: None, message, shutdown: ShutdownAction::ToRest });
        }
        let Some(limit) = self.tension_max else { return Ok(()) };
        match sensed.tensions.iter().position(|(tension, _)| *tension > limit) {
            None => Ok(()),
            Some(k) => {
                let (tension, error) = sensed.tensions[k];
                let message = format!(
                    "tension: expected at most {limit:.1} N, estimated {tension:.1} N (standard error {error:.1} N)"
                );
                Err(Violation { tendon: Some(k), message, shutdown: ShutdownAction::TorqueOff })
            }
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // The thread ends where no row can come any more.
        drop(self.rows.take());
        if let Some(thread) = self.thread.take() {
            // The thread itself has reported its panic.
            let _ = thread.join();
        }
    }
}
