//! `hysteron arm`: rigid-body arms.

pub mod dynamics;
#[cfg(unix)]
pub mod emulate;
pub mod excite;
pub mod export;
pub mod generate;
pub mod info;
pub mod record;
pub mod simulate;

use std::path::Path;

use hysteron_actuator::CatalogueDrive;
use hysteron_arm::Model;
use hysteron_base::{BadInput, Metadata, file};

use crate::outputs::Outputs;
use crate::{COMMIT, Caller};

/// The built-in robot of that name, else the one in that file.
pub fn model(text: &str) -> anyhow::Result<Model> {
    if Model::builtin_names().any(|name| name == text) {
        return Ok(Model::builtin(text)?);
    }
    if !text.contains(['.', '/']) && !Path::new(text).exists() {
        return Ok(Model::builtin(text)?);
    }
    Ok(Model::read(Path::new(text))?)
}

/// The drive of that name, else the one in that file.
pub fn drive(text: &str) -> anyhow::Result<CatalogueDrive> {
    let is_file = text.contains(['.', '/']);
    if !is_file || CatalogueDrive::names().any(|name| name == text) {
        return Ok(CatalogueDrive::named(text).map_err(|bad| BadInput { place: "--drive".into(), ..bad })?);
    }
    let read = file::read_text(Path::new(text))?;
    Ok(CatalogueDrive::parse(&read).map_err(|bad| bad.within(text))?)
}

/// The file that `text` is, if it is no name of something built in.
pub fn file_of(text: &str) -> Option<&str> {
    Some(text).filter(|text| Path::new(text).exists())
}

/// What a verb reads of a robot: its file, if it is not built in.
pub fn reads(text: &str) -> Outputs {
    Outputs::reading(file_of(text))
}

/// Who makes a recording, and what it is.
pub fn meta(caller: &Caller, source: &str) -> Metadata {
    Metadata {
        source: source.to_owned(),
        commit: COMMIT.to_owned(),
        command: caller.command.clone(),
        ..Metadata::default()
    }
}

/// The frame called `name`, or the last one.
fn frame(model: &Model, name: Option<&str>) -> anyhow::Result<usize> {
    match name {
        Some(name) => Ok(model.frame(name)?),
        None => Ok(model.frames().len() - 1),
    }
}
