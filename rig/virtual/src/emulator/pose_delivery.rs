//! The emulated tracker in real time: a thread that takes poses from a world and serves them.

use super::pose_server::{PoseFaults, PoseServer};
use crate::virtual_rig::{TrackedPose, World};
use hysteron_rig::{Error, Result};
use std::collections::VecDeque;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Pause of the thread.
const BEAT: Duration = Duration::from_millis(1);

/// A thread that serves the poses of a world while someone else lets its time pass. Dropping it ends the thread.
#[derive(Debug)]
pub struct PoseDelivery {
    server: Arc<Mutex<PoseServer>>,
    /// The thread ends when this end of the channel is gone.
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl PoseDelivery {
    /// Serves each pose when the world's time reaches the moment at which it leaves the tracker. `faults` is asked
    /// every millisecond what is broken.
    ///
    /// # Errors
    /// `Tracker` if there can be no thread.
    pub fn start(
        world: Arc<Mutex<World>>,
        server: PoseServer,
        faults: impl FnMut() -> PoseFaults + Send + 'static,
    ) -> Result<Self> {
        let take = move |poses: &mut Vec<TrackedPose>| {
            let mut world = lock(&world);
            world.take_poses(poses);
            world.time()
        };
        Self::of(take, server, faults)
    }

    /// The same from a function that appends poses and returns the time [s].
    fn of(
        mut take: impl FnMut(&mut Vec<TrackedPose>) -> f64 + Send + 'static,
        server: PoseServer,
        mut faults: impl FnMut() -> PoseFaults + Send + 'static,
    ) -> Result<Self> {
        let server = Arc::new(Mutex::new(server));
        let (stop, stopped) = channel();
        let shared = server.clone();
        let work = move || {
            let (mut taken, mut waiting) = (Vec::new(), VecDeque::new());
            while stopped.recv_timeout(BEAT) == Err(RecvTimeoutError::Timeout) {
                let now = take(&mut taken);
                waiting.extend(taken.drain(..));
                let mut server = lock(&shared);
                if server.set_faults(faults()).is_err() {
                    // Someone took the port of the unplugged server: it is tried again at the next beat.
                    continue;
                }
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

    /// The server.
    pub fn server(&self) -> MutexGuard<'_, PoseServer> {
        lock(&self.server)
    }
}

impl Drop for PoseDelivery {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::super::pose_server::{DeviceClock, Format, PoseServerSettings};
    use super::*;
    use hysteron_rig::tracker::{Client, TrackerSettings};
    use hysteron_rig::{Event, EventKind, Pose, Quality};
    use std::time::Instant;

    #[test]
    fn poses_leave_when_due_and_faults_show_at_the_client() {
        let start = Instant::now();
        let clock = DeviceClock { offset: 1e6, drift: 0.0 };
        let settings =
            PoseServerSettings { port: 0, device: "Tip".into(), clock, format: Format::TransformWithStatus };
        let server = PoseServer::start(settings).unwrap();
        let client = Client::connect(TrackerSettings::new(server.address().to_string()), start).unwrap();
        // Measured every 10 ms, sent 20 ms later; handed over as soon as they are measured.
        let mut n = 0;
        let take = move |poses: &mut Vec<TrackedPose>| {
            let now = start.elapsed().as_secs_f64();
            while 0.01 * f64::from(n) < now {
                let time = 0.01 * f64::from(n);
                let position = [1e-6 * f64::from(n), 0.0, 0.0];
                let orientation = [1.0, 0.0, 0.0, 0.0];
                let pose = Pose { time, position, orientation, quality: Quality::Good };
                poses.push(TrackedPose { pose, sent_at: time + 0.02 });
                n += 1;
            }
            now
        };
        let faults = Arc::new(Mutex::new(PoseFaults::default()));
        let shared = faults.clone();
        let delivery = PoseDelivery::of(take, server, move || *lock(&shared)).unwrap();
        let (mut poses, mut events) = (Vec::new(), Vec::new());
        let mut wait = |what: &str, faulty: PoseFaults, done: &dyn Fn(&[Pose], &[Event]) -> bool| {
            *lock(&faults) = faulty;
            poses.clear();
            events.clear();
            let begin = Instant::now();
            while !done(&poses, &events) {
                assert!(begin.elapsed().as_secs() < 20, "{what}: {events:?} {:?}", client.counts());
                std::thread::sleep(BEAT);
                client.take_poses(&mut poses);
                client.take_events(&mut events);
            }
        };
        let well = PoseFaults::default();
        let is_well = |poses: &[Pose], _: &[Event]| poses.last().is_some_and(|p| p.quality == Quality::Good);
        let seen = |quality| move |poses: &[Pose], _: &[Event]| poses.iter().any(|p| p.quality == quality);
        let logged = |kind| move |_: &[Pose], events: &[Event]| events.iter().any(|event| event.kind == kind);
        wait("a pose", well, &is_well);
        assert!(start.elapsed().as_secs_f64() > 0.02, "not before it is due");
        wait("invalid", PoseFaults { invalid: true, ..well }, &seen(Quality::Flagged));
        wait("valid", well, &is_well);
        wait("elsewhere", PoseFaults { displaced: true, ..well }, &seen(Quality::Jump));
        wait("back", well, &is_well);
        // Long enough to learn that this tracker never repeats itself.
        wait("many poses", well, &|poses, _| poses.len() > 60);
        wait("frozen", PoseFaults { frozen: true, ..well }, &seen(Quality::Frozen));
        wait("thawed", well, &is_well);
        wait("silent", PoseFaults { silent: true, ..well }, &logged(EventKind::TrackerStale));
        wait("damaged", PoseFaults { damaged: true, ..well }, &logged(EventKind::TrackerCorrupt));
        wait("unplugged", PoseFaults { unplugged: true, ..well }, &logged(EventKind::TrackerLost));
        wait("plugged", well, &logged(EventKind::TrackerBack));
        assert_eq!(delivery.server().n_clients(), 1);
    }
}
