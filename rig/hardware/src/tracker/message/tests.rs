use super::super::{DecodedMessage, MessageDecoder};
use super::*;

/// Rounding of an `f32` [-], of the largest value.
const SINGLE: f64 = 6e-8;

fn unit(q: [f64; 4]) -> [f64; 4] {
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / norm)
}

fn decode(bytes: &[u8]) -> Vec<DecodedMessage> {
    let mut all = Vec::new();
    MessageDecoder::new().decode(bytes, |decoded| all.push(decoded));
    all
}

fn decode_one(bytes: &[u8]) -> Message {
    match decode(bytes).as_slice() {
        [DecodedMessage::Message(message)] => message.clone(),
        other => panic!("{other:?}"),
    }
}

fn close(a: &ToolPose, b: &ToolPose) {
    assert_eq!(a.validity, b.validity);
    for k in 0..3 {
        assert!((a.position[k] - b.position[k]).abs() <= SINGLE * b.position[k].abs(), "{a:?} {b:?}");
    }
    let dot: f64 = a.orientation.iter().zip(b.orientation).map(|(x, y)| x * y).sum();
    // sin² of half the angle, with the rounding of nine entries.
    assert!(1.0 - dot * dot < (10.0 * SINGLE).powi(2) + 1e-15, "{a:?} {b:?}");
}

fn poses() -> Vec<ToolPose> {
    let mut all = Vec::new();
    for w in [-1.0, 0.0, 1e-4, 1.0] {
        for x in [-1.0, 0.0, 1.0] {
            for y in [-0.5, 0.0, 1.0] {
                for z in [0.0, 1e-9, 1.0] {
                    if w != 0.0 || x != 0.0 || y != 0.0 || z != 0.0 {
                        let position = [0.1 * x, -0.02, 1.0 + z];
                        all.push(ToolPose {
                            position,
                            orientation: unit([w, x, y, z]),
                            validity: Validity::Valid,
                        });
                    }
                }
            }
        }
    }
    all
}

#[test]
fn poses_survive_every_type_and_protocol() {
    let mut n_poses = 0;
    for pose in poses() {
        for protocol in [MessageFormat::Plain, MessageFormat::WithStatus] {
            let other = ToolPose { position: [1.0, 2.0, 3.0], ..pose };
            for content in [
                MessageContent::Transform(pose),
                MessageContent::Position(pose),
                MessageContent::Tools(vec![("Tip".into(), pose), ("Base".into(), other)]),
            ] {
                let message = Message { device: "Tip".into(), time: Some(1.7e9 + 0.25), content };
                let mut back = decode_one(&message.to_bytes(protocol));
                assert_eq!((back.device.as_str(), back.time), ("Tip", message.time));
                let (mut sent, mut n) = (message.clone(), 0);
                for (a, b) in back.poses_mut().zip(sent.poses_mut()) {
                    close(a, b);
                    n += 1;
                }
                assert_eq!(std::mem::discriminant(&back.content), std::mem::discriminant(&message.content));
                n_poses += n;
            }
        }
    }
    assert_eq!(n_poses, poses().len() * 8);
}

#[test]
fn bytes_are_those_of_pyigtl() {
    // Made with pyigtl 0.3.4: TransformMessage, no rotation, 1 2 3 mm, time 2.5 s, device Tip; header version 1, then 2
    // with TipTransformStatus.
    let plain = "00015452414e53464f524d00000054697000000000000000000000000000000000000000000280000000000000\
        0000000030acf68624880f705e3f8000000000000000000000000000003f800000000000000000000000000000\
        3f8000003f8000004000000040400000";
    let with_status = "00025452414e53464f524d00000054697000000000000000000000000000000000000000000280000000000000\
        000000005a5e0e409e5946c7d2000c000a00000014000000003f8000000000000000000000000000003f800000\
        0000000000000000000000003f8000003f8000004000000040400000000100120003000000025469705472616e\
        73666f726d5374617475734f4b";
    let pose = ToolPose {
        position: [1e-3, 2e-3, 3e-3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        validity: Validity::Valid,
    };
    let message = Message { device: "Tip".into(), time: Some(2.5), content: MessageContent::Transform(pose) };
    for (expected, protocol) in [(plain, MessageFormat::Plain), (with_status, MessageFormat::WithStatus)] {
        let hex: String = message.to_bytes(protocol).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex, expected);
    }
}

