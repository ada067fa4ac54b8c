//! Drives from damaged files of TOML.

use std::path::Path;

use hysteron_actuator::{Bridge, CatalogueDrive, DriveLoad, DriveState};
use hysteron_fuzz::text::{slipped, slips};
use hysteron_fuzz::{assert_in_house_form, drive};

/// Most memory of this process, the other tests in it included [bytes].
const MEMORY_MAX: u64 = 1 << 30;

/// The text as a drive; what is accepted turns, and can be written.
fn turned(text: &str) {
    match CatalogueDrive::parse(text) {
        Ok(read) => {
            let mut state = DriveState::resting(0.0, read.drive.winding.reference);
            for _ in 0..5 {
                read.drive.step(&mut state, Bridge::Driven(1.0), DriveLoad::torque(0.0), 1e-3);
            }
            assert!([state.angle, state.velocity].iter().all(|x| x.is_finite()), "{state:?}");
            CatalogueDrive::parse(&String::from(read)).unwrap();
        }
        Err(bad) => assert_in_house_form(Some(&bad), &bad),
    }
}

#[test]
fn no_slip_in_a_drive_does_harm() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("drives");
    let mut texts: Vec<String> = CatalogueDrive::names()
        .map(|name| std::fs::read_to_string(folder.join(format!("{name}.toml"))).unwrap())
        .collect();
    texts.sort();
    drive("drive", 2000, MEMORY_MAX, (slips(), 0..texts.len()), |(slips, k)| {
        turned(&slipped(&texts[k], &slips))
    });
}
