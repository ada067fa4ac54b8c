//! The tracker's client against the pose server, over the loopback; and the decoder against anything.

use hysteron_rig::tracker::{
    Client, DecodedMessage, MAX_BUFFERED, MAX_DRIFT, Message, MessageContent, MessageDecoder, MessageFormat,
    ToolPose, TrackerSettings, Validity,
};
use hysteron_rig::{Event, EventKind, Pose, Quality};
use hysteron_virtual_rig::emulator::{DeviceClock, Format, PoseServer, PoseServerSettings};
use hysteron_virtual_rig::virtual_rig::TrackedPose;
use proptest::prelude::*;
use std::time::{Duration, Instant};

/// Longest wait for what must come, on however busy a machine.
const PATIENCE: Duration = Duration::from_secs(20);

/// Server and client on one host clock, and what came.
struct Bench {
    start: Instant,
    server: PoseServer,
    client: Client,
    poses: Vec<Pose>,
    events: Vec<Event>,
    n_sent: usize,
}

fn server(format: Format) -> PoseServer {
    let clock = DeviceClock { offset: 1.7e9, drift: 100e-6 };
    PoseServer::start(PoseServerSettings { port: 0, device: "Tip".into(), clock, format }).unwrap()
}

impl Bench {
    fn new(format: Format, change: impl FnOnce(&mut TrackerSettings)) -> Self {
        let start = Instant::now();
        let server = server(format);
        let mut settings = TrackerSettings::new(server.address().to_string());
        settings.device = Some("Tip".into());
        settings.stale_after = 5.0; // a busy machine is no fault
        change(&mut settings);
        let client = Client::connect(settings, start).unwrap();
        Self { start, server, client, poses: Vec::new(), events: Vec::new(), n_sent: 0 }
    }

    fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Sends pose number `n_sent`, 10 µm from the one before.
    fn send(&mut self, quality: Quality) -> Pose {
        let time = self.now();
        let x = 1e-5 * self.n_sent as f64;
        let h = std::f64::consts::FRAC_1_SQRT_2;
        let pose = Pose { time, position: [x, 0.1, -0.2], orientation: [h, h, 0.0, 0.0], quality };
        self.n_sent += 1;
        self.server.send(&TrackedPose { pose, sent_at: time });
        pose
    }

    fn take(&mut self) {
        self.client.take_poses(&mut self.poses);
        self.client.take_events(&mut self.events);
    }

    /// Goes on, polling, until that is true.
    fn wait(&mut self, what: &str, mut done: impl FnMut(&mut Self) -> bool) {
        let begin = Instant::now();
        while !done(self) {
            assert!(begin.elapsed() < PATIENCE, "{what}: {:?} {:?}", self.client.counts(), self.events);
            std::thread::sleep(Duration::from_micros(200));
            self.server.poll();
            self.take();
        }
    }

    /// Sends until a pose arrives, and nothing is under way any more. (A pose just behind another can be left out,
    /// when a better estimate of the clock puts it before that one.)
    fn wait_for_pose(&mut self) {
        let mut last = self.send(Quality::Good).position;
        let mut sent = Instant::now();
        self.wait("a pose", |bench| {
            let is_last = bench.poses.last().is_some_and(|pose| (pose.position[0] - last[0]).abs() < 1e-6);
            if !is_last && sent.elapsed() > Duration::from_millis(50) {
                last = bench.send(Quality::Good).position;
                sent = Instant::now();
            }
            is_last
        });
    }

    fn has(&self, kind: EventKind) -> bool {
        self.events.iter().any(|event| event.kind == kind)
    }
}

