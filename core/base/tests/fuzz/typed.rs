//! Scenes, which people type, and recordings.

use std::path::Path;

use hysteron_base::{Channel, Metadata, Recording, Scene};
use hysteron_fuzz::text::{slipped, slips};
use hysteron_fuzz::{damaged, damages, drive};

use super::{Case, MEMORY_MAX, refused_by_base};

#[test]
fn no_slip_in_a_scene_does_harm() {
    let read = |name: &str| {
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../meshes/tpu80").join(name))
            .unwrap()
    };
    let texts = ["scene-coreact.toml", "scene-typical-friction.toml"].map(read);
    drive("scene", 2000, MEMORY_MAX, (slips(), 0..2_usize), |(slips, k)| {
        if let Err(error) = Scene::from_toml(&slipped(&texts[k], &slips), "scene.toml", Path::new("folder")) {
            refused_by_base(&error);
        }
    });
}

fn recording() -> Recording {
    let time: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
    let names = ["stroke_1_m", "stroke_2_m", "aux_01_m", "tip_x_m", "tip_qw", "tick_goal_1"];
    let values = |k: usize| time.iter().map(|t| (t * (k + 1) as f64).sin()).collect();
    let channels = names.iter().enumerate().map(|(k, name)| Channel::new(*name, values(k))).collect();
    let gap = (0..100).map(|i| i % 9 == 0).collect();
    let meta = Metadata { source: "by \"hand\"\n".to_owned(), ..Metadata::default() };
    Recording::new(time.clone(), channels, gap, meta).unwrap()
}

fn read(path: &Path, most: usize) {
    match Recording::read(path) {
        Ok(recording) => {
            assert!(recording.n_samples() <= most);
            let values = recording.channels().iter().flat_map(|channel| &channel.values);
            assert!(recording.time().iter().chain(values).all(|x| x.is_finite()));
        }
        Err(error) => refused_by_base(&error),
    }
}

#[test]
fn no_slip_in_a_recording_does_harm() {
    let case = Case::new("a.csv");
    recording().write(&case.path).unwrap();
    let text = std::fs::read_to_string(&case.path).unwrap();
    drive("recording, CSV", 500, MEMORY_MAX, slips(), |slips| {
        let text = slipped(&text, &slips);
        read(case.write(&text), text.len());
    });
}

#[test]
fn no_damage_to_a_recording_does_harm() {
    let case = Case::new("a.parquet");
    recording().write(&case.path).unwrap();
    let bytes = std::fs::read(&case.path).unwrap();
    drive("recording, Parquet", 500, MEMORY_MAX, damages(), |damages| {
        let bytes = damaged(&bytes, &damages);
        read(case.write(&bytes), 100 + bytes.len());
    });
}
