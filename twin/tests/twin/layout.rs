//! The auxiliary cables of the CoReAct paper.

use hysteron_base::{AuxiliaryLayout, Bounds, MaterialLaw, PrescribedQuantity};
use hysteron_fem::{Layers, Order, Tube};
use hysteron_twin::{Target, Twin, auxiliary_tendons};

use super::{Robot, assert_close, distance, scenes, strokes};

/// 18 segments of 4 mm, two cables each, radius 6.0 mm (CoReAct paper, section V-A b).
fn layout() -> AuxiliaryLayout {
    AuxiliaryLayout {
        segments: 18,
        segment_length: 4e-3,
        start: 4e-3,
        radius: 6e-3,
        cables_per_segment: 2,
        first_plane: 0.0,
        plane_step: std::f64::consts::FRAC_PI_2,
        drive: PrescribedQuantity::Stroke,
        tension: Bounds { min: -10.0, max: 10.0 },
        stroke: Bounds { min: 0.0, max: 5e-3 },
        stroke_rate: f64::INFINITY,
        attach_within: 2e-4,
        anchor: None,
    }
}

/// The robot of the paper: 80 mm long, 12 mm thick, with four tendons and the auxiliary ones.
pub fn paper_robot() -> Twin {
    let mut scene = scenes::scene("coreact paper", MaterialLaw::Corotational);
    scene.tendons = (0..4).map(|k| scenes::tendon(k, 0.08, 4.5e-3, 10)).collect();
    scene.auxiliary = Some(layout());
    Twin::new(&scene, &paper_mesh()).unwrap()
}

#[test]
fn layout_of_paper_has_36_cables_of_4_mm() {
    let tendons = auxiliary_tendons(&layout());
    assert_eq!(tendons.len(), 36);
    for (k, tendon) in tendons.iter().enumerate() {
        assert_eq!(tendon.name, format!("aux_{:02}", k + 1));
        let [a, b] = tendon.points[..] else { panic!("two points: {:?}", tendon.points) };
        assert_close("length", distance(a, b), 4e-3, 1e-15);
        assert_close("radius", a[0].hypot(a[1]), 6e-3, 1e-15);
        assert_close("start", a[2], 4e-3 * (1.0 + (k / 2) as f64), 1e-15);
        // Two opposite cables; planes x z and y z take turns.
        let in_plane = if (k / 2) % 2 == 0 { a[1] } else { a[0] };
        assert!(in_plane.abs() < 1e-15, "{a:?}");
    }
    for pair in tendons.chunks(2) {
        let (a, b) = (pair[0].points[0], pair[1].points[0]);
        assert_close("diameter", distance(a, b), 12e-3, 1e-15);
    }
    assert_close("end", tendons[35].points[1][2], 76e-3, 1e-15);
}

#[test]
fn auxiliary_cables_follow_the_primary_ones_on_the_surface() {
    let twin = paper_robot();
    assert_eq!((twin.n_primary, twin.tendons.len(), twin.cables.len()), (4, 40, 40));
    assert_eq!(twin.tendons[4].name, "aux_01");
    for j in 4..40 {
        // The points are carried exactly where they were asked for, outside the polygon's flats too.
        assert_close("rest length", twin.cables.rest_lengths[j], 4e-3, 1e-15);
        for point in twin.cables.polyline(j, &twin.body.rest) {
            assert_close("radius", point[0].hypot(point[1]), 6e-3, 1e-15);
        }
    }
    // The flats of 14 sides lie 6 (1 - cos(π / 14)) = 0.15 mm inside the circle: within 0.2 mm, not 0.1.
    let mut near = layout();
    near.attach_within = 1e-4;
    let (mut scene, mesh) = (scenes::scene("near", MaterialLaw::Corotational), paper_mesh());
    scene.auxiliary = Some(near);
    let error = Twin::new(&scene, &mesh).expect_err("too far outside");
    assert!(error.bad_input().is_some_and(|bad| bad.place.starts_with("tendon.aux_")), "{error}");
}

fn paper_mesh() -> hysteron_fem::Mesh {
    let tube = Tube {
        profile: vec![[0.0, 6e-3], [0.08, 6e-3]],
        bore_radius: 2e-3,
        channels: Vec::new(),
        outer_divisions: 14,
        bore_divisions: 6,
        channel_divisions: 6,
        layers: Layers::Count(16),
        order: Order::Linear,
    };
    tube.mesh().unwrap()
}

#[test]
fn auxiliary_strokes_bend_the_robot() {
    let mut robot = Robot::of(paper_robot());
    let mut command = vec![0.0; 40];
    let free = |values: &[f64]| {
        let mut targets = strokes(values);
        targets[..4].fill(Target::Tension(0.0));
        targets
    };
    robot.go(&free(&command));
    // Shorten the cable at +x in four segments, and lengthen its opposite. Every second segment in this
    // plane has turned by half a revolution: its first cable is at -x.
    for segment in [0, 4, 8, 12] {
        command[4 + 2 * segment] = 5e-5;
        command[5 + 2 * segment] = -5e-5;
    }
    robot.go(&free(&command));
    let tip = robot.tip();
    // Each turns its segment by 0.1 mm / 12 mm, four make 33 mrad about 50 mm below the tip.
    assert!(tip[0] > 0.5e-3 && tip[0] < 3e-3, "{tip:?}");
    assert!(tip[1].abs() < 0.2 * tip[0], "{tip:?}");
    assert!(robot.state.tensions[4..].iter().any(|t| *t < 0.0), "virtual cables may push");
}
