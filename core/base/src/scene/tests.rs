//! One rejecting test per bound, and the whole example read.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::*;
use crate::{BadInput, Error};

const EXAMPLE: &str = r#"format = "hysteron-scene"
version = 1
name = "tpu80"
seed = 1

[mesh]
file = "tpu80.msh"
unit = "mm"

[clamp]
group = "base"

[material]
law = "corotational"
youngs_modulus_mpa = 20.0
poisson_ratio = 0.45
density_kg_m3 = 1150.0

[gravity]
acceleration_m_s2 = [0.0, 0.0, -9.81]

[[point_force]]
at_mm = [0, 0, 80]
force_n = [0.1, 0, 0]

[tip]
group = "tip"

[[tendon]]
name = "p0"
points_mm = [[4.5, 0, 0], [4.5, 0, 8]]
drive = "stroke"
tension_min_n = 0.0
tension_max_n = 100.0
stroke_min_mm = -10.0
stroke_max_mm = 10.0
attach_within_mm = 0.01

[[tendon]]
name = "p1"
points_mm = [
  [0, 4.5, 0],
  [0, 4.5, 8],
]
drive = "tension"
tension_min_n = 0.5
tension_max_n = 50.0
stroke_min_mm = -5.0
stroke_max_mm = 5.0
attach_within_mm = 0.02

[auxiliary]
segments = 18
segment_length_mm = 4.0
start_mm = 4.0
radius_mm = 6.0
cables_per_segment = 2
first_plane_deg = 0.0
plane_step_deg = 90.0
drive = "free"
tension_min_n = -20.0
tension_max_n = 20.0
stroke_min_mm = 0.0
stroke_max_mm = 2.5
attach_within_mm = 0.2

[solver]
relative_residual = 1e-7
stroke_tolerance_mm = 1e-5
"#;

fn read(text: &str) -> Result<Scene> {
    Scene::from_toml(text, "scene.toml", Path::new("robots/tpu80"))
}

/// The error that the example gives after this change.
fn bad(old: &str, new: &str) -> BadInput {
    assert_eq!(EXAMPLE.matches(old).count(), 1, "{old}");
    match read(&EXAMPLE.replace(old, new)) {
        Err(Error::BadInput(bad)) => bad,
        other => panic!("{old} -> {new}: {other:?}"),
    }
}

/// The change is rejected at this place, showing this value.
fn rejects(old: &str, new: &str, place: &str, found: &str) {
    let bad = bad(old, new);
    assert_eq!((bad.place.as_str(), bad.found.as_str()), (&*format!("scene.toml: {place}"), found), "{bad}");
}

#[test]
fn example_is_read_into_si() {
    let scene = read(EXAMPLE).unwrap();
    assert_eq!(scene.name, "tpu80");
    assert_eq!(scene.seed, 1);
    assert_eq!(scene.mesh_path, Path::new("robots/tpu80/tpu80.msh"));
    assert_eq!(scene.mesh_unit, LengthUnit::Millimetre);
    assert_eq!(scene.clamp, Region::Group("base".into()));
    assert_eq!(
        scene.material,
        Material {
            law: MaterialLaw::Corotational,
            youngs_modulus: 20e6,
            poisson_ratio: 0.45,
            density: 1150.0
        }
    );
    assert_eq!(scene.gravity, [0.0, 0.0, -9.81]);
    assert_eq!(scene.point_forces, [PointForce { at: [0.0, 0.0, 0.08], force: [0.1, 0.0, 0.0] }]);
    assert_eq!(scene.tip, TipDefinition::Group("tip".into()));
    assert_eq!(scene.tracker, TrackerFrame::default());
    assert_eq!(scene.tendons.len(), 2);
    assert_eq!(
        scene.tendons[0],
        Tendon {
            name: "p0".into(),
            points: vec![[0.0045, 0.0, 0.0], [0.0045, 0.0, 0.008]],
            fixed: Vec::new(),
            drive: PrescribedQuantity::Stroke,
            tension: Bounds { min: 0.0, max: 100.0 },
            stroke: Bounds { min: -0.01, max: 0.01 },
            attach_within: 0.01 / 1000.0,
            anchor: None,
            ring: 0.0,
            compliance: 0.0,
            zero: 0.0,
        }
    );
    assert_eq!(
        scene.auxiliary.unwrap(),
        AuxiliaryLayout {
            segments: 18,
            segment_length: 0.004,
            start: 0.004,
            radius: 0.006,
            cables_per_segment: 2,
            first_plane: 0.0,
            plane_step: std::f64::consts::FRAC_PI_2,
            drive: PrescribedQuantity::Free,
            tension: Bounds { min: -20.0, max: 20.0 },
            stroke: Bounds { min: 0.0, max: 0.0025 },
            stroke_rate: f64::INFINITY,
            attach_within: 0.0002,
            anchor: None,
        }
    );
    assert_eq!(scene.solver, Solver { relative_residual: 1e-7, stroke_tolerance: 1e-8 });
}

