//! The recipe: measures to mesh, mesh to files.

use std::path::Path;

use anyhow::Context as _;
use hysteron_base::{BadInput, LengthUnit, file};
use hysteron_fem::{MshEncoding, check_mesh, read_mesh, write_mesh, write_vtu};

use super::measures::tube;
use super::options::Options;
use super::outcome::{MeshSummary, Outcome};
use super::quality::print_quality;
use crate::shared::outputs::Outputs;
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(mesh(options, context)?)
}

/// Meshes the body, checks its elements, and writes it.
fn mesh(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    check_ending(&options.out, "--out", "msh")?;
    if let Some(vtu) = &options.vtu {
        check_ending(vtu, "--vtu", "vtu")?;
    }
    let mut mesh = tube(options)?.mesh()?;
    // Whole nanometres: shorter files, and the same on machines whose sines differ in the last digit.
    mesh.nodes.iter_mut().flatten().for_each(|x| *x = (*x * 1e9).round() / 1e9);
    let quality = check_mesh(&mesh, "the mesh of these measures")?;
    let encoding = if options.binary { MshEncoding::Binary } else { MshEncoding::Ascii };
    write_new("--out", &options.out, context, |path| {
        write_mesh(path, &mesh, LengthUnit::Millimetre.to_m(), encoding)
    })?;
    if let Some(vtu) = &options.vtu {
        write_new("--vtu", vtu, context, |path| write_vtu(path, &mesh.nodes, &mesh.cells, &[], &[]))?;
    }
    context.wrote(&options.out);
    print_quality(&mesh, &quality, context);
    Ok(Outcome { out: options.out.clone(), mesh: MeshSummary::new(&mesh, &quality) })
}

/// Writes a file without provenance: one that is there must be the same already, or with `--overwrite` a mesh as this
/// program writes it, byte for byte, which no other program does.
fn write_new(
    option: &'static str,
    path: &Path,
    context: &Context,
    write: impl Fn(&Path) -> hysteron_fem::Result<()>,
) -> anyhow::Result<()> {
    if path.exists() {
        let folder = tempfile::tempdir().context("making a temporary folder")?;
        let new = folder.path().join("new");
        write(&new)?;
        let found = std::fs::metadata(path)?;
        if found.is_file()
            && found.len() == std::fs::metadata(&new)?.len()
            && file::read_bytes(path)? == file::read_bytes(&new)?
        {
            return Ok(());
        }
        if context.overwrite && is_own_mesh(path, &new) {
            return Ok(file::write_bytes(path, file::read_bytes(&new)?)?);
        }
        let found = format!("{}, which these measures do not give", path.display());
        return Err(BadInput::new(option, "a new file", found)
            .hint(format!(
                "remove it, choose another {option}, or add --overwrite where it is a mesh by hysteron mesh"
            ))
            .into());
    }
    let _lock = Outputs::default().file(option, path).check(context)?;
    Ok(write(path)?)
}

/// Whether a file is a mesh that this program wrote: what it reads there it would write with the same bytes. `scratch` is written
/// over, and holds what it held before.
fn is_own_mesh(path: &Path, scratch: &Path) -> bool {
    let rewritten = || -> anyhow::Result<bool> {
        let (found, kept) = (file::read_bytes(path)?, file::read_bytes(scratch)?);
        let mesh = read_mesh(path, 1.0)?;
        let mut is_own = false;
        for encoding in [MshEncoding::Ascii, MshEncoding::Binary] {
            write_mesh(scratch, &mesh, 1.0, encoding)?;
            is_own |= file::read_bytes(scratch)? == found;
        }
        file::write_bytes(scratch, kept)?;
        Ok(is_own)
    };
    // What cannot be read is not this program's.
    rewritten().unwrap_or(false)
}

fn check_ending(path: &Path, option: &str, ending: &str) -> Result<(), BadInput> {
    if path.extension().is_some_and(|extension| extension == ending) {
        return Ok(());
    }
    Err(BadInput::new(option, format!("a name ending in .{ending}"), path.display().to_string()))
}
