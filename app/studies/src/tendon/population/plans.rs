//! Plans of the population's robots, and the scene before any fit.

use std::path::Path;

use anyhow::Result;
use hysteron_base::file;

use crate::tendon::commands::{ChainCommands, FRICTION};

/// Changes of the scene of `typical` to one before any fit: the drawing, and data sheets for wire in channels and sheaths
/// lined with PTFE (`meshes/tpu80/scene-friction.toml`). Its mesh is named from the robot's folder.
const NOMINAL: [(&str, &str); 7] = [
    ("name = \"tpu80-typical-friction\"", "name = \"tpu80-nominal\""),
    ("compliance_mm_per_n = 0.0251065", "compliance_mm_per_n = 0.02"),
    ("zero_mm = 0.352247", "zero_mm = 0.0"),
    ("sheath_exponent = 0.51945", "sheath_exponent = 0.31"),
    ("sheath_compliance_share = 0.5", "sheath_compliance_share = 0.6"),
    ("backlash_mm = 0.260928", "backlash_mm = 0.05"),
    ("# The virtual rig's typical robot as", "# As drawn, not fitted:"),
];

/// Plan of the recordings: three minutes.
const RECORDED: &str = r#"format = "hysteron-plan"
version = 1
name = "population"
seed = 1
rate_hz = 100
tendon_angles_deg = [0, 90, 180, 270]
release = 1.0
rest_before_s = 1
rest_after_s = 1
stroke_max_mm = 9
stroke_rate_max_mm_s = 12
"#;
/// Its trajectories: name, family and the other keys of its entry. Roses pass the centre, and everything around it, in
/// ever new directions.
const TRAJECTORIES: [(&str, &str, &str); 8] = [
    (
        "circle",
        "circle",
        "amplitude_mm = 7.5\nphase_deg = 0\ndirection = \"counter_clockwise\"\nperiod_s = 8",
    ),
    ("circle-back", "circle", "amplitude_mm = 6\nphase_deg = 90\ndirection = \"clockwise\"\nperiod_s = 10"),
    (
        "square",
        "square",
        "amplitude_mm = 8\norientation_deg = 45\ndirection = \"counter_clockwise\"\nperiod_s = 10",
    ),
    ("diamond", "square", "amplitude_mm = 7\norientation_deg = 0\ndirection = \"clockwise\"\nperiod_s = 12"),
    ("rose-slow", "rose", "amplitude_mm = 8\nswings = 0.6\norientation_deg = 20\nperiod_s = 9"),
    ("rose", "rose", "amplitude_mm = 8\nswings = 1.6\norientation_deg = 70\nperiod_s = 12"),
    ("rose-back", "rose", "amplitude_mm = 7\nswings = 1.3\norientation_deg = 110\nperiod_s = 11"),
    ("diagonal", "sinusoid", "amplitude_mm = 7\norientation_deg = 45\nperiod_s = 8"),
];
/// Plan of the calibrated twin in addition: its tip along curves drawn from ranges, as far out as the
/// recordings go and back. Family, how many, and what else.
const SYNTHETIC: [(&str, u32, &str); 4] = [
    ("rose", 48, "swings = [0.4, 2.4]"),
    ("circle", 12, ""),
    ("square", 24, ""),
    ("ellipse", 18, "aspect = [0.2, 0.8]"),
];

/// Writes the scene of every robot before its recordings are looked at; gives its path.
///
/// # Errors
/// Refusals of the file system.
pub(super) fn write_nominal_scene(chain: &ChainCommands<'_>) -> Result<String> {
    let mesh = chain.meshes().join("tpu80.msh").canonicalize()?;
    let mesh = format!("file = {:?}", mesh.display().to_string());
    let lines = [&NOMINAL[..], &[("file = \"tpu80.msh\"", &mesh)]].concat();
    let scene = file::read_text(Path::new(&chain.scene_path(FRICTION.1)))?;
    chain.write_changed(&scene, &lines, "nominal.toml")
}

/// Writes the plan of what is recorded of a robot; gives its path.
///
/// # Errors
/// Refusals of the file system.
pub(crate) fn write_recorded_plan(chain: &ChainCommands<'_>) -> Result<String> {
    let path = chain.path("plan.toml")?;
    file::write_bytes(Path::new(&path), recorded_plan())?;
    Ok(path)
}

fn recorded_plan() -> String {
    let entry = |(name, family, own): &(&str, &str, &str)| {
        format!(
            "\n[[trajectory]]\nname = \"{name}\"\nrole = \"training\"\nfamily = \"{family}\"\n{own}\n\
             attack_s = 5\nsustain_s = 10\ndecay_s = 5\n"
        )
    };
    RECORDED.to_owned() + &TRAJECTORIES.iter().map(entry).collect::<String>()
}

/// The plan of the calibrated twin.
pub(super) fn synthetic_plan() -> String {
    let mut text = RECORDED.replace("name = \"population\"", "name = \"synthetic\"\nspace = \"tip\"");
    text = text.replace("stroke_max_mm = 9", "stroke_max_mm = 12");
    for (family, count, own) in SYNTHETIC {
        text += &format!(
            "\n[[draw]]\nname = \"{family}\"\nrole = \"training\"\nfamily = \"{family}\"\ncount = {count}\n{own}\n\
             amplitude_mm = [10, 28]\nperiod_s = [9, 18]\nattack_s = 8\nsustain_s = 32\ndecay_s = 20\n"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use hysteron_base::Scene;
    use hysteron_control::MotionPlan;

    use super::*;

    #[test]
    fn plans_are_valid_and_the_nominal_scene_knows_no_robot() {
        let plan = MotionPlan::from_toml(&recorded_plan(), "plan").expect("a good plan");
        assert_eq!(plan.trajectories().len(), TRAJECTORIES.len());
        MotionPlan::from_toml(&synthetic_plan(), "plan").expect("a good plan");
        let meshes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../meshes/tpu80");
        let text = std::fs::read_to_string(meshes.join(FRICTION.1)).expect("a scene");
        let text = NOMINAL.iter().fold(text, |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        });
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("nominal.toml"), text).expect("a file");
        std::fs::copy(meshes.join("tpu80.msh"), folder.path().join("tpu80.msh")).expect("a mesh");
        let scene = Scene::read(folder.path().join("nominal.toml")).expect("a good scene");
        assert!(scene.tendons.iter().all(|tendon| tendon.zero == 0.0 && tendon.compliance == 2e-5));
    }
}