#[test]
fn poses_arrive_in_order_at_the_time_when_they_were_measured() {
    for format in [Format::Transform, Format::TransformWithStatus, Format::Position, Format::Tools] {
        let mut bench = Bench::new(format, |_| {});
        bench.wait("a connection", |bench| bench.server.n_clients() == 1);
        let (mut sent, mut taken) = (Vec::new(), Vec::new());
        for k in 0..200 {
            sent.push(bench.send(Quality::Good));
            bench.wait("the pose", |bench| bench.client.counts().poses + bench.client.counts().repeated > k);
            bench.take();
            taken.push(bench.now());
        }
        assert!(bench.poses.len() > 100, "few are left out");
        for pose in &bench.poses {
            let k = (pose.position[0] / 1e-5).round() as usize;
            // f32, 0.2 m.
            assert!((0..3).all(|i| (pose.position[i] - sent[k].position[i]).abs() < 2e-8));
            assert!((0..4).all(|i| (pose.orientation[i] - sent[k].orientation[i]).abs() < 1e-6));
            assert_eq!(pose.quality, Quality::Good);
            // The bound of the clock map; a delay on the way is at most that until the pose was taken.
            let drift = MAX_DRIFT + 100e-6;
            let late = |i: usize| taken[i] - sent[i].time + drift * (taken[k] - sent[i].time);
            let bound = (0..=k).map(late).fold(f64::INFINITY, f64::min);
            let error = pose.time - sent[k].time;
            let early = drift * (taken[k] - sent[k].time) + 1e-6;
            assert!(error >= -early && error <= bound + early, "{format:?} {k}: {error} s, bound {bound} s");
        }
        assert!(bench.poses.windows(2).all(|pair| pair[0].time < pair[1].time));
        assert!(bench.events.is_empty() && bench.client.is_connected(), "{:?}", bench.events);
    }
}

#[test]
fn cable_pulled_and_put_back() {
    let mut bench = Bench::new(Format::TransformWithStatus, |_| {});
    bench.wait_for_pose();
    assert!(bench.client.is_connected());
    bench.server.unplug();
    bench.wait("loss", |bench| bench.has(EventKind::TrackerLost));
    assert!(!bench.client.is_connected());
    bench.server.plug().unwrap();
    bench.wait_for_pose();
    assert!(bench.client.is_connected());
    bench.server.drop_clients();
    bench.wait_for_pose();
    let kinds: Vec<EventKind> = bench.events.iter().map(|event| event.kind).collect();
    use EventKind::{TrackerBack, TrackerLost};
    assert_eq!(kinds, [TrackerLost, TrackerBack, TrackerLost, TrackerBack]);
    assert!(bench.events.windows(2).all(|pair| pair[0].time_s <= pair[1].time_s));
}

#[test]
fn damage_is_counted_and_costs_no_other_pose() {
    let mut bench = Bench::new(Format::Transform, |_| {});
    bench.wait_for_pose();
    let n_placed = |bench: &Bench| bench.client.counts().poses + bench.client.counts().repeated;
    let n = n_placed(&bench);
    bench.server.corrupt_next(3);
    for _ in 0..10 {
        bench.send(Quality::Good);
    }
    bench.server.send_bytes(&[0xA5; 500]);
    for _ in 0..10 {
        bench.send(Quality::Good);
    }
    bench.wait("the intact poses", |bench| n_placed(bench) == n + 17);
    assert_eq!(bench.client.counts().damaged, 4, "three poses and the garbage");
    bench.take();
    assert!(bench.has(EventKind::TrackerCorrupt));
}

#[test]
fn silence_is_stale_then_given_up_and_poses_come_again() {
    let mut bench = Bench::new(Format::Transform, |settings| settings.stale_after = 0.05);
    bench.wait_for_pose();
    bench.wait("staleness", |bench| bench.has(EventKind::TrackerStale));
    bench.wait("loss", |bench| bench.has(EventKind::TrackerLost));
    let lost = bench.events.iter().find(|event| event.kind == EventKind::TrackerLost).unwrap();
    assert!(lost.message.contains("no message for"), "{}", lost.message);
    bench.wait_for_pose();
    bench.wait("return", |bench| bench.has(EventKind::TrackerBack));
}

