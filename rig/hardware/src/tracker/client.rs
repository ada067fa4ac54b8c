//! The connection to the tracker: a thread that reads it, and connects again when it is gone.

use super::decoder::{DecodedMessage, MessageDecoder};
use super::message::start_request;
use super::pose_queue::{PoseCounts, PoseQueue};
use super::quality::PoseLimits;
use crate::{Error, Event, EventKind, Pose, Result};
use hysteron_base::BadInput;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest wait of the thread before it looks whether it shall stop.
const BEAT: Duration = Duration::from_millis(10);
/// Longest wait for a connection.
const CONNECT: Duration = Duration::from_millis(500);
/// Shortest and longest pause before the next attempt.
const PAUSE: [Duration; 2] = [Duration::from_millis(50), Duration::from_secs(2)];
/// A connection without any message for this multiple of `stale_after` is given up: the other side may have
/// vanished without a word.
const SILENT: f64 = 10.0;

/// Which tracker, and what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSettings {
    /// Host and port; 18944 is the usual port of OpenIGTLink.
    pub address: String,
    /// Name of the tool; the first one that sends a pose if `None`.
    pub device: Option<String>,
    /// From the measurement to the arrival of the message, at best [s].
    pub latency: f64,
    /// Longest time between two poses that is no fault [s].
    pub stale_after: f64,
    /// Asks the server for TDATA messages at this interval [s]; many servers send without being asked.
    pub request_interval: Option<f64>,
    /// Limits beyond which a pose is doubtful.
    pub limits: PoseLimits,
}

impl TrackerSettings {
    /// The first tool at that address, of a tracker that sends its poses at 20 Hz or more, at once and unasked.
    pub fn new(address: impl Into<String>) -> Self {
        Self {
            address: address.into(),
            device: None,
            latency: 0.0,
            stale_after: 0.25,
            request_interval: None,
            limits: PoseLimits::default(),
        }
    }

    /// Resolves the address and checks the numbers.
    fn check(&self) -> std::result::Result<Vec<SocketAddr>, BadInput> {
        if !(self.latency >= 0.0 && self.latency.is_finite()) {
            return Err(BadInput::new("tracker latency", "at least 0 s", format!("{} s", self.latency)));
        }
        if !(self.stale_after > 0.0 && self.stale_after.is_finite()) {
            let found = format!("{} s", self.stale_after);
            return Err(BadInput::new("longest time between poses", "more than 0 s", found));
        }
        if let Some(interval) = self.request_interval
            && !(interval >= 1e-3 && interval.is_finite())
        {
            return Err(BadInput::new("interval of poses", "at least 0.001 s", format!("{interval} s")));
        }
        let bad = |found: String| {
            BadInput::new("tracker address", "host:port", found).hint("such as 192.168.0.5:18944")
        };
        let found: Vec<SocketAddr> =
            self.address.to_socket_addrs().map_err(|e| bad(format!("{:?}: {e}", self.address)))?.collect();
        if found.is_empty() { Err(bad(format!("{:?}", self.address))) } else { Ok(found) }
    }
}

/// A connection to a tracker that keeps itself up. Dropping it ends its thread.
#[derive(Debug)]
pub struct Client {
    shared: Arc<ClientShared>,
    address: String,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct ClientShared {
    queue: Mutex<PoseQueue>,
    connected: AtomicBool,
    stop: AtomicBool,
}

impl ClientShared {
    fn queue(&self) -> MutexGuard<'_, PoseQueue> {
        // Whatever a panic left behind is whole: messages are taken one by one.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Client {
    /// Connects in the background. All times are seconds since `start`, the zero of the host's clock.
    ///
    /// # Errors
    /// `BadInput` if the address cannot be understood or a number is out of bounds. A tracker that does not answer
    /// is no error but an event.
    pub fn connect(settings: TrackerSettings, start: Instant) -> Result<Self> {
        let addresses = settings.check()?;
        let TrackerSettings { address, device, latency, stale_after, request_interval, limits } = settings;
        let request =
            request_interval.map(|interval| start_request(device.as_deref().unwrap_or(""), interval));
        let shared = Arc::new(ClientShared {
            queue: Mutex::new(PoseQueue::new(device, latency, stale_after, limits)),
            connected: AtomicBool::new(false),
            stop: AtomicBool::new(false),
        });
        let link = ClientState {
            addresses,
            request,
            silent_after: SILENT * stale_after,
            start,
            shared: shared.clone(),
        };
        let thread = std::thread::Builder::new()
            .name("tracker".into())
            .spawn(move || link.run())
            .map_err(|e| Error::Tracker(format!("no thread for the connection: {e}")))?;
        Ok(Self { shared, address, thread: Some(thread) })
    }

