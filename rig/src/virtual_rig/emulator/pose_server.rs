//! A tracker's server: poses over OpenIGTLink to whoever connects, with the faults of real ones.
//!
//! It has no thread of its own and never waits: connections are taken, read and written whenever it is called, and
//! a client that does not read loses poses, not others theirs.

use crate::tracker::{Content, Message, Protocol, ToolPose};
use crate::virtual_rig::{TrackedPose, World};
use crate::{Error, Quality, Result};
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Most bytes that wait for a slow client.
const MOST_PENDING: usize = 64 * 1024;
/// Pause of the thread that serves a world.
const BEAT: Duration = Duration::from_millis(1);

/// The clock that stamps the poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceClock {
    /// What it shows at time 0 of the world [s]; at least 0.
    pub offset: f64,
    /// How much faster it runs [-].
    pub drift: f64,
}

impl DeviceClock {
    /// What it shows at a time of the world [s].
    pub fn show(&self, time: f64) -> f64 {
        self.offset + (1.0 + self.drift) * time
    }
}

/// Kind of the messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// TRANSFORM of protocol 2; an invalid pose has a rotation of zeros.
    Transform,
    /// TRANSFORM of protocol 3 with its status, as PlusServer sends.
    TransformWithStatus,
    /// POSITION of protocol 3 with its status.
    Position,
    /// TDATA of protocol 2 with one tool.
    Tools,
}

/// What is served, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseServerSettings {
    /// Port on this machine; 0 for any that is free.
    pub port: u16,
    /// Name of the tool.
    pub device: String,
    /// Its clock.
    pub clock: DeviceClock,
    /// Kind of its messages.
    pub format: Format,
}

/// The server. Dropping it closes all connections.
#[derive(Debug)]
pub struct PoseServer {
    listener: Option<TcpListener>,
    address: SocketAddr,
    settings: PoseServerSettings,
    clients: Vec<Connection>,
    n_to_corrupt: usize,
}

#[derive(Debug)]
struct Connection {
    stream: TcpStream,
    pending: Vec<u8>,
}

impl PoseServer {
    /// Opens the port, for this machine alone.
    ///
    /// # Errors
    /// `Tracker` if the port is taken.
    pub fn start(settings: PoseServerSettings) -> Result<Self> {
        let listener = listen(settings.port)?;
        let address = listener.local_addr().map_err(|e| Error::Tracker(e.to_string()))?;
        Ok(Self { listener: Some(listener), address, settings, clients: Vec::new(), n_to_corrupt: 0 })
    }

    /// Where clients connect to.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Number of clients at the last call of [`poll`](Self::poll).
    pub fn n_clients(&self) -> usize {
        self.clients.len()
    }

    /// Takes new clients, lets go of those that left, and sends what waits for slow ones.
    pub fn poll(&mut self) {
        while let Some(Ok((stream, _))) = self.listener.as_ref().map(TcpListener::accept) {
            if stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true)).is_ok() {
                self.clients.push(Connection { stream, pending: Vec::new() });
            }
        }
        self.clients.retain_mut(|client| client.is_alive() && client.flush());
    }

    /// Sends a pose to all clients, now.
    pub fn send(&mut self, tracked: &TrackedPose) {
        let pose = &tracked.pose;
        let time = Some(self.settings.clock.show(pose.time));
        let valid = pose.quality != Quality::Flagged;
        let tool = ToolPose { position: pose.position, orientation: pose.orientation, valid };
        let device = self.settings.device.clone();
        let (content, protocol) = match self.settings.format {
            Format::Transform => (Content::Transform(tool), Protocol::Plain),
            Format::TransformWithStatus => (Content::Transform(tool), Protocol::WithStatus),
            Format::Position => (Content::Position(tool), Protocol::WithStatus),
            Format::Tools => (Content::Tools(vec![(device.clone(), tool)]), Protocol::Plain),
        };
        let mut bytes = Message { device, time, content }.to_bytes(protocol);
        if self.n_to_corrupt > 0 {
            self.n_to_corrupt -= 1;
            if let Some(last) = bytes.last_mut() {
                *last ^= 0x10;
            }
        }
        self.send_bytes(&bytes);
    }

    /// Sends any bytes to all clients that have room for them.
    pub fn send_bytes(&mut self, bytes: &[u8]) {
        self.poll();
        for client in &mut self.clients {
            if client.pending.len() + bytes.len() <= MOST_PENDING {
                client.pending.extend_from_slice(bytes);
            }
        }
        self.clients.retain_mut(Connection::flush);
    }

    /// Turns a bit in each of the next `n` poses, so that their checksum is wrong.
    pub fn corrupt_next(&mut self, n: usize) {
        self.n_to_corrupt = n;
    }

    /// Sets the clock, as a tracker that is switched off and on does.
    pub fn set_clock(&mut self, clock: DeviceClock) {
        self.settings.clock = clock;
    }

    /// Drops all clients; they may connect again.
    pub fn drop_clients(&mut self) {
        self.clients.clear();
    }

    /// Drops all clients and refuses new ones until [`plug`](Self::plug).
    pub fn unplug(&mut self) {
        self.listener = None;
        self.clients.clear();
    }

    /// Opens the same port again.
    ///
    /// # Errors
    /// `Tracker` if it has been taken meanwhile.
    pub fn plug(&mut self) -> Result<()> {
        if self.listener.is_none() {
            self.listener = Some(listen(self.address.port())?);
        }
        Ok(())
    }
}