#[test]
fn invalid_poses_are_distinguished_from_others() {
    let pose =
        ToolPose { position: [0.1, 0.2, 0.3], orientation: [1.0, 0.0, 0.0, 0.0], validity: Validity::Marked };
    for content in [
        MessageContent::Transform(pose),
        MessageContent::Position(pose),
        MessageContent::Tools(vec![("Tip".into(), pose)]),
    ] {
        let message = Message { device: "Tip".into(), time: None, content };
        let mut back = decode_one(&message.to_bytes(MessageFormat::WithStatus));
        assert_eq!(back.time, None);
        assert!(back.poses_mut().all(|pose| !pose.is_valid()));
    }
    let message = Message { device: "Tip".into(), time: None, content: MessageContent::Transform(pose) };
    let mut back = decode_one(&message.to_bytes(MessageFormat::Plain));
    assert!(back.poses_mut().all(|pose| !pose.is_valid() && pose.orientation == [1.0, 0.0, 0.0, 0.0]));
}

/// A plain TRANSFORM with these twelve numbers.
fn transform(values: [f32; 12]) -> Vec<u8> {
    let body: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
    let pose = ToolPose { position: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0], validity: Validity::Valid };
    let message = Message { device: "Tip".into(), time: None, content: MessageContent::Transform(pose) };
    frame(1, "TRANSFORM", &message, &body)
}

#[test]
fn what_is_no_rotation_is_invalid_and_what_is_no_number_is_damage() {
    let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 10.0, 20.0, 30.0];
    let valid = |values| match decode_one(&transform(values)).content {
        MessageContent::Transform(pose) => {
            assert_eq!(pose.position, [10.0, 20.0, 30.0].map(|x| x * 1e-3));
            pose.is_valid()
        }
        other => panic!("{other:?}"),
    };
    let with = |at: usize, value| {
        let mut values = identity;
        values[at] = value;
        values
    };
    assert!(valid(identity));
    assert!(valid(with(0, 1.0004)), "0.8e-3 in RᵀR is rounding");
    assert!(!valid(with(0, 1.0006)), "1.2e-3 is not");
    assert!(!valid(with(0, -1.0)), "a mirror image");
    assert!(!valid(with(4, 0.0)));
    for value in [f32::NAN, f32::INFINITY] {
        let bytes = transform(with(7, value));
        assert!(matches!(&decode(&bytes)[..], [DecodedMessage::Damaged(what)] if what.contains("number 8")));
    }
}

#[test]
fn status_of_another_transform_is_not_ours() {
    let meta = |key: &str, value: &str| {
        let mut bytes = vec![0, 1];
        bytes.extend((key.len() as u16).to_be_bytes());
        bytes.extend([0, 3]);
        bytes.extend((value.len() as u32).to_be_bytes());
        bytes.extend(key.bytes().chain(value.bytes()));
        read_status(&bytes, 10, "ProbeToTracker")
    };
    assert_eq!(meta("ProbeToTrackerTransformStatus", "OK"), Some(Some(true)));
    assert_eq!(meta("ProbeToTrackerTransformStatus", "SWITCH1_ON"), Some(Some(true)));
    assert_eq!(meta("TransformStatus", "ok"), Some(Some(true)));
    for bad in ["MISSING", "INVALID", "OUT_OF_VIEW", "UNKNOWN", ""] {
        assert_eq!(meta("ProbeToTrackerTransformStatus", bad), Some(Some(false)));
        assert_eq!(meta("Status", bad), Some(Some(false)));
    }
    assert_eq!(meta("StylusToTrackerTransformStatus", "MISSING"), Some(None));
    assert_eq!(meta("Depth", "MISSING"), Some(None));
    assert_eq!(read_status(&[0, 1, 0, 9], 4, ""), None, "an index that is cut off");
    assert_eq!(read_status(&[0, 0], 4, ""), None);
}

