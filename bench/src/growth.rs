//! How the time of every reader grows with its file: a file of n, 2n and 4n things, and the exponent of time over n.
//!
//! A reader that is added gets a row in `READERS`.
#![allow(clippy::print_stdout)] // this program prints tables

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Result, ensure};
use hysteron_arm_dynamics::Model;
use hysteron_base::{Channel, Metadata, Recording, file, json};
use hysteron_fem::read_mesh;

use crate::measure::{machine, shortest};
use crate::table::{FigureTarget, TableRow, print_rows};
use crate::targets::slope;

/// Largest exponent of time over size: linear, with what caches and the noise of a busy machine add.
const MAX_EXPONENT: f64 = 1.3;
/// Files of these multiples of the first size.
const MULTIPLES: [usize; 3] = [1, 2, 4];

/// Outcome of reading the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Read,
    /// The file is larger than the reader's limit, and the error names it.
    Refused,
}

/// A reader, what its file has many of, and how such a file is made.
struct Reader {
    name: &'static str,
    things: &'static str,
    /// Things in the smallest file.
    n: usize,
    ending: &'static str,
    write: fn(usize, &Path) -> Result<()>,
    read: fn(&Path) -> bool,
    outcome: Outcome,
}

const fn robot(
    name: &'static str,
    things: &'static str,
    n: usize,
    write: fn(usize, &Path) -> Result<()>,
    outcome: Outcome,
) -> Reader {
    Reader { name, things, n, ending: "xml", write, read: |path| Model::read(path).is_ok(), outcome }
}

const READERS: [Reader; 9] = [
    robot("URDF", "links by fixed joints", 2000, links_in_urdf, Outcome::Read),
    robot("URDF", "links in a chain that moves", 2000, chain_in_urdf, Outcome::Refused),
    robot("URDF", "attributes", 10_000, attributes_in_urdf, Outcome::Read),
    robot("URDF", "attributes of one element", 10_000, attributes_of_one, Outcome::Refused),
    robot("xacro", "calls of a macro", 1000, calls_in_xacro, Outcome::Read),
    robot("MJCF", "bodies", 2000, bodies_in_mjcf, Outcome::Read),
    Reader {
        name: "recording, CSV",
        things: "rows",
        n: 10_000,
        ending: "csv",
        write: rows,
        read: |path| Recording::read(path).is_ok(),
        outcome: Outcome::Read,
    },
    Reader {
        name: "recording, Parquet",
        things: "rows",
        n: 50_000,
        ending: "parquet",
        write: rows,
        read: |path| Recording::read(path).is_ok(),
        outcome: Outcome::Read,
    },
    Reader {
        name: "MSH 4.1",
        things: "cells of six tetrahedra",
        n: 2000,
        ending: "msh",
        write: cells,
        read: |path| read_mesh(path, 1.0).is_ok(),
        outcome: Outcome::Read,
    },
];

/// Measures all readers, prints the table and writes FOLDER/growth/metrics.json.
///
/// # Errors
/// A file that cannot be written; a reader whose result differs from its row, or whose time grows too fast.
pub fn run(folder: &Path, quick: bool) -> Result<()> {
    let scratch = tempfile::tempdir()?;
    let mut rows = Vec::new();
    let mut details = Vec::new();
    for reader in &READERS {
        let n = if quick { reader.n / 4 } else { reader.n };
        let mut points = Vec::new();
        for multiple in MULTIPLES {
            let size = n * multiple;
            let path = scratch.path().join(format!("{size}.{}", reader.ending));
            (reader.write)(size, &path)?;
            let is_read = (reader.read)(&path);
            let is_expected = is_read == (reader.outcome == Outcome::Read);
            ensure!(is_expected, "{} of {size} {}: not {:?}", reader.name, reader.things, reader.outcome);
            let seconds = shortest(3, || _ = (reader.read)(&path));
            points.push([size as f64, seconds]);
        }
        let logarithms: Vec<[f64; 2]> = points.iter().map(|point| point.map(f64::ln)).collect();
        let name = format!("{}: exponent over {}", reader.name, reader.things);
        rows.push(TableRow::new(name, slope(&logarithms), "-").goal(FigureTarget::AtMost(MAX_EXPONENT)));
        if let Some([size, seconds]) = points.last() {
            rows.push(TableRow::new(
                format!("{}: {size} {}", reader.name, reader.things),
                1e3 * seconds,
                "ms",
            ));
        }
        details.push(json!({ "reader": reader.name, "things": reader.things, "sizes_and_seconds": points }));
    }
    print_rows(&rows);
    let path = folder.join("metrics.json");
    let report = json!({ "machine": machine(), "rows": rows, "details": details });
    file::write_bytes(&path, json::to_text(&report)?)?;
    println!("\nwritten to {}", path.display());
    let too_fast = rows.iter().find(|row| row.met == Some(false));
    ensure!(quick || too_fast.is_none(), "time grows too fast: {too_fast:?}");
    Ok(())
}

