//! Pictures for ParaView: deformed meshes, tendons, and time series of both.
//!
//! Main decision: binary XML, one file per moment, and a `.pvd` file that lists them by time. A `.pvd` is rewritten whole
//! while the run goes on, so a stopped run leaves a series that opens. The two kinds of file that are written here take fewer
//! lines than their model in a crate, whose parsers would be a thirtieth of the program's first build; the tests read them
//! through `vtkio`.

use std::io::Write;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hysteron_base::{BadInput, file};

use crate::{Cells, Error, Result};

/// A named array on points or cells.
#[derive(Debug, Clone, Copy)]
pub struct VtkArray<'a> {
    /// Name that ParaView shows; put the unit into it: `tension_n`.
    pub name: &'a str,
    /// One value per point or cell.
    pub values: ArrayValues<'a>,
}

/// The values of an [`VtkArray`].
#[derive(Debug, Clone, Copy)]
pub enum ArrayValues<'a> {
    /// Numbers.
    Scalars(&'a [f64]),
    /// Vectors.
    Vectors(&'a [[f64; 3]]),
}

/// Curves through space, such as tendons.
#[derive(Debug, Clone, Copy)]
pub struct Polylines<'a> {
    /// Points of every curve \[m\], at least two each.
    pub lines: &'a [Vec<[f64; 3]>],
    /// Arrays with one value per curve.
    pub line_data: &'a [VtkArray<'a>],
}

