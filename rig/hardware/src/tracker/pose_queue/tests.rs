use super::*;

fn queue() -> PoseQueue {
    PoseQueue::new(Some("Tip".into()), 0.0, 0.25, PoseLimits::default())
}

fn tool(name: &str, x: f64, time: Option<f64>) -> DecodedMessage {
    let pose =
        ToolPose { position: [x, 0.0, 0.0], orientation: [1.0, 0.0, 0.0, 0.0], validity: Validity::Valid };
    DecodedMessage::Message(Message { device: name.into(), time, content: MessageContent::Transform(pose) })
}

fn kinds(queue: &PoseQueue) -> Vec<EventKind> {
    queue.events.iter().map(|event| event.kind).collect()
}

#[test]
fn first_tool_is_kept_if_none_is_named() {
    let mut queue = PoseQueue::new(None, 0.0, 0.25, PoseLimits::default());
    queue.take(tool("Base", 0.0, None), 0.1);
    queue.take(tool("Tip", 0.5, None), 0.2);
    queue.take(tool("Base", 0.001, None), 0.3);
    assert_eq!(queue.poses.len(), 2);
    assert_eq!((queue.counts.poses, queue.counts.skipped), (2, 1));
}

#[test]
fn repeated_stamps_and_poses_from_the_past_are_left_out() {
    let mut queue = queue();
    for (stamp, arrival) in [(5.0, 0.1), (5.0, 0.12), (5.02, 0.14), (5.01, 0.16), (5.1, 0.2)] {
        queue.take(tool("Tip", 1e-3 * arrival, Some(stamp)), arrival);
    }
    assert_eq!((queue.counts.poses, queue.counts.repeated), (3, 2));
    let times: Vec<f64> = queue.poses.iter().map(|pose| pose.time).collect();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
}

#[test]
fn staleness_is_logged_once_and_names_the_other_tools() {
    let mut queue = queue();
    queue.connected(1.0);
    queue.take(tool("Base", 0.0, None), 1.1);
    queue.tick(1.2);
    assert!(queue.events.is_empty());
    queue.tick(1.26);
    queue.tick(5.0);
    assert_eq!(kinds(&queue), [EventKind::TrackerStale]);
    assert!(queue.events[0].message.ends_with("the tracker also sends Base"), "{}", queue.events[0].message);
    queue.take(tool("Tip", 0.0, None), 5.1);
    queue.tick(5.4);
    assert_eq!(kinds(&queue), [EventKind::TrackerStale; 2]);
}

#[test]
fn floods_of_damage_become_an_event_per_second_and_all_are_counted() {
    let mut queue = queue();
    for k in 0..400 {
        let now = 0.01 * f64::from(k);
        queue.connected(now);
        queue.take(DecodedMessage::Damaged("wrong".into()), now);
        queue.tick(now);
    }
    queue.tick(10.0);
    assert_eq!(queue.counts.damaged, 400);
    let logged: Vec<&Event> = queue.events.iter().filter(|e| e.kind == EventKind::TrackerCorrupt).collect();
    assert_eq!(logged.len(), 5, "{logged:?}");
    assert_eq!(logged[0].message, "wrong");
    assert_eq!(logged[1].message, "wrong; 100 such since the last report");
}

#[test]
fn suspicious_poses_are_passed_on_with_their_quality() {
    let mut queue = queue();
    queue.take(tool("Tip", 0.0, None), 0.0);
    queue.take(tool("Tip", 0.5, None), 0.02);
    assert_eq!(queue.poses[1].quality, Quality::Jump);
    assert_eq!(kinds(&queue), [EventKind::TrackerQuality]);
    assert_eq!(queue.counts.doubtful, 1);
}

#[test]
fn queue_is_bounded() {
    let mut queue = queue();
    for k in 0..MAX_QUEUED + 10 {
        queue.take(tool("Tip", 0.0, None), k as f64);
    }
    assert_eq!((queue.poses.len(), queue.counts.overflowed), (MAX_QUEUED, 10));
}

#[test]
fn an_invalid_pose_names_the_reason() {
    let pose = |validity| ToolPose { position: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0], validity };
    for (validity, part) in [
        (Validity::Zeros, "a matrix of zeros"),
        (Validity::Identity, "the identity, to the last bit"),
        (Validity::NoRotation, "stretched, sheared or mirrored"),
        (Validity::Marked, "marked as invalid"),
    ] {
        let mut queue = queue();
        let content = MessageContent::Transform(pose(validity));
        queue.take(DecodedMessage::Message(Message { device: "Tip".into(), time: Some(1.0), content }), 5.0);
        let messages = queue.events.iter().map(|event| event.message.clone()).collect::<Vec<_>>().join("; ");
        assert!(messages.contains(part), "{messages}");
        assert!(queue.poses.iter().all(|pose| pose.quality == Quality::Flagged));
    }
}