    /// Appends the poses that came since the last call, in order, in the tracker's frame. Their times are when they
    /// were measured, on the host's clock, strictly increasing.
    pub fn take_poses(&self, poses: &mut Vec<Pose>) {
        poses.extend(self.shared.queue().poses.drain(..));
    }

    /// Appends what went wrong since the last call.
    pub fn take_events(&self, events: &mut Vec<Event>) {
        events.extend(self.shared.queue().events.drain(..));
    }

    /// Whether messages come.
    pub fn is_connected(&self) -> bool {
        self.shared.connected.load(Ordering::Relaxed)
    }

    /// Counts of the messages so far.
    pub fn counts(&self) -> PoseCounts {
        self.shared.queue().counts
    }

    /// Waits until a pose can be taken.
    ///
    /// # Errors
    /// `Tracker` if none has come after `timeout` [s], with the last event.
    pub fn wait_for_pose(&self, timeout: f64) -> Result<()> {
        let begin = Instant::now();
        loop {
            let queue = self.shared.queue();
            if !queue.poses.is_empty() {
                return Ok(());
            }
            if begin.elapsed().as_secs_f64() > timeout {
                let why = queue.events.back().map_or(String::new(), |event| format!(": {}", event.message));
                let what = format!("no pose of {} from {}", queue.device_name(), self.address);
                return Err(Error::Tracker(format!("{what} within {timeout} s{why}")));
            }
            drop(queue);
            std::thread::sleep(BEAT);
        }
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing left to end.
            let _ = thread.join();
        }
    }
}

/// State of the client's thread.
struct ClientState {
    addresses: Vec<SocketAddr>,
    request: Option<Vec<u8>>,
    silent_after: f64,
    start: Instant,
    shared: Arc<ClientShared>,
}

impl ClientState {
    fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn is_stopped(&self) -> bool {
        self.shared.stop.load(Ordering::Relaxed)
    }

    fn run(&self) {
        let mut pause = PAUSE[0];
        let mut is_loss_logged = false;
        while !self.is_stopped() {
            let (was_up, why) = match self.open() {
                Ok(stream) => self.read(stream, is_loss_logged),
                Err(error) => (false, error.to_string()),
            };
            self.shared.connected.store(false, Ordering::Relaxed);
            if self.is_stopped() {
                return;
            }
            if was_up {
                (pause, is_loss_logged) = (PAUSE[0], false);
            }
            if !is_loss_logged {
                let message = format!("{why}; trying again");
                self.shared.queue().log(self.now(), EventKind::TrackerLost, message);
                is_loss_logged = true;
            }
            let until = Instant::now() + pause;
            while Instant::now() < until && !self.is_stopped() {
                std::thread::sleep(BEAT.min(until.saturating_duration_since(Instant::now())));
            }
            pause = (pause * 2).min(PAUSE[1]);
        }
    }

    /// Opens the connection, to the first address that answers.
    fn open(&self) -> std::io::Result<TcpStream> {
        let mut result = Err(ErrorKind::AddrNotAvailable.into());
        for address in &self.addresses {
            result = TcpStream::connect_timeout(address, CONNECT);
            if result.is_ok() {
                break;
            }
        }
        let mut stream = result?;
        stream.set_read_timeout(Some(BEAT))?;
        stream.set_write_timeout(Some(CONNECT))?;
        stream.set_nodelay(true)?;
        if let Some(request) = &self.request {
            stream.write_all(request)?;
        }
        Ok(stream)
    }

    /// Reads until the connection ends; returns whether any message came, and why it ended. It counts as back, if
    /// its loss was logged, with the first message.
    fn read(&self, mut stream: TcpStream, is_loss_logged: bool) -> (bool, String) {
        let mut decoder = MessageDecoder::new();
        let mut buffer = [0; 4096];
        let (mut n_messages, mut is_up) = (0_usize, false);
        let mut last_message = self.now();
        self.shared.queue().connected(last_message);
        while !self.is_stopped() {
            let result = stream.read(&mut buffer);
            let now = self.now();
            let mut queue = self.shared.queue();
            match result {
                Ok(0) => return (is_up, "the tracker closed the connection".into()),
                Ok(n) => decoder.decode(&buffer[..n], |decoded| {
                    if !matches!(decoded, DecodedMessage::Damaged(_)) {
                        (n_messages, last_message) = (n_messages + 1, now);
                    }
                    queue.take(decoded, now);
                }),
                Err(e) if is_timeout(&e) => {}
                Err(e) => return (is_up, e.to_string()),
            }
            queue.tick(now);
            if n_messages > 0 && !is_up {
                is_up = true;
                self.shared.connected.store(true, Ordering::Relaxed);
                if is_loss_logged {
                    queue.log(now, EventKind::TrackerBack, "the tracker sends again".into());
                }
            }
            if now - last_message > self.silent_after {
                return (is_up, format!("no message for {:.1} s", now - last_message));
            }
        }
        (is_up, String::new())
    }
}

fn is_timeout(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}