#[test]
fn status_and_requests() {
    let content = MessageContent::Status { code: 13, text: "sensor not ready".into() };
    let message = Message { device: "NDI".into(), time: None, content };
    for protocol in [MessageFormat::Plain, MessageFormat::WithStatus] {
        assert_eq!(decode_one(&message.to_bytes(protocol)), message);
    }
    let bytes = start_request("Tip", 0.025);
    assert_eq!(&bytes[2..11], b"STT_TDATA");
    assert_eq!(bytes[HEADER..HEADER + 4], [0, 0, 0, 25]);
    assert_eq!(bytes.len(), HEADER + 36);
    assert_eq!(decode(&bytes), [DecodedMessage::Skipped { kind: "STT_TDATA".into(), device: "Tip".into() }]);
}

#[test]
fn time_stamps_are_32_bits_of_seconds_and_32_of_their_fraction() {
    assert_eq!(stamp(Some(1.5)), (1 << 32) | (1 << 31));
    assert_eq!(seconds((7 << 32) | (1 << 30)), 7.25);
    assert_eq!((stamp(None), stamp(Some(-1.0)), stamp(Some(f64::NAN))), (0, 0, 0));
    let now = 1_790_000_000.123_456_7;
    assert_eq!(seconds(stamp(Some(now))), now);
}

#[test]
fn long_names_are_cut_at_a_character() {
    let pose = poses()[0];
    let name = "Spitzenfühler-ÄÖÜÄÖÜ".to_owned();
    let message = Message { device: name.clone(), time: None, content: MessageContent::Transform(pose) };
    let back = decode_one(&message.to_bytes(MessageFormat::Plain));
    assert!(name.starts_with(&back.device) && back.device.len() == 19, "{}", back.device);
}

#[test]
fn quaternion_tracking_data_of_the_published_layout_are_read() {
    // Name (20), type, reserved, position x y z [mm], quaternion x y z w: 50 bytes a tool.
    let tool = |name: &str, values: [f32; 7]| {
        let mut bytes = padded::<20>(name).to_vec();
        bytes.extend([2, 0]);
        bytes.extend(values.iter().flat_map(|value| value.to_be_bytes()));
        bytes
    };
    let half = 0.5_f32.sqrt();
    let body = [
        tool("Tip", [10.0, -20.0, 30.0, 0.0, 0.0, half, half]),
        tool("Base", [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 2.0]),
        tool("Gone", [0.0; 7]),
    ]
    .concat();
    assert_eq!(body.len(), 150);
    let empty =
        Message { device: "Tracker".into(), time: Some(1.0), content: MessageContent::Tools(Vec::new()) };
    let MessageContent::Tools(tools) = decode_one(&frame(1, "QTDATA", &empty, &body)).content else {
        panic!("no tools")
    };
    let (name, tip) = &tools[0];
    assert_eq!((name.as_str(), tip.validity), ("Tip", Validity::Valid));
    assert_eq!(tip.position.map(|x| (1e6 * x).round()), [10_000.0, -20_000.0, 30_000.0]);
    let expected = [f64::from(half), 0.0, 0.0, f64::from(half)];
    assert!(tip.orientation.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-7), "{tip:?}");
    assert_eq!(tools[1].1.validity, Validity::NoRotation);
    assert_eq!(tools[2].1.validity, Validity::Zeros);
    let cut = decode(&frame(1, "QTDATA", &empty, &body[..149]));
    assert!(
        matches!(&cut[..], [DecodedMessage::Damaged(what), ..] if what.contains("QTDATA with a body of 149")),
        "{cut:?}"
    );
}

#[test]
fn what_is_no_pose_is_named() {
    let validity = |values| match decode_one(&transform(values)).content {
        MessageContent::Transform(pose) => pose.validity,
        other => panic!("{other:?}"),
    };
    let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    let with = |at: usize, value: f32| {
        let mut values = identity;
        values[at] = value;
        values
    };
    assert_eq!(validity([0.0; 12]), Validity::Zeros);
    assert_eq!(validity(identity), Validity::Identity);
    assert_eq!(validity(with(9, 1e-3)), Validity::Valid, "a place that somebody measured");
    assert_eq!(validity(with(0, 1000.0)), Validity::NoRotation);
    for named in [Validity::Zeros, Validity::Identity, Validity::NoRotation] {
        assert!(named.words().contains("hint"));
    }
}