const INERTIAL: &str =
    r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"#;

/// A robot whose links hang on each other by joints of a type.
fn urdf(n: usize, kind: &str, link: &str) -> String {
    let mut text = format!("<robot name=\"r\">\n<link name=\"l0\"/>\n<link name=\"l1\">{INERTIAL}</link>\n");
    let limit = "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>";
    let ends = "<parent link=\"l0\"/><child link=\"l1\"/>";
    let _ = writeln!(text, "<joint name=\"j1\" type=\"revolute\">{ends}{limit}</joint>");
    for k in 2..=n {
        let ends = format!("<parent link=\"l{}\"/><child link=\"l{k}\"/>", k - 1);
        let _ = writeln!(text, "<link name=\"l{k}\">{link}</link>");
        let _ = writeln!(text, "<joint name=\"j{k}\" type=\"{kind}\">{ends}{limit}</joint>");
    }
    text + "</robot>\n"
}

fn links_in_urdf(n: usize, path: &Path) -> Result<()> {
    Ok(file::write_bytes(path, urdf(n, "fixed", ""))?)
}

fn chain_in_urdf(n: usize, path: &Path) -> Result<()> {
    Ok(file::write_bytes(path, urdf(n, "revolute", INERTIAL))?)
}

fn attributes_in_urdf(n: usize, path: &Path) -> Result<()> {
    // A hundred each, of elements without effect.
    let visual: String = (0..n / 100)
        .map(|_| format!("<visual{}/>", (0..100).map(|k| format!(" a{k}=\"{k}\"")).collect::<String>()))
        .collect();
    Ok(file::write_bytes(path, urdf(2, "fixed", &visual))?)
}

fn attributes_of_one(n: usize, path: &Path) -> Result<()> {
    let visual: String = (0..n).map(|k| format!(" a{k}=\"{k}\"")).collect();
    Ok(file::write_bytes(path, urdf(2, "fixed", &format!("<visual{visual}/>")))?)
}

fn calls_in_xacro(n: usize, path: &Path) -> Result<()> {
    let made = "<xacro:macro name=\"part\" params=\"k\"><link name=\"p${k}\"/><joint name=\"f${k}\" type=\"fixed\">\
        <origin xyz=\"${k*0.001} 0 ${sin(pi/4)}\"/><parent link=\"l1\"/><child link=\"p${k}\"/></joint></xacro:macro>";
    let calls: String = (0..n).map(|k| format!("<xacro:part k=\"{k}\"/>\n")).collect();
    let text = urdf(2, "fixed", "").replace("<robot", "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\"");
    Ok(file::write_bytes(path, text.replace("</robot>", &format!("{made}\n{calls}</robot>")))?)
}

fn bodies_in_mjcf(n: usize, path: &Path) -> Result<()> {
    let inertial = "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>";
    let bodies: String = (0..n).map(|k| format!("<body name=\"b{k}\">{inertial}</body>\n")).collect();
    let arm = format!("<body name=\"arm\"><joint name=\"j\"/>{inertial}\n{bodies}</body>");
    Ok(file::write_bytes(path, format!("<mujoco><worldbody>{arm}</worldbody></mujoco>\n"))?)
}

fn rows(n: usize, path: &Path) -> Result<()> {
    let time: Vec<f64> = (0..n).map(|k| 0.01 * k as f64).collect();
    let names = ["stroke_1_m", "stroke_2_m", "tip_x_m", "tip_y_m", "tip_z_m"];
    let wave = |c: usize| time.iter().map(|t| 1e-3 * (t * (1.0 + c as f64)).sin()).collect();
    let channels = names.iter().enumerate().map(|(c, name)| Channel::new(*name, wave(c))).collect();
    let recording = Recording::new(time.clone(), channels, Vec::new(), Metadata::default())?;
    Ok(recording.write(path)?)
}

/// A bar of cubes, six tetrahedra each.
fn cells(n: usize, path: &Path) -> Result<()> {
    const TETRAHEDRA: [[usize; 4]; 6] =
        [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];
    let (n_nodes, n_elements) = (4 * (n + 1), 6 * n);
    let mut text = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n");
    let _ = writeln!(text, "1 {n_nodes} 1 {n_nodes}\n3 1 0 {n_nodes}");
    (1..=n_nodes).for_each(|k| _ = writeln!(text, "{k}"));
    for k in 0..n_nodes {
        let _ = writeln!(text, "{} {} {}", k % 2, k / 2 % 2, k / 4);
    }
    let _ = writeln!(text, "$EndNodes\n$Elements\n1 {n_elements} 1 {n_elements}\n3 1 4 {n_elements}");
    for (k, [a, b, c, d]) in
        (0..n).flat_map(|cell| TETRAHEDRA.map(|t| t.map(|i| 4 * cell + i + 1))).enumerate()
    {
        let _ = writeln!(text, "{} {a} {b} {c} {d}", k + 1);
    }
    text.push_str("$EndElements\n");
    Ok(file::write_bytes(path, text)?)
}
