//! Files that people type or export: scenes with their twins, plans, targets, outlines.

use std::path::Path;

use hysteron_base::Scene;
use hysteron_control::{MotionPlan, TargetPath};
use hysteron_fem::read_mesh;
use hysteron_fuzz::drive;
use hysteron_fuzz::text::{slipped, slips};
use hysteron_tests::root;
use hysteron_twin::Twin;

use super::{Case, MEMORY_MAX, refused};

/// Strokes of an accepted plan that are drawn up.
const STROKES_MAX: usize = 100_000;

#[test]
fn no_slip_in_a_scene_harms_its_twin() {
    let folder = root().join("meshes/tpu80");
    let text = std::fs::read_to_string(folder.join("scene-coreact.toml")).unwrap();
    let mesh = read_mesh(&folder.join("tpu80.msh"), 1e-3).unwrap();
    drive("twin of a scene", 50, MEMORY_MAX, slips(), |slips| {
        let Ok(scene) = Scene::from_toml(&slipped(&text, &slips), "scene.toml", &folder) else { return };
        match Twin::new(&scene, &mesh) {
            Ok(twin) => assert!(twin.tip_of(&twin.rest()).iter().all(|c| c.is_finite())),
            Err(error) => refused(error.bad_input(), &error),
        }
    });
}

#[test]
fn no_slip_in_a_plan_does_harm() {
    let texts = ["quick", "roses"].map(|name| MotionPlan::text(name).unwrap());
    drive("plan", 300, MEMORY_MAX, (slips(), 0..2_usize), |(slips, k)| {
        match MotionPlan::from_toml(&slipped(texts[k], &slips), "plan.toml") {
            Ok(plan) => {
                let n_strokes =
                    |one: &hysteron_control::Trajectory| one.n_samples() * one.tendons.angles.len();
                for one in plan.trajectories().iter().filter(|one| n_strokes(one) <= STROKES_MAX) {
                    assert!(one.strokes_at(one.time(1)).iter().all(|stroke| stroke.is_finite()));
                }
            }
            Err(error) => refused(error.bad_input(), &error),
        }
    });
}

const TARGET: &str = "format = \"hysteron-target\"\nversion = 1\nname = \"t\"\nrate_hz = 50\nspeed_mm_s = 20\n\
                      ramp_s = 1\nrest_s = 1\nlead_in_s = 2\nlaps = 2\ncentre_mm = [1.0, 2.0]\nrotation_deg = 30\n\
                      direction = \"clockwise\"\n";
const CURVES: [&str; 4] = [
    "[curve]\nfamily = \"circle\"\nsize_mm = 20\n",
    "[curve]\nfamily = \"lissajous\"\nsize_mm = 20\nwidth_mm = 18\ncycles = [1, 2]\nphase_deg = 10\n",
    "[curve]\nfamily = \"polyline\"\npoints_mm = [[0, 0], [10, 0], [10, 10], [0, 10]]\nclosed = true\nmay_cross = false\n",
    "[curve]\nfamily = \"outline\"\nfile = \"a.svg\"\n",
];
const SVGS: [&str; 3] = [
    "<?xml version=\"1.0\"?>\n<!DOCTYPE svg [<!ENTITY w \"80mm\">]>\n<svg xmlns=\"http://www.w3.org/2000/svg\" \
     width=\"&w;\"\nheight=\"60mm\" viewBox=\"0 0 80 60\">\n<g transform=\"rotate(10 40 30) scale(0.5)\">\n\
     <path d=\"M 10 10 L 60 10\nA 20 20 0 0 1 60 50\nC 50 60 20 60 10 50\nQ 5 30 10 20 Z\"/>\n</g>\n</svg>\n",
    "<svg width=\"80mm\" viewBox=\"0 0 80 80\">\n<ellipse\ncx=\"40\" cy=\"30\"\nrx=\"20\"\nry=\"10\"/>\n</svg>\n",
    "<svg width=\"8cm\" viewBox=\"0 0 80 80\">\n<polygon points=\"1,1 40,1 40,40\n20,60 1,40\"/>\n</svg>\n",
];

fn opened(path: &Path) {
    match TargetPath::open(&path.display().to_string()) {
        Ok(target) => assert!(target.points().iter().flatten().all(|c| c.is_finite())),
        Err(error) => refused(error.bad_input(), &error),
    }
}

#[test]
fn no_slip_in_a_target_does_harm() {
    let case = Case::new("a.toml");
    std::fs::write(case.path.with_file_name("a.svg"), SVGS[1]).unwrap();
    drive("target", 500, MEMORY_MAX, (slips(), 0..CURVES.len()), |(slips, k)| {
        opened(case.write(slipped(&[TARGET, CURVES[k]].concat(), &slips)));
    });
}

#[test]
fn no_slip_in_an_outline_does_harm() {
    let case = Case::new("a.svg");
    drive("outline, SVG", 1000, MEMORY_MAX, (slips(), 0..SVGS.len()), |(slips, k)| {
        opened(case.write(slipped(SVGS[k], &slips)));
    });
    let case = Case::new("a.csv");
    let points: String = (0..40).map(|k| format!("{k},{},{}\n", (k * k) % 17, k % 3)).collect();
    let text = format!("# drawn by hand\nx_mm,y_mm,z_mm\n{points}");
    drive("outline, CSV", 1000, MEMORY_MAX, slips(), |slips| opened(case.write(slipped(&text, &slips))));
}
