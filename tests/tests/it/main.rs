//! End-to-end tests.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod arm;
mod arm_identify;
mod bad_input;
mod circles;
mod command;
mod documents;
mod emulate;
mod equations;
mod estimate_live;
mod fit_material;
mod generate;
mod identify_servo;
#[cfg(target_os = "linux")]
mod interrupt;
mod json_output;
mod limits;
mod mesh;
mod messages;
mod nad_input;
mod names;
mod numbers;
mod output_options;
mod outputs;
mod reach;
mod record;
mod recorded_checks;
mod recording_checks;
mod reduce;
mod registers;
mod reports;
mod repository;
mod sense;
mod servo_health;
mod shards;
mod simulate;
mod study;
#[cfg(target_os = "linux")]
mod system_limits;
mod target;
mod teleoperation;
#[cfg(unix)]
mod track;
mod train;
mod typed_commands;
mod verdicts;
mod virtual_arm;
mod virtual_rig;
mod your_robot;