/// Writes a mesh with the given node positions \[m\] as `.vtu`.
///
/// # Errors
/// `BadInput` for a cell with a node out of range or an array of the wrong length or name; `NotFinite` for
/// a position; `File` where the file system refuses.
pub fn write_vtu(
    path: &Path,
    points: &[[f64; 3]],
    cells: &Cells,
    point_data: &[VtkArray<'_>],
    cell_data: &[VtkArray<'_>],
) -> Result<()> {
    check_points(points)?;
    let mut connectivity = Vec::new();
    let mut offsets = Vec::with_capacity(cells.len());
    for e in 0..cells.len() {
        for &n in cells.nodes(e) {
            if n as usize >= points.len() {
                return Err(BadInput::new(
                    format!("{}: tetrahedron {e}", path.display()),
                    format!("nodes below {}", points.len()),
                    n.to_string(),
                )
                .into());
            }
            connectivity.push(u64::from(n));
        }
        offsets.push(connectivity.len() as u64);
    }
    check_arrays(path, point_data, points.len(), "points")?;
    check_arrays(path, cell_data, cells.len(), "cells")?;
    // Names of the numbers in VTK's source: VTK_TETRA and VTK_QUADRATIC_TETRA.
    let kind = match cells {
        Cells::Tet4(_) => 10,
        Cells::Tet10(_) => 24,
    };
    let size = format!("NumberOfPoints=\"{}\" NumberOfCells=\"{}\"", points.len(), cells.len());
    write(path, "UnstructuredGrid", &size, |out| {
        write_attributes(out, "PointData", point_data)?;
        write_attributes(out, "CellData", cell_data)?;
        write_points(out, points)?;
        write!(out, "<Cells>")?;
        write_numbers(out, "connectivity", ArrayContent::Counts(&connectivity))?;
        write_numbers(out, "offsets", ArrayContent::Counts(&offsets))?;
        write_numbers(out, "types", ArrayContent::Bytes(&vec![kind; cells.len()]))?;
        write!(out, "</Cells>")
    })
}

/// Writes curves as `.vtp`.
///
/// # Errors
/// `BadInput` for a curve of fewer than two points or an array of the wrong length or name; `NotFinite`
/// for a point, counted over all curves; `File` where the file system refuses.
pub fn write_polylines(path: &Path, curves: Polylines<'_>) -> Result<()> {
    let points = curves.lines.concat();
    check_points(&points)?;
    let mut offsets = Vec::with_capacity(curves.lines.len());
    let mut end = 0;
    for (k, line) in curves.lines.iter().enumerate() {
        if line.len() < 2 {
            return Err(BadInput::new(
                format!("{}: line {k}", path.display()),
                "at least two points",
                line.len().to_string(),
            )
            .into());
        }
        end += line.len() as u64;
        offsets.push(end);
    }
    check_arrays(path, curves.line_data, curves.lines.len(), "lines")?;
    let size = format!("NumberOfPoints=\"{}\" NumberOfLines=\"{}\"", points.len(), curves.lines.len());
    write(path, "PolyData", &size, |out| {
        write_attributes(out, "CellData", curves.line_data)?;
        write_points(out, &points)?;
        write!(out, "<Lines>")?;
        write_numbers(out, "connectivity", ArrayContent::Counts(&(0..end).collect::<Vec<u64>>()))?;
        write_numbers(out, "offsets", ArrayContent::Counts(&offsets))?;
        write!(out, "</Lines>")
    })
}

fn check_points(points: &[[f64; 3]]) -> Result<()> {
    match points.iter().position(|x| x.iter().any(|v| !v.is_finite())) {
        Some(node) => Err(Error::NotFinite { quantity: "position", node }),
        None => Ok(()),
    }
}

fn check_arrays(path: &Path, arrays: &[VtkArray<'_>], n: usize, of: &str) -> Result<()> {
    for array in arrays {
        check_word(path, array.name)?;
        let len = match array.values {
            ArrayValues::Scalars(values) => values.len(),
            ArrayValues::Vectors(values) => values.len(),
        };
        if len != n {
            return Err(BadInput::new(
                format!("{}: array {}", path.display(), array.name),
                format!("{n} values, one for each of the {of}"),
                len.to_string(),
            )
            .into());
        }
    }
    Ok(())
}

/// Names go into XML as they are.
fn check_word(path: &Path, word: &str) -> Result<()> {
    if word.is_empty() || word.contains(|c: char| c.is_control() || "\"'<>&".contains(c)) {
        return Err(BadInput::new(
            path.display().to_string(),
            "names without quotes, <, > and &",
            format!("{word:?}"),
        )
        .into());
    }
    Ok(())
}

/// A file of one piece, whose content `piece` writes.
fn write(
    path: &Path,
    kind: &str,
    size: &str,
    piece: impl Fn(&mut dyn Write) -> std::io::Result<()>,
) -> Result<()> {
    let content = |out: &mut dyn Write| {
        write!(
            out,
            "<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><{kind}><Piece {size}>"
        )?;
        piece(out)?;
        write!(out, "</Piece></{kind}></VTKFile>")
    };
    Ok(file::write_with(path, content)?)
}

/// Arrays on points or cells; the first of scalars and the first of vectors are what ParaView shows.
fn write_attributes(out: &mut dyn Write, element: &str, arrays: &[VtkArray<'_>]) -> std::io::Result<()> {
    if arrays.is_empty() {
        return Ok(());
    }
    write!(out, "<{element}")?;
    let is_vectors = |array: &&VtkArray<'_>| matches!(array.values, ArrayValues::Vectors(_));
    if let Some(first) = arrays.iter().find(|array| !is_vectors(array)) {
        write!(out, " Scalars=\"{}\"", first.name)?;
    }
    if let Some(first) = arrays.iter().find(is_vectors) {
        write!(out, " Vectors=\"{}\"", first.name)?;
    }
    write!(out, ">")?;
    for array in arrays {
        let numbers = match array.values {
            ArrayValues::Scalars(values) => ArrayContent::Scalars(values),
            ArrayValues::Vectors(values) => ArrayContent::Vectors(values),
        };
        write_numbers(out, array.name, numbers)?;
    }
    write!(out, "</{element}>")
}

fn write_points(out: &mut dyn Write, points: &[[f64; 3]]) -> std::io::Result<()> {
    write!(out, "<Points>")?;
    write_numbers(out, "Points", ArrayContent::Vectors(points))?;
    write!(out, "</Points>")
}

/// Content of a `DataArray`.
enum ArrayContent<'a> {
    Scalars(&'a [f64]),
    Vectors(&'a [[f64; 3]]),
    Counts(&'a [u64]),
    Bytes(&'a [u8]),
}

/// A `DataArray`: the number of bytes and the bytes, in base 64.
fn write_numbers(out: &mut dyn Write, name: &str, numbers: ArrayContent<'_>) -> std::io::Result<()> {
    let (kind, components, bytes) = match numbers {
        ArrayContent::Scalars(values) => {
            ("Float64", "", little_endian(values.iter().map(|v| v.to_le_bytes())))
        }
        ArrayContent::Vectors(values) => {
            let values = values.as_flattened().iter();
            ("Float64", " NumberOfComponents=\"3\"", little_endian(values.map(|v| v.to_le_bytes())))
        }
        ArrayContent::Counts(values) => ("UInt64", "", little_endian(values.iter().map(|v| v.to_le_bytes()))),
        ArrayContent::Bytes(values) => ("UInt8", "", little_endian(values.iter().map(|v| [*v]))),
    };
    let text = STANDARD.encode(bytes);
    write!(out, "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"binary\">{text}</DataArray>")
}

/// Their number of bytes, and the bytes.
fn little_endian<const N: usize>(values: impl ExactSizeIterator<Item = [u8; N]>) -> Vec<u8> {
    let size = N * values.len();
    let mut bytes = Vec::with_capacity(8 + size);
    bytes.extend((size as u64).to_le_bytes());
    for value in values {
        bytes.extend_from_slice(&value);
    }
    bytes
}

/// A time series: lists files by time in a `.pvd` that ParaView opens as one animation.
///
/// The file is rewritten when it is 5 % behind, and by [`Pvd::finish`]; what is there is always whole.
#[derive(Debug)]
pub struct Pvd {
    path: PathBuf,
    /// Time \[s\], part, file.
    entries: Vec<(f64, u32, String)>,
    n_written: usize,
}

impl Pvd {
    /// Starts a series and writes it, still empty.
    ///
    /// # Errors
    /// `File` where the file system refuses.
    pub fn new(path: &Path) -> Result<Self> {
        let mut series = Self { path: path.to_owned(), entries: Vec::new(), n_written: 0 };
        series.finish()?;
        Ok(series)
    }

    /// Adds a file at a time \[s\]; `part` distinguishes files of the same time (0 the body, 1 the tendons).
    ///
    /// # Errors
    /// `BadInput` for a time that is not finite or a file name unfit for XML; `File` where the file system
    /// refuses.
    pub fn add(&mut self, time_s: f64, part: u32, file: &Path) -> Result<()> {
        if !time_s.is_finite() {
            return Err(
                BadInput::new(self.path.display().to_string(), "a finite time", time_s.to_string()).into()
            );
        }
        // Relative to the series, so that the folder can be moved.
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let file = file.strip_prefix(folder).unwrap_or(file).display().to_string().replace('\\', "/");
        check_word(&self.path, &file)?;
        self.entries.push((time_s, part, file));
        if self.entries.len() - self.n_written > self.n_written / 20 {
            self.finish()?;
        }
        Ok(())
    }

    /// Writes what has been added so far.
    ///
    /// # Errors
    /// `File` where the file system refuses.
    pub fn finish(&mut self) -> Result<()> {
        file::write_with(&self.path, |out| {
            writeln!(out, "<?xml version=\"1.0\"?>")?;
            writeln!(out, "<!-- generator: hysteron -->")?;
            writeln!(out, "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">")?;
            writeln!(out, "  <Collection>")?;
            for (time, part, file) in &self.entries {
                writeln!(
                    out,
                    "    <DataSet timestep=\"{time}\" group=\"\" part=\"{part}\" file=\"{file}\"/>"
                )?;
            }
            writeln!(out, "  </Collection>")?;
            writeln!(out, "</VTKFile>")
        })?;
        self.n_written = self.entries.len();
        Ok(())
    }
}