fn listen(port: u16) -> Result<TcpListener> {
    let open = || {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        listener.set_nonblocking(true)?;
        Ok(listener)
    };
    open().map_err(|e: std::io::Error| Error::Tracker(format!("port {port} of the emulated tracker: {e}")))
}

impl Connection {
    /// Reads and forgets what the client asks for, since it gets its poses anyway. False if it is gone.
    fn is_alive(&mut self) -> bool {
        let mut scratch = [0; 512];
        loop {
            match self.stream.read(&mut scratch) {
                Ok(0) => return false,
                Ok(_) => {}
                Err(e) => return is_later(&e),
            }
        }
    }

    /// Writes as much as the client takes. False if it is gone.
    fn flush(&mut self) -> bool {
        while !self.pending.is_empty() {
            match self.stream.write(&self.pending) {
                Ok(n) => drop(self.pending.drain(..n)),
                Err(e) => return is_later(&e),
            }
        }
        true
    }
}

fn is_later(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

/// A thread that serves the poses of a world while someone else lets its time pass. Dropping it ends the thread.
#[derive(Debug)]
pub struct Delivery {
    server: Arc<Mutex<PoseServer>>,
    /// The thread ends when this end of the channel is gone.
    stop: Option<std::sync::mpsc::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Delivery {
    /// Serves each pose when the world's time reaches the moment at which it leaves the tracker.
    ///
    /// # Errors
    /// `Tracker` if there can be no thread.
    pub fn start(world: Arc<Mutex<World>>, server: PoseServer) -> Result<Self> {
        let server = Arc::new(Mutex::new(server));
        let (stop, stopped) = std::sync::mpsc::channel();
        let shared = server.clone();
        let work = move || {
            let (mut taken, mut waiting) = (Vec::new(), VecDeque::new());
            while stopped.recv_timeout(BEAT) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                let now = {
                    let mut world = lock(&world);
                    world.take_poses(&mut taken);
                    world.time()
                };
                waiting.extend(taken.drain(..));
                let mut server = lock(&shared);
                server.poll();
                while waiting.front().is_some_and(|pose: &TrackedPose| pose.sent_at <= now) {
                    waiting.pop_front().iter().for_each(|pose| server.send(pose));
                }
            }
        };
        let thread = std::thread::Builder::new()
            .name("pose-server".into())
            .spawn(work)
            .map_err(|e| Error::Tracker(format!("no thread for the emulated tracker: {e}")))?;
        Ok(Self { server, stop: Some(stop), thread: Some(thread) })
    }

    /// The server, to break it.
    pub fn server(&self) -> MutexGuard<'_, PoseServer> {
        lock(&self.server)
    }
}

impl Drop for Delivery {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing left to end.
            let _ = thread.join();
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A fault elsewhere does not stop the tracker.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