#[test]
fn optional_parts_may_be_left_out() {
    let start = EXAMPLE.find("[[tendon]]").unwrap();
    let text = EXAMPLE[..start].replace("[[point_force]]\nat_mm = [0, 0, 80]\nforce_n = [0.1, 0, 0]\n", "");
    let scene = read(&text).unwrap();
    assert!(scene.tendons.is_empty() && scene.point_forces.is_empty() && scene.auxiliary.is_none());
    assert_eq!(scene.solver, Solver::default());
}

#[test]
fn tendon_may_stretch_and_begin_pulled() {
    let old = "attach_within_mm = 0.02";
    assert_eq!(EXAMPLE.matches(old).count(), 1);
    let scene =
        read(&EXAMPLE.replace(old, &format!("{old}\ncompliance_mm_per_n = 0.03\nzero_mm = -0.5"))).unwrap();
    assert_eq!((scene.tendons[1].compliance, scene.tendons[1].zero), (0.03 / 1000.0, -0.5 / 1000.0));
}

const FRICTION: &str = r#"
[friction]
points = 4
coefficient = 0.1
coulomb_n = 0.2
sheath_exponent = 0.15
sheath_coulomb_n = 0.3
sheath_compliance_share = 0.7
backlash_mm = 0.25
"#;

/// The example with tendons that stretch, and friction after this change.
fn with_friction(old: &str, new: &str) -> Result<Scene> {
    let stretching =
        EXAMPLE.replace("attach_within_mm = 0.0", "compliance_mm_per_n = 0.01\nattach_within_mm = 0.0");
    assert_eq!(FRICTION.matches(old).count(), 1, "{old}");
    read(&(stretching + &FRICTION.replace(old, new)))
}

#[test]
fn friction_is_read_into_si() {
    let friction = with_friction("points = 4", "points = 4").unwrap().friction;
    let expected = Friction {
        coefficient: 0.1,
        coulomb: 0.2,
        points: 4,
        sheath_exponent: 0.15,
        sheath_coulomb: 0.3,
        sheath_compliance_share: 0.7,
        backlash: 0.25 / 1000.0,
    };
    assert_eq!(friction, Some(expected));
    assert_eq!(read(EXAMPLE).unwrap().friction, None);
    // Each effect may be left out.
    let alone = read(&format!("{EXAMPLE}[friction]\nbacklash_mm = 0.25\n")).unwrap().friction.unwrap();
    assert_eq!((alone.points, alone.coefficient, alone.backlash), (0, 0.0, 0.25 / 1000.0));
}

