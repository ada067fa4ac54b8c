//! A tracker's server: poses over OpenIGTLink to every client, with the faults of real ones.
//!
//! It has no thread of its own and never waits: connections are taken, read and written whenever it is called, and
//! a client that does not read loses poses, not others theirs.

use crate::virtual_rig::TrackedPose;
use hysteron_rig::tracker::{Message, MessageContent, MessageFormat, ToolPose, Validity};
use hysteron_rig::{Error, Pose, Quality, Result};
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};

/// Most bytes that wait for a slow client.
const MAX_PENDING: usize = 64 * 1024;
/// Displacement of a tracker that sends poses from elsewhere [m].
const ELSEWHERE: f64 = 0.1;

/// The clock that stamps the poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceClock {
    /// Reading at time 0 of the world [s]; at least 0.
    pub offset: f64,
    /// How much faster it runs [-].
    pub drift: f64,
}

impl DeviceClock {
    /// Reading of the clock [s] at a time of the world [s].
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

/// Settings of the pose server.
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

/// Active faults of the pose server.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PoseFaults {
    /// All connections break, and none can be made.
    pub unplugged: bool,
    /// Nothing is sent.
    pub silent: bool,
    /// All poses are marked as invalid.
    pub invalid: bool,
    /// The last pose is sent again and again, with new time stamps.
    pub frozen: bool,
    /// All poses are off by 100 mm.
    pub displaced: bool,
    /// A bit of every message is turned, so that its checksum is wrong.
    pub damaged: bool,
}

/// The server. Dropping it closes all connections.
#[derive(Debug)]
pub struct PoseServer {
    listener: Option<TcpListener>,
    address: SocketAddr,
    settings: PoseServerSettings,
    clients: Vec<Connection>,
    faults: PoseFaults,
    /// Last pose that was not frozen.
    last: Option<Pose>,
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
        Ok(Self {
            listener: Some(listener),
            address,
            settings,
            clients: Vec::new(),
            faults: PoseFaults::default(),
            last: None,
            n_to_corrupt: 0,
        })
    }

    /// Where clients connect to.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Number of clients at the last call of [`poll`](Self::poll).
    pub fn n_clients(&self) -> usize {
        self.clients.len()
    }

    /// Takes new clients, drops those that left, and sends what waits for slow ones.
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
        if self.faults.silent {
            return;
        }
        let mut pose = self.last.filter(|_| self.faults.frozen).unwrap_or(tracked.pose);
        self.last = Some(pose);
        if self.faults.displaced {
            pose.position[0] += ELSEWHERE;
        }
        let time = Some(self.settings.clock.show(tracked.pose.time));
        let is_flagged = tracked.pose.quality == Quality::Flagged || self.faults.invalid;
        let validity = if is_flagged { Validity::Marked } else { Validity::Valid };
        let tool = ToolPose { position: pose.position, orientation: pose.orientation, validity };
        let device = self.settings.device.clone();
        let (content, protocol) = match self.settings.format {
            Format::Transform => (MessageContent::Transform(tool), MessageFormat::Plain),
            Format::TransformWithStatus => (MessageContent::Transform(tool), MessageFormat::WithStatus),
            Format::Position => (MessageContent::Position(tool), MessageFormat::WithStatus),
            Format::Tools => (MessageContent::Tools(vec![(device.clone(), tool)]), MessageFormat::Plain),
        };
        let mut bytes = Message { device, time, content }.to_bytes(protocol);
        if self.faults.damaged || self.n_to_corrupt > 0 {
            self.n_to_corrupt = self.n_to_corrupt.saturating_sub(1);
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
            if client.pending.len() + bytes.len() <= MAX_PENDING {
                client.pending.extend_from_slice(bytes);
            }
        }
        self.clients.retain_mut(Connection::flush);
    }

    /// Turns a bit in each of the next `n` poses, so that their checksum is wrong.
    pub fn corrupt_next(&mut self, n: usize) {
        self.n_to_corrupt = n;
    }

    /// Breaks this and mends the rest.
    ///
    /// # Errors
    /// `Tracker` if the server was unplugged and its port has been taken meanwhile; it stays unplugged then.
    pub fn set_faults(&mut self, faults: PoseFaults) -> Result<()> {
        let was_unplugged = self.faults.unplugged;
        self.faults = PoseFaults { unplugged: was_unplugged, ..faults };
        match (was_unplugged, faults.unplugged) {
            (false, true) => self.unplug(),
            (true, false) => self.plug()?,
            _ => {}
        }
        self.faults = faults;
        Ok(())
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
