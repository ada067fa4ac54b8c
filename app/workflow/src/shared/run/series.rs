//! A run as a series of pictures for ParaView: `robot.pvd` with a body and its tendons per moment.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use hysteron_fem::{ArrayValues, Cells, Polylines, Pvd, VtkArray, write_polylines, write_vtu};
use hysteron_twin::{Twin, TwinState};

/// The file of a series that lists its pictures and names the program.
const LIST: &str = "robot.pvd";

/// Files in this folder that a series would replace: its list; or where there is none, pictures of another
/// origin.
pub fn there(folder: &Path) -> Vec<PathBuf> {
    let list = folder.join(LIST);
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_picture = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        ["body_", "tendons_"].iter().any(|start| name.starts_with(start))
    };
    if list.exists() { vec![list] } else { entries.filter(is_picture).collect() }
}

/// The series that is being written.
#[derive(Debug)]
pub struct Series {
    folder: PathBuf,
    every: usize,
    list: Pvd,
    /// Tetrahedra and rest positions [m] in the order of the mesh file.
    cells: Cells,
    rest: Vec<[f64; 3]>,
}

impl Series {
    /// Starts a series in `folder`, which is created. Pictures of the samples that an earlier run has done
    /// (at `done` [s]) are listed where they are there.
    pub fn new(folder: &Path, twin: &Twin, every: usize, done: &[f64]) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("creating {}", folder.display()))?;
        let file_node = &twin.body.file_node;
        let cells = match &twin.body.cells {
            Cells::Tet4(cells) => Cells::Tet4(in_file(cells, file_node)),
            Cells::Tet10(cells) => Cells::Tet10(in_file(cells, file_node)),
        };
        let mut new = Self {
            folder: folder.to_owned(),
            every: every.max(1),
            list: Pvd::new(&folder.join(LIST))?,
            cells,
            rest: twin.body.in_file_order(&twin.body.rest),
        };
        for (row, time) in done.iter().enumerate().step_by(new.every) {
            for (part, file) in new.files(row).into_iter().enumerate().filter(|(_, file)| file.exists()) {
                new.list.add(*time, part as u32, &file)?;
            }
        }
        Ok(new)
    }

    /// Whether a sample has a picture.
    pub fn has(&self, row: usize) -> bool {
        row.is_multiple_of(self.every)
    }

    /// Writes a picture if this sample has one.
    pub fn add(&mut self, twin: &Twin, state: &TwinState, row: usize, time: f64) -> anyhow::Result<()> {
        if !self.has(row) {
            return Ok(());
        }
        let [body, tendons] = self.files(row);
        let nodes = twin.nodes_of(state);
        let points = twin.body.in_file_order(&nodes);
        let moved: Vec<[f64; 3]> =
            points.iter().zip(&self.rest).map(|(x, rest)| std::array::from_fn(|c| x[c] - rest[c])).collect();
        let displacement = VtkArray { name: "displacement_m", values: ArrayValues::Vectors(&moved) };
        write_vtu(&body, &points, &self.cells, &[displacement], &[])?;
        self.list.add(time, 0, &body)?;
        if !twin.cables.is_empty() {
            let lines: Vec<Vec<[f64; 3]>> =
                (0..twin.tendons.len()).map(|j| twin.cables.polyline(j, &nodes)).collect();
            let strokes = twin.strokes_of(state);
            let line_data = [
                VtkArray {
                    name: "tension_n",
                    values: ArrayValues::Scalars(&state.tensions[..twin.tendons.len()]),
                },
                VtkArray { name: "stroke_m", values: ArrayValues::Scalars(&strokes) },
            ];
            write_polylines(&tendons, Polylines { lines: &lines, line_data: &line_data })?;
            self.list.add(time, 1, &tendons)?;
        }
        Ok(())
    }

    /// Writes the list of all pictures.
    pub fn finish(&mut self) -> anyhow::Result<()> {
        Ok(self.list.finish()?)
    }

    /// Body and tendons of a sample.
    fn files(&self, row: usize) -> [PathBuf; 2] {
        let path = |name: &str, extension: &str| self.folder.join(format!("{name}_{row:06}.{extension}"));
        [path("body", "vtu"), path("tendons", "vtp")]
    }
}

fn in_file<const N: usize>(cells: &[[u32; N]], file_node: &[u32]) -> Vec<[u32; N]> {
    cells.iter().map(|cell| cell.map(|node| file_node[node as usize])).collect()
}