#[test]
fn scene_rejects_friction_that_cannot_be() {
    let rejects = |old: &str, new: &str, place: &str, found: &str| match with_friction(old, new) {
        Err(Error::BadInput(bad)) => {
            assert_eq!((bad.place, bad.found), (format!("scene.toml: {place}"), found.to_owned()));
        }
        other => panic!("{old} -> {new}: {other:?}"),
    };
    rejects("points = 4", "points = 0", "friction.points", "0");
    rejects("points = 4", "points = 101", "friction.points", "101");
    rejects("points = 4\n", "", "friction.points", "nothing");
    rejects("coefficient = 0.1", "coefficient = -0.1", "friction.coefficient", "-0.1");
    rejects("\ncoulomb_n = 0.2", "\ncoulomb_n = inf", "friction.coulomb_n", "inf");
    rejects("exponent = 0.15", "exponent = nan", "friction.sheath_exponent", "NaN");
    rejects("sheath_coulomb_n = 0.3", "sheath_coulomb_n = -1", "friction.sheath_coulomb_n", "-1.0");
    rejects("share = 0.7", "share = 1.1", "friction.sheath_compliance_share", "1.1");
    rejects("share = 0.7", "share = 0", "friction.sheath_compliance_share", "0.0");
    rejects("backlash_mm = 0.25", "backlash_mm = -0.25", "friction.backlash_mm", "-0.25");
    match read(&(EXAMPLE.to_owned() + FRICTION)) {
        Err(Error::BadInput(bad)) => {
            assert_eq!(bad.place, "scene.toml: tendon.p0.compliance_mm_per_n");
            assert!(bad.hint.contains("sheath"));
        }
        other => panic!("a sheath before tendons that do not stretch: {other:?}"),
    }
}

#[test]
fn clamp_may_be_a_box_and_tip_a_point() {
    let text = EXAMPLE
        .replace("group = \"base\"", "box_min_mm = [-7, -7, -0.5]\nbox_max_mm = [7, 7, 0.5]")
        .replace("group = \"tip\"", "point_mm = [0, 0, 80]");
    let scene = read(&text).unwrap();
    assert_eq!(scene.clamp, Region::Box { min: [-0.007, -0.007, -0.0005], max: [0.007, 0.007, 0.0005] });
    assert_eq!(scene.tip, TipDefinition::Point([0.0, 0.0, 0.08]));
}

#[test]
fn parts_of_another_stiffness_are_read_and_change_the_hash_only_where_they_are() {
    let part =
        "[[insert]]\nbox_min_mm = [-7, -7, 78]\nbox_max_mm = [7, 7, 81]\nmodulus_ratio = 100.0\n\n[gravity]";
    let (plain, scene) = (read(EXAMPLE).unwrap(), read(&EXAMPLE.replace("[gravity]", part)).unwrap());
    assert!(plain.inserts.is_empty());
    let [insert] = &scene.inserts[..] else { panic!("{:?}", scene.inserts) };
    assert_eq!(insert.modulus_ratio, 100.0);
    assert_eq!(insert.region, Region::Box { min: [-0.007, -0.007, 0.078], max: [0.007, 0.007, 0.081] });
    for (change, place, found) in [
        ("modulus_ratio = 0.0", "insert[1].modulus_ratio", "0.0"),
        ("modulus_ratio = 1e5", "insert[1].modulus_ratio", "100000.0"),
    ] {
        rejects("[gravity]", &part.replace("modulus_ratio = 100.0", change), place, found);
    }
    rejects("[gravity]", "[[insert]]\nmodulus_ratio = 2.0\n[gravity]", "insert[1]", "neither");
}

#[test]
fn youngs_modulus_comes_in_four_units() {
    for (key, pascal) in [("pa", 20.0), ("kpa", 20e3), ("mpa", 20e6), ("gpa", 20e9)] {
        let scene = read(&EXAMPLE.replace("youngs_modulus_mpa", &format!("youngs_modulus_{key}"))).unwrap();
        assert_eq!(scene.material.youngs_modulus, pascal);
    }
}

#[test]
fn scene_rejects_poisson_half() {
    let bad = bad("poisson_ratio = 0.45", "poisson_ratio = 0.5");
    assert_eq!(
        bad.to_string(),
        "scene.toml: material.poisson_ratio: expected -1 < nu < 0.5, got 0.5 \
         (hint: use 0.49 and a quadratic mesh)"
    );
}

