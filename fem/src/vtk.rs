//! Pictures for ParaView: deformed meshes, tendons, and time series of both.
//!
//! Main decision: binary XML through the crate `vtkio`, which only this module names, one file per moment,
//! and a `.pvd` file that lists them by time. A `.pvd` is rewritten whole while the run goes on, so a
//! stopped run leaves a series that opens.

use std::io::Write;
use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, file};
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells as VtkCells, DataArray, DataSet, IOBuffer,
    PolyDataPiece, UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};

use crate::{Cells, Error, Result};

/// A named array on points or cells.
#[derive(Debug, Clone, Copy)]
pub struct Array<'a> {
    /// Name that ParaView shows; put the unit into it: `tension_n`.
    pub name: &'a str,
    /// One value per point or cell.
    pub values: Values<'a>,
}

/// The values of an [`Array`].
#[derive(Debug, Clone, Copy)]
pub enum Values<'a> {
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
    pub line_data: &'a [Array<'a>],
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
    point_data: &[Array<'_>],
    cell_data: &[Array<'_>],
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
    let kind = match cells {
        Cells::Tet4(_) => CellType::Tetra,
        Cells::Tet10(_) => CellType::QuadraticTetra,
    };
    let data = Attributes {
        point: attributes(path, point_data, points.len(), "points")?,
        cell: attributes(path, cell_data, cells.len(), "cells")?,
    };
    write(
        path,
        DataSet::inline(UnstructuredGridPiece {
            points: IOBuffer::F64(points.as_flattened().to_vec()),
            cells: VtkCells {
                cell_verts: VertexNumbers::XML { connectivity, offsets },
                types: vec![kind; cells.len()],
            },
            data,
        }),
    )
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
    let data = Attributes {
        point: Vec::new(),
        cell: attributes(path, curves.line_data, curves.lines.len(), "lines")?,
    };
    write(
        path,
        DataSet::inline(PolyDataPiece {
            points: IOBuffer::F64(points.as_flattened().to_vec()),
            lines: Some(VertexNumbers::XML { connectivity: (0..end).collect(), offsets }),
            data,
            ..PolyDataPiece::default()
        }),
    )
}

fn check_points(points: &[[f64; 3]]) -> Result<()> {
    match points.iter().position(|x| x.iter().any(|v| !v.is_finite())) {
        Some(node) => Err(Error::NotFinite { quantity: "position", node }),
        None => Ok(()),
    }
}

fn attributes(path: &Path, arrays: &[Array<'_>], n: usize, of: &str) -> Result<Vec<Attribute>> {
    let mut out = Vec::with_capacity(arrays.len());
    for array in arrays {
        check_word(path, array.name)?;
        let (len, values) = match array.values {
            Values::Scalars(values) => {
                (values.len(), DataArray::scalars(array.name, 1).with_data(values.to_vec()))
            }
            Values::Vectors(values) => {
                (values.len(), DataArray::vectors(array.name).with_data(values.as_flattened().to_vec()))
            }
        };
        if len != n {
            return Err(BadInput::new(
                format!("{}: array {}", path.display(), array.name),
                format!("{n} values, one for each of the {of}"),
                len.to_string(),
            )
            .into());
        }
        out.push(Attribute::DataArray(values));
    }
    Ok(out)
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

fn write(path: &Path, data: DataSet) -> Result<()> {
    let vtk = Vtk {
        version: Version::new_xml(1, 0),
        title: String::new(),
        byte_order: ByteOrder::LittleEndian,
        data,
        file_path: None,
    };
    let content = |out: &mut dyn Write| vtk.write_xml(out).map_err(|e| std::io::Error::other(e.to_string()));
    Ok(file::write_with(path, content)?)
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

    /// Adds a file at a time \[s\]; `part` tells apart files of the same time (0 the body, 1 the tendons).
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