#[test]
fn invalid_poses_are_flagged() {
    for format in [Format::Transform, Format::TransformWithStatus, Format::Position, Format::Tools] {
        let mut bench = Bench::new(format, |_| {});
        bench.wait_for_pose();
        bench.wait("a flagged pose and its event", |bench| {
            bench.send(Quality::Flagged);
            let last = bench.poses.last().is_some_and(|pose| pose.quality == Quality::Flagged);
            last && bench.has(EventKind::TrackerQuality)
        });
        bench.wait_for_pose();
        assert_eq!(bench.poses.last().unwrap().quality, Quality::Good);
    }
}

#[test]
fn a_reset_clock_of_the_tracker_is_followed() {
    let mut bench = Bench::new(Format::Transform, |_| {});
    bench.wait_for_pose();
    bench.server.set_clock(DeviceClock { offset: 3.0, drift: -50e-6 });
    bench.wait_for_pose();
    let last = *bench.poses.last().unwrap();
    assert!(last.time <= bench.now() && last.time > bench.now() - PATIENCE.as_secs_f64());
    assert!(bench.client.counts().unplaced >= 4 && bench.has(EventKind::TrackerQuality));
    assert!(bench.poses.windows(2).all(|pair| pair[0].time < pair[1].time));
}

#[test]
fn client_that_never_reads_holds_up_no_one() {
    let mut bench = Bench::new(Format::Transform, |_| {});
    let lazy = std::net::TcpStream::connect(bench.server.address()).unwrap();
    bench.wait("both", |bench| bench.server.n_clients() == 2);
    // 20 MB: more than the system keeps for a connection.
    for _ in 0..200_000 {
        bench.send(Quality::Good);
    }
    bench.take();
    bench.wait_for_pose();
    drop(lazy);
    bench.wait("the departure", |bench| bench.server.n_clients() == 1);
}

#[test]
fn other_messages_of_the_stream() {
    let mut bench = Bench::new(Format::Transform, |settings| settings.request_interval = Some(0.025));
    bench.wait_for_pose();
    let status = MessageContent::Status { code: 13, text: "field generator off".into() };
    let message = Message { device: "NDI".into(), time: None, content: status };
    bench.server.send_bytes(&message.to_bytes(MessageFormat::Plain));
    bench.wait("the status", |bench| bench.has(EventKind::TrackerQuality));
    assert!(bench.events[0].message.contains("field generator off"), "{:?}", bench.events);
    let skipped = bench.client.counts().skipped;
    let pose = ToolPose { position: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0], validity: Validity::Valid };
    let other = Message { device: "Base".into(), time: None, content: MessageContent::Transform(pose) };
    bench.server.send_bytes(&other.to_bytes(MessageFormat::WithStatus));
    bench.wait("the other tool", |bench| bench.client.counts().skipped == skipped + 1);
}

#[test]
fn silence_is_an_event_and_damage_an_error() {
    let address = server(Format::Transform).address().to_string(); // and gone again
    let client = Client::connect(TrackerSettings::new(&address), Instant::now()).unwrap();
    let error = client.wait_for_pose(0.3).unwrap_err().to_string();
    assert!(error.contains(&address), "{error}");
    let mut events = Vec::new();
    client.take_events(&mut events);
    assert_eq!(events.iter().map(|event| event.kind).collect::<Vec<_>>(), [EventKind::TrackerLost]);

    let bad = |change: fn(&mut TrackerSettings)| {
        let mut settings = TrackerSettings::new("127.0.0.1:18944");
        change(&mut settings);
        Client::connect(settings, Instant::now()).unwrap_err().bad_input().unwrap().place.clone()
    };
    assert_eq!(bad(|s| s.address = "127.0.0.1".into()), "tracker address");
    assert_eq!(bad(|s| s.address = String::new()), "tracker address");
    assert_eq!(bad(|s| s.latency = -1e-3), "tracker latency");
    assert_eq!(bad(|s| s.stale_after = f64::NAN), "longest time between poses");
    assert_eq!(bad(|s| s.request_interval = Some(0.0)), "interval of poses");
}