#[test]
fn scene_rejects_numbers_out_of_bounds() {
    rejects("poisson_ratio = 0.45", "poisson_ratio = -1", "material.poisson_ratio", "-1.0");
    rejects("poisson_ratio = 0.45", "poisson_ratio = nan", "material.poisson_ratio", "NaN");
    for (typed, found) in
        [("0", "0.0"), ("-20.0", "-20.0"), ("inf", "inf"), ("nan", "NaN"), ("1e308", "1e308")]
    {
        let new = format!("youngs_modulus_mpa = {typed}");
        rejects("youngs_modulus_mpa = 20.0", &new, "material.youngs_modulus_mpa", found);
    }
    rejects("density_kg_m3 = 1150.0", "density_kg_m3 = -1", "material.density_kg_m3", "-1.0");
    rejects("density_kg_m3 = 1150.0", "density_kg_m3 = inf", "material.density_kg_m3", "inf");
    rejects("-9.81]", "nan]", "gravity.acceleration_m_s2[2]", "NaN");
    rejects("at_mm = [0, 0, 80]", "at_mm = [0, inf, 80]", "point_force[1].at_mm[1]", "inf");
    rejects("force_n = [0.1, 0, 0]", "force_n = [nan, 0, 0]", "point_force[1].force_n[0]", "NaN");
    rejects("segments = 18", "segments = 0", "auxiliary.segments", "0");
    rejects("segments = 18", "segments = 1001", "auxiliary.segments", "1001");
    rejects("cables_per_segment = 2", "cables_per_segment = -2", "auxiliary.cables_per_segment", "-2");
    rejects("cables_per_segment = 2", "cables_per_segment = 101", "auxiliary.cables_per_segment", "101");
    rejects("segment_length_mm = 4.0", "segment_length_mm = 0", "auxiliary.segment_length_mm", "0.0");
    rejects("start_mm = 4.0", "start_mm = inf", "auxiliary.start_mm", "inf");
    rejects("radius_mm = 6.0", "radius_mm = -6.0", "auxiliary.radius_mm", "-6.0");
    rejects("first_plane_deg = 0.0", "first_plane_deg = nan", "auxiliary.first_plane_deg", "NaN");
    rejects("plane_step_deg = 90.0", "plane_step_deg = -inf", "auxiliary.plane_step_deg", "-inf");
    rejects("plane_step_deg = 90.0", "plane_step_deg = 1e300", "auxiliary.plane_step_deg", "1e300");
    rejects("attach_within_mm = 0.2\n", "attach_within_mm = -0.2\n", "auxiliary.attach_within_mm", "-0.2");
    rejects("attach_within_mm = 0.02", "attach_within_mm = -1", "tendon.p1.attach_within_mm", "-1.0");
    rejects("attach_within_mm = 0.02", "attach_within_mm = 0\nring_mm = -1", "tendon.p1.ring_mm", "-1.0");
    let with = |typed: &str| format!("attach_within_mm = 0\n{typed}");
    let compliance = "tendon.p1.compliance_mm_per_n";
    rejects("attach_within_mm = 0.02", &with("compliance_mm_per_n = -0.1"), compliance, "-0.1");
    rejects("attach_within_mm = 0.02", &with("zero_mm = nan"), "tendon.p1.zero_mm", "NaN");
    rejects("relative_residual = 1e-7", "relative_residual = 0", "solver.relative_residual", "0.0");
    rejects("relative_residual = 1e-7", "relative_residual = 1", "solver.relative_residual", "1.0");
    rejects("stroke_tolerance_mm = 1e-5", "stroke_tolerance_mm = 0", "solver.stroke_tolerance_mm", "0.0");
}

#[test]
fn points_of_a_tendon_may_be_fixed() {
    let read = |points: &str| {
        let text = EXAMPLE.replace("[[4.5, 0, 0], [4.5, 0, 8]]", points);
        Scene::from_toml(&text, "scene.toml", Path::new("")).unwrap()
    };
    let plain = read("[[4.5, 0, 0], [4.5, 0, 8]]");
    let fixed = read("[{ at_mm = [4.5, 0, 0], fixed = true }, [4.5, 0, 8]]");
    assert_eq!((&fixed.tendons[0].points, &fixed.tendons[0].fixed), (&plain.tendons[0].points, &vec![0]));
    // A scene without fixed points is what it was before there were any.
    let tables = read("[{ at_mm = [4.5, 0, 0] }, { at_mm = [4.5, 0, 8], fixed = false }]");
    assert_eq!((&tables, &tables.hash), (&plain, &plain.hash));
    assert_ne!(fixed.hash, plain.hash);
    assert!(!serde_json::to_string(&plain).unwrap().contains("fixed"));
    let point = "[4.5, 0, 0], [4.5, 0, 8]]";
    let typo = bad(point, "{ at_mm = [4.5, 0, 0], fix = true }, [4.5, 0, 8]]");
    assert!(typo.to_string().contains("fix"), "{typo}");
}

#[test]
fn scene_rejects_what_no_robot_has() {
    for (typed, found) in [("1e-30", "1e-30"), ("1e-7", "1e-7"), ("1.1e7", "11000000.0")] {
        let new = format!("youngs_modulus_mpa = {typed}");
        rejects("youngs_modulus_mpa = 20.0", &new, "material.youngs_modulus_mpa", found);
    }
    rejects("density_kg_m3 = 1150.0", "density_kg_m3 = 1e30", "material.density_kg_m3", "1e30");
    rejects("-9.81]", "-1e9]", "gravity.acceleration_m_s2[2]", "-1000000000.0");
    rejects("at_mm = [0, 0, 80]", "at_mm = [0, 1e9, 80]", "point_force[1].at_mm[1]", "1000000000.0");
    rejects("force_n = [0.1, 0, 0]", "force_n = [1e30, 0, 0]", "point_force[1].force_n[0]", "1e30");
    rejects("tension_max_n = 50.0", "tension_max_n = 1e300", "tendon.p1.tension_max_n", "1e300");
    rejects("stroke_min_mm = -5.0", "stroke_min_mm = -1e300", "tendon.p1.stroke_min_mm", "-1e300");
    rejects("[4.5, 0, 8]]", "[4.5, 0, 8e300]]", "tendon.p0.points_mm[1][2]", "8e300");
    rejects("relative_residual = 1e-7", "relative_residual = 1e-300", "solver.relative_residual", "1e-300");
    rejects("segment_length_mm = 4.0", "segment_length_mm = 1e-300", "auxiliary.segment_length_mm", "1e-300");
    let (from, to) = ("segments = 18\nsegment_length_mm = 4.0", "segments = 1000\nsegment_length_mm = 4.0");
    let text = EXAMPLE.replace(from, to).replace("cables_per_segment = 2", "cables_per_segment = 100");
    assert!(text != EXAMPLE);
    let Err(Error::BadInput(bad)) = read(&text) else { panic!("10^5 auxiliary tendons are accepted") };
    assert_eq!((bad.expected.as_str(), bad.found.as_str()), ("at most 500", "100000"));
}

#[test]
fn scene_rejects_crossed_bounds() {
    rejects("tension_min_n = 0.5", "tension_min_n = 51", "tendon.p1.tension_min_n", "51.0");
    rejects("tension_max_n = 50.0", "tension_max_n = inf", "tendon.p1.tension_max_n", "inf");
    rejects("stroke_min_mm = -5.0", "stroke_min_mm = 5.5", "tendon.p1.stroke_min_mm", "5.5");
    rejects("stroke_min_mm = -5.0", "stroke_min_mm = -inf", "tendon.p1.stroke_min_mm", "-inf");
    rejects("tension_min_n = -20.0", "tension_min_n = 21", "auxiliary.tension_min_n", "21.0");
    rejects("stroke_max_mm = 2.5", "stroke_max_mm = -1", "auxiliary.stroke_min_mm", "0.0");
    let boxed = "box_min_mm = [-7, 8, 0]\nbox_max_mm = [7, 7, 0.5]";
    rejects("group = \"base\"", boxed, "clamp.box_min_mm[1]", "8.0");
    let bad = bad("stroke_min_mm = -5.0", "stroke_min_mm = 5.5");
    assert_eq!(bad.expected, "at most stroke_max_mm = 5.0");
}

#[test]
fn scene_rejects_wrong_choices() {
    let both = "group = \"base\"\nbox_min_mm = [0, 0, 0]";
    rejects("group = \"base\"", both, "clamp", "both");
    rejects("group = \"base\"", "", "clamp", "neither");
    rejects("group = \"base\"", "box_min_mm = [0, 0, 0]", "clamp", "box_min_mm alone");
    rejects("group = \"base\"", "box_max_mm = [0, 0, 0]", "clamp", "box_max_mm alone");
    rejects("group = \"tip\"", "", "tip", "neither");
    rejects("group = \"tip\"", "group = \"tip\"\npoint_mm = [0, 0, 80]", "tip", "both");
    rejects("youngs_modulus_mpa = 20.0", "", "material.youngs_modulus", "none");
    rejects(
        "youngs_modulus_mpa = 20.0",
        "youngs_modulus_mpa = 20.0\nyoungs_modulus_pa = 2e7",
        "material.youngs_modulus",
        "youngs_modulus_pa and youngs_modulus_mpa",
    );
}