#[test]
fn port_in_use_is_refused() {
    let first = server(Format::Transform);
    let clock = DeviceClock { offset: 0.0, drift: 0.0 };
    let port = first.address().port();
    let settings = PoseServerSettings { port, device: "Tip".into(), clock, format: Format::Tools };
    assert!(PoseServer::start(settings).unwrap_err().to_string().contains(&port.to_string()));
}

/// Whole messages of all types.
fn message() -> impl Strategy<Value = Vec<u8>> {
    let pose = (prop::array::uniform3(-10.0..10.0), prop::array::uniform4(-1.0..1.0), any::<bool>());
    let pose = pose.prop_filter_map("a rotation", |(position, q, is_valid): ([f64; 3], [f64; 4], bool)| {
        let validity = if is_valid { Validity::Valid } else { Validity::Marked };
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        (norm > 1e-3).then(|| ToolPose { position, orientation: q.map(|x| x / norm), validity })
    });
    let content = (0..4, pose, 0_usize..4).prop_map(|(kind, pose, n)| match kind {
        0 => MessageContent::Transform(pose),
        1 => MessageContent::Position(pose),
        2 => MessageContent::Tools(vec![("Tip".into(), pose); n]),
        _ => MessageContent::Status { code: n as u16, text: "text".repeat(n) },
    });
    let protocol = prop_oneof![Just(MessageFormat::Plain), Just(MessageFormat::WithStatus)];
    (content, "[A-Za-z]{0,25}", prop::option::of(0.0..2e9), protocol)
        .prop_map(|(content, device, time, protocol)| Message { device, time, content }.to_bytes(protocol))
}

/// Cuts `bytes` into chunks of these sizes, again and again, and decodes them.
fn decode(bytes: &[u8], sizes: &[usize]) -> Vec<DecodedMessage> {
    let (mut decoder, mut all) = (MessageDecoder::new(), Vec::new());
    let mut rest = bytes;
    for size in sizes.iter().cycle() {
        if rest.is_empty() {
            break;
        }
        let (chunk, others) = rest.split_at((*size).min(rest.len()));
        decoder.decode(chunk, |decoded| all.push(decoded));
        assert!(decoder.n_buffered() <= MAX_BUFFERED);
        rest = others;
    }
    all
}

proptest! {
    #[test]
    fn decoder_survives_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..5000), sizes in prop::collection::vec(1_usize..600, 1..5)) {
        prop_assert_eq!(decode(&bytes, &sizes), decode(&bytes, &[usize::MAX]));
    }

    #[test]
    fn decoder_finds_all_whole_messages(messages in prop::collection::vec(message(), 0..30), sizes in prop::collection::vec(1_usize..600, 1..5)) {
        let all = decode(&messages.concat(), &sizes);
        prop_assert_eq!(all.len(), messages.len());
        prop_assert!(all.iter().all(|decoded| matches!(decoded, DecodedMessage::Message(_))));
    }

    #[test]
    fn decoder_survives_any_damage(
        messages in prop::collection::vec(message(), 1..30),
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..3, any::<u8>()), 1..10),
        sizes in prop::collection::vec(1_usize..600, 1..5),
    ) {
        let mut bytes = messages.concat();
        for (at, kind, value) in &edits {
            let at = at.index(bytes.len());
            match kind {
                0 => bytes[at] = *value,
                1 => bytes.insert(at, *value),
                _ => drop(bytes.drain(at..(at + usize::from(*value)).min(bytes.len() - 1).max(at))),
            }
        }
        prop_assert_eq!(decode(&bytes, &sizes), decode(&bytes, &[usize::MAX]));
    }
}