#[test]
fn scene_rejects_wrong_names_and_points() {
    rejects("format = \"hysteron-scene\"", "format = \"scene\"", "format", "\"scene\"");
    rejects("version = 1", "version = 2", "version", "2");
    rejects("name = \"tpu80\"", "name = \" \"", "name", "\" \"");
    rejects("file = \"tpu80.msh\"", "file = \"\"", "mesh.file", "\"\"");
    rejects("group = \"base\"", "group = \"\"", "clamp.group", "\"\"");
    rejects("group = \"tip\"", "group = \"\"", "tip.group", "\"\"");
    rejects("name = \"p1\"", "name = \"\"", "tendon[2].name", "\"\"");
    rejects("name = \"p1\"", "name = \"p0\"", "tendon[2].name", "\"p0\" again");
    rejects("[[4.5, 0, 0], [4.5, 0, 8]]", "[[4.5, 0, 0]]", "tendon.p0.points_mm", "1 of them");
    rejects("[[4.5, 0, 0], [4.5, 0, 8]]", "[[4, 0, 0], [4, nan, 8]]", "tendon.p0.points_mm[1][1]", "NaN");
    rejects("[4.5, 0, 8]]", "[4.5, 0, 0]]", "tendon.p0.points_mm[1]", "[4.5, 0.0, 0.0] again");
}

#[test]
fn unknown_key_is_named_with_its_line_and_the_nearest_known() {
    let bad = bad("poisson_ratio = 0.45", "possion_ratio = 0.45");
    assert_eq!(bad.place, "scene.toml: line 16: material.possion_ratio");
    assert_eq!(bad.found, "`possion_ratio`");
    assert_eq!(bad.hint, "did you mean poisson_ratio?");
    rejects("seed = 1", "seed = 1\ncolour = 2", "line 5: colour", "`colour`");
    rejects("radius_mm = 6.0", "radius = 6.0", "line 56: auxiliary.radius", "`radius`");
    rejects("name = \"p1\"", "name = \"p1\"\nlength_mm = 3", "line 41: tendon[2].length_mm", "`length_mm`");
}

#[test]
fn missing_key_is_named() {
    rejects("poisson_ratio = 0.45\n", "", "material.poisson_ratio", "nothing");
    rejects("seed = 1\n", "", "seed", "nothing");
    rejects("drive = \"tension\"\n", "", "tendon[2].drive", "nothing");
    rejects("[gravity]\nacceleration_m_s2 = [0.0, 0.0, -9.81]\n", "", "gravity", "nothing");
    rejects("stroke_max_mm = 2.5\n", "", "auxiliary.stroke_max_mm", "nothing");
}

#[test]
fn wrong_types_and_syntax_name_their_line() {
    rejects("seed = 1", "seed = -1", "line 4: seed", "integer -1");
    rejects("unit = \"mm\"", "unit = \"inch\"", "line 8: mesh.unit", "\"inch\"");
    rejects("law = \"corotational\"", "law = \"rubber\"", "line 14: material.law", "\"rubber\"");
    rejects("drive = \"tension\"", "drive = \"push\"", "line 45: tendon[2].drive", "\"push\"");
    rejects(
        "poisson_ratio = 0.45",
        "poisson_ratio = \"x\"",
        "line 16: material.poisson_ratio",
        "string \"x\"",
    );
    let bad = bad("poisson_ratio = 0.45", "poisson_ratio = = 1");
    assert_eq!((bad.place.as_str(), bad.expected.as_str()), ("scene.toml: line 16", "valid TOML"));
}

#[test]
fn scene_file_errors_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    assert!(matches!(Scene::read(&path), Err(Error::BadInput(bad)) if bad.found == "nothing there"));
    file::write_bytes(&path, EXAMPLE).unwrap();
    assert!(matches!(Scene::read(&path), Err(Error::BadInput(bad)) if bad.place.ends_with("tpu80.msh")));
    file::write_bytes(&folder.path().join("tpu80.msh"), "a mesh").unwrap();
    assert_eq!(Scene::read(&path).unwrap().mesh_path, folder.path().join("tpu80.msh"));
}

#[test]
fn frame_of_the_tracker_is_read_and_checked() {
    let with = |table: &str| format!("[tracker]\n{table}\n\n[[point_force]]");
    let text = EXAMPLE.replace("[[point_force]]", &with("turn_deg = [0, 180, 0]\nshift_mm = [1, 0, -2]"));
    let tracker = read(&text).unwrap().tracker;
    assert_eq!(tracker, TrackerFrame { turn: [0.0, std::f64::consts::PI, 0.0], shift: [1e-3, 0.0, -2e-3] });
    let half = with("turn_deg = [0, 150, 150]");
    rejects("[[point_force]]", &half, "tracker.turn_deg", "212.1 deg");
    rejects("[[point_force]]", &with("shift_mm = [nan, 0, 0]"), "tracker.shift_mm[0]", "NaN");
    rejects("[[point_force]]", &with("shift_mm = [0, 1e300, 0]"), "tracker.shift_mm[1]", "1e300");
}

#[test]
fn hash_is_of_values_and_mesh_and_not_of_how_they_are_typed() {
    let folder = tempfile::tempdir().unwrap();
    let hash = |scene: &str, mesh: &str, name: &str| {
        let scene = scene.replace("tpu80.msh", name);
        file::write_bytes(&folder.path().join("scene.toml"), scene).unwrap();
        file::write_bytes(&folder.path().join(name), mesh).unwrap();
        Scene::read(folder.path().join("scene.toml")).unwrap().hash
    };
    let first = hash(EXAMPLE, "a mesh", "tpu80.msh");
    assert_eq!(first.len(), 64);
    let typed = EXAMPLE.replace("youngs_modulus_mpa = 20.0", "# stiff\nyoungs_modulus_kpa = 2e4");
    assert_eq!(hash(&typed, "a mesh", "moved.msh"), first);
    let other = EXAMPLE.replace("youngs_modulus_mpa = 20.0", "youngs_modulus_mpa = 20.000001");
    assert_ne!(hash(&other, "a mesh", "tpu80.msh"), first);
    let other = EXAMPLE.replace("unit = \"mm\"", "unit = \"cm\"");
    assert_ne!(hash(&other, "a mesh", "tpu80.msh"), first);
    assert_ne!(hash(EXAMPLE, "another mesh", "tpu80.msh"), first);
}

#[test]
fn reduced_body_is_a_part_of_the_hash_wherever_it_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    file::write_bytes(&place("tpu80.msh"), "a mesh").unwrap();
    file::write_bytes(&place("chain.json"), "a chain").unwrap();
    let with = |text: &str| {
        file::write_bytes(&place("scene.toml"), text).unwrap();
        Scene::read(place("scene.toml")).unwrap()
    };
    let plain = with(EXAMPLE);
    assert_eq!(plain.reduced_path, None);
    let named = with(&EXAMPLE.replace("[clamp]", "[reduced]\nfile = \"chain.json\"\n[clamp]"));
    assert_eq!(named.reduced_path, Some(place("chain.json")));
    assert_ne!(named.hash, plain.hash);
    // In place of one that is not there, of none, and with another content.
    let given = || Scene::read_with(place("scene.toml"), Some(place("chain.json"))).unwrap();
    with(EXAMPLE);
    assert_eq!(given(), named);
    let other = EXAMPLE.replace("[clamp]", "[reduced]\nfile = \"none.json\"\n[clamp]");
    file::write_bytes(&place("scene.toml"), other).unwrap();
    assert_eq!(given(), named);
    file::write_bytes(&place("chain.json"), "another chain").unwrap();
    assert_ne!(given().hash, named.hash);
    rejects("[clamp]", "[reduced]\nfile = \"\"\n[clamp]", "reduced.file", "\"\"");
}
