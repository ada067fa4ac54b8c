//! Masses of triangle meshes: binary STL, OBJ, MuJoCo's MSH and vertices in the file itself.
//!
//! Vertices are single precision, as in MuJoCo, and everything after them double.
//!
//! # Reference
//! MuJoCo 4.0.0, XML reference, asset/mesh; O'Rourke (1998), Computational Geometry in C, section 1.3.8.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::super::xml::Check;
use super::attributes::Attributes;
use super::element::{MjcfElement, brief};
use super::mass::ShapeMoments;
use super::orientation::of_quaternion;
use super::settings::Settings;
use crate::spatial::{Sym3, Vec3, add_scaled3, cross, dot3, mul3_transposed, sub3};

/// The largest mesh file that is opened.
const MAX_BYTES: u64 = 64 << 20;
/// Triangles of a mesh.
const MAX_TRIANGLES: usize = 2_000_000;

/// Vertices [m] and triangles of a mesh.
#[derive(Debug, Default)]
struct TriangleMesh {
    vertices: Vec<Vec3<f64>>,
    triangles: Vec<[usize; 3]>,
}

/// How a mesh is taken as a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Filling {
    /// Pyramids from the centre to every triangle, each counted in full.
    Legacy,
    /// The volume that the triangles enclose.
    Exact,
    /// The triangles alone.
    Shell,
}

/// Name of a mesh: its own, or that of its file.
pub(super) fn name(element: &MjcfElement) -> Option<String> {
    let stem = |text: &str| Some(Path::new(text).file_stem()?.to_str()?.to_owned());
    element.attribute("name").map(str::to_owned).or_else(|| element.attribute("file").and_then(stem))
}

/// The shape of a mesh asset, whose file is found from `folder`, that of the first file.
///
/// # Errors
/// `BadInput` for a mesh without or with a damaged file, or one that has no inertia of this kind.
pub(super) fn shape(at: &Attributes, settings: &Settings, folder: Option<&Path>) -> Check<ShapeMoments> {
    let fillings = ["legacy", "exact", "shell", "convex"];
    let filling = match at.word("inertia", &fillings)? {
        0 => Filling::Legacy,
        1 => Filling::Exact,
        2 => Filling::Shell,
        _ => {
            return Err(at
                .element
                .error("inertia legacy, exact or shell: convex hulls are not computed", "inertia=\"convex\"")
                .hint("give the body an <inertial>, or save the compiled model (mj_saveLastXML)"));
        }
    };
    let mut mesh = match at.text("file") {
        Some(file) => from_file(at, file, settings, folder)?,
        None => from_text(at)?,
    };
    if mesh.triangles.is_empty() {
        return Err(at
            .element
            .error("a mesh with triangles: convex hulls of points are not computed", "points alone")
            .hint("give the body an <inertial>, or save the compiled model (mj_saveLastXML)"));
    }
    let scale = at.array("scale")?.unwrap_or([1.0; 3]);
    let origin: Vec3<f64> = at.array("refpos")?.unwrap_or_default();
    let turned = of_quaternion(at.array("refquat")?.unwrap_or([1.0, 0.0, 0.0, 0.0]))
        .ok_or_else(|| at.element.error("a refquat longer than zero", "zero"))?;
    for vertex in &mut mesh.vertices {
        let there = mul3_transposed(&turned, sub3(*vertex, origin));
        *vertex = std::array::from_fn(|k| there[k] * scale[k]);
    }
    let is_mirrored = scale.iter().product::<f64>() < 0.0;
    if is_mirrored {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    mesh.shape(filling).map_err(|found| {
        at.element.error("a mesh that encloses a volume", found).hint("give the body an <inertial>")
    })
}

impl TriangleMesh {
    fn shape(&self, filling: Filling) -> Result<ShapeMoments, String> {
        if filling == Filling::Exact && !self.is_closed() {
            return Err("edges that do not belong to two triangles".to_owned());
        }
        // Area, and centre of the surface.
        let mut area = 0.0;
        let mut middle = [0.0; 3];
        for corners in self.corners() {
            let (doubled, centre) = (doubled_area(&corners), centre(&corners));
            area += 0.5 * dot3(doubled, doubled).sqrt();
            middle = add_scaled3(middle, 0.5 * dot3(doubled, doubled).sqrt(), centre);
        }
        if area < 1e-14 {
            return Err(format!("an area of {area:e} m²"));
        }
        let middle = middle.map(|m| m / area);
        if filling == Filling::Shell {
            let (mut size, mut second) = (0.0, [0.0; 6]);
            for corners in self.corners() {
                let corners = corners.map(|corner| sub3(corner, middle));
                let doubled = doubled_area(&corners);
                let part = 0.5 * dot3(doubled, doubled).sqrt();
                size += part;
                add_products(&mut second, &corners, part / 12.0);
            }
            return Ok(ShapeMoments { size, centre: middle, second: moments(second) });
        }
        let (size, centre) = self.centre_of_volume(middle, filling);
        if size < 1e-14 {
            return Err(format!("a volume of {size:e} m³"));
        }
        let (mut size, mut second) = (0.0, [0.0; 6]);
        for corners in self.corners() {
            let corners = corners.map(|corner| sub3(corner, centre));
            let volume = signed(dot3(corners[0], cross(corners[1], corners[2])) / 6.0, filling);
            size += volume;
            add_products(&mut second, &corners, volume / 20.0);
        }
        Ok(ShapeMoments { size, centre, second: moments(second) })
    }

    /// Volume of the pyramids from `apex` to the triangles, and its centre.
    fn centre_of_volume(&self, apex: Vec3<f64>, filling: Filling) -> (f64, Vec3<f64>) {
        let (mut size, mut first) = (0.0, [0.0; 3]);
        for corners in self.corners() {
            let at = corners.map(|corner| sub3(corner, apex));
            let volume = signed(dot3(at[0], cross(at[1], at[2])) / 6.0, filling);
            size += volume;
            let middle: Vec3<f64> = std::array::from_fn(|k| 0.75 * centre(&corners)[k] + 0.25 * apex[k]);
            first = add_scaled3(first, volume, middle);
        }
        (size, first.map(|h| h / size))
    }

    fn corners(&self) -> impl Iterator<Item = [Vec3<f64>; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|vertex| self.vertices[vertex]))
    }

    /// True where every edge belongs to two triangles that run along it in opposite directions.
    fn is_closed(&self) -> bool {
        let mut edges: BTreeMap<[usize; 2], i32> = BTreeMap::new();
        for [a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let turns = if from < to { 1 } else { -1 };
                *edges.entry([*from.min(to), *from.max(to)]).or_default() += turns;
            }
        }
        edges.values().all(|turns| *turns == 0)
    }

    /// Gives vertices at the same place one number.
    fn merge_vertices(&mut self) {
        let mut numbers = BTreeMap::new();
        let mut kept = Vec::new();
        let moved: Vec<usize> = self
            .vertices
            .iter()
            .map(|vertex| {
                // Zero has two signs.
                *numbers.entry(vertex.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                    kept.push(*vertex);
                    kept.len() - 1
                })
            })
            .collect();
        self.triangles.iter_mut().flatten().for_each(|vertex| *vertex = moved[*vertex]);
        self.vertices = kept;
    }
}

fn signed(volume: f64, filling: Filling) -> f64 {
    if filling == Filling::Legacy { volume.abs() } else { volume }
}

fn doubled_area([a, b, c]: &[Vec3<f64>; 3]) -> Vec3<f64> {
    cross(sub3(*b, *a), sub3(*c, *a))
}

fn centre([a, b, c]: &[Vec3<f64>; 3]) -> Vec3<f64> {
    std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0)
}

/// Adds `weight` times the products of the corners with each other and with their sum: xx, xy, yy, xz, yz, zz.
fn add_products(second: &mut Sym3<f64>, corners: &[Vec3<f64>; 3], weight: f64) {
    let sum: Vec3<f64> = std::array::from_fn(|k| corners.iter().map(|corner| corner[k]).sum());
    for (value, (i, j)) in second.iter_mut().zip([(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]) {
        let own: f64 = corners.iter().map(|corner| corner[i] * corner[j]).sum();
        *value += weight * (own + sum[i] * sum[j]);
    }
}

/// Moments of inertia of sums of products.
fn moments([xx, xy, yy, xz, yz, zz]: Sym3<f64>) -> Sym3<f64> {
    [yy + zz, -xy, xx + zz, -xz, -yz, xx + yy]
}

/// Vertices and triangles in the file itself.
fn from_text(at: &Attributes) -> Check<TriangleMesh> {
    let Some(numbers) = at.numbers("vertex")? else {
        return Err(at.element.error("a mesh with file or vertex", "neither"));
    };
    let triples = |numbers: &[f64], name: &str| match numbers.len() % 3 {
        0 => Ok(()),
        _ => Err(at
            .element
            .error(&format!("three numbers for each item of {name}"), numbers.len().to_string())),
    };
    triples(&numbers, "vertex")?;
    let faces = at.numbers("face")?.unwrap_or_default();
    triples(&faces, "face")?;
    let vertices: Vec<Vec3<f64>> =
        numbers.chunks(3).map(|c| [c[0], c[1], c[2]].map(|x| f64::from(x as f32))).collect();
    let count = vertices.len() as f64;
    if let Some(other) = faces.iter().find(|x| !(x.fract() == 0.0 && **x >= 0.0 && **x < count)) {
        return Err(at
            .element
            .error(&format!("numbers of vertices 0 to {}", count - 1.0), other.to_string()));
    }
    let triangles = faces.chunks(3).map(|c| [c[0] as usize, c[1] as usize, c[2] as usize]).collect();
    Ok(TriangleMesh { vertices, triangles })
}

fn from_file(at: &Attributes, file: &str, settings: &Settings, folder: Option<&Path>) -> Check<TriangleMesh> {
    let path = locate(at, file, settings, folder)?;
    let refused = |expected: &str, found: String| {
        Err(at.element.error(&format!("{}: {expected}", path.display()), found))
    };
    let mut bytes = Vec::new();
    let read = File::open(&path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes));
    if let Err(error) = read {
        return refused("a mesh that can be read", error.to_string());
    }
    if bytes.len() as u64 > MAX_BYTES {
        return refused(&format!("at most {} MB", MAX_BYTES >> 20), "more".to_owned());
    }
    let by_type = at.text("content_type").and_then(|text| text.rsplit(['/', '.']).next());
    let ending = by_type.or_else(|| path.extension()?.to_str()).unwrap_or_default().to_ascii_lowercase();
    let mesh = match ending.as_str() {
        "stl" => stl(&bytes),
        "obj" => obj(&bytes),
        "msh" => msh(&bytes),
        _ => return refused("a mesh .stl, .obj or .msh", format!("\"{}\"", brief(&ending))),
    };
    match mesh {
        Ok(mesh) if mesh.triangles.len() > MAX_TRIANGLES => {
            refused(&format!("at most {MAX_TRIANGLES} triangles"), mesh.triangles.len().to_string())
        }
        Ok(mesh) => Ok(mesh),
        Err(found) => refused(&format!("a whole mesh of type {ending}"), found),
    }
}

fn locate(at: &Attributes, file: &str, settings: &Settings, folder: Option<&Path>) -> Check<PathBuf> {
    let Some(folder) = folder else {
        return Err(at
            .element
            .error("a robot in one text", format!("another file, \"{}\"", brief(file)))
            .hint("give the robot as a file, so that the others are found next to it"));
    };
    // Paths of other systems.
    let file = file.replace('\\', "/");
    let file = if settings.strips_paths { file.rsplit('/').next().unwrap_or_default() } else { &file };
    let first = folder.join(&settings.mesh_folder).join(file);
    // A file that is included may name files next to it.
    let own = Path::new(at.element.file()).parent().filter(|own| !own.as_os_str().is_empty());
    let included = own.map(|own| own.join(&settings.mesh_folder).join(file));
    Ok(included.filter(|path| !first.is_file() && path.is_file()).unwrap_or(first))
}

fn float(bytes: &[u8]) -> f64 {
    f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
}

fn count(bytes: &[u8]) -> usize {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize
}

fn finite(mesh: TriangleMesh) -> Result<TriangleMesh, String> {
    match mesh.vertices.iter().flatten().find(|x| !x.is_finite()) {
        Some(x) => Err(format!("a vertex at {x}")),
        None => Ok(mesh),
    }
}

/// Binary STL: 80 bytes, the number of triangles, 50 bytes for each.
fn stl(bytes: &[u8]) -> Result<TriangleMesh, String> {
    const HEAD: usize = 84;
    const RECORD: usize = 50;
    let Some(number) = bytes.get(80..HEAD).map(count) else { return Err(format!("{} bytes", bytes.len())) };
    if number.checked_mul(RECORD).is_none_or(|size| bytes.len() != HEAD + size) {
        let kind = if bytes.starts_with(b"solid") { " (text? MuJoCo reads binary STL alone)" } else { "" };
        return Err(format!("{} bytes for {number} triangles{kind}", bytes.len()));
    }
    let mut mesh = TriangleMesh::default();
    for record in bytes[HEAD..].chunks(RECORD) {
        let first = mesh.vertices.len();
        for corner in 0..3 {
            let at = &record[12 + 12 * corner..];
            mesh.vertices.push([float(at), float(&at[4..]), float(&at[8..])]);
        }
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    let mut mesh = finite(mesh)?;
    mesh.merge_vertices();
    Ok(mesh)
}

/// MuJoCo's own format: four counts, positions, normals, texture coordinates, triangles.
fn msh(bytes: &[u8]) -> Result<TriangleMesh, String> {
    if bytes.len() < 16 {
        return Err(format!("{} bytes", bytes.len()));
    }
    let [vertices, normals, texture, faces] = [0, 4, 8, 12].map(|at| count(&bytes[at..]));
    let triples = vertices.checked_add(normals).and_then(|n| n.checked_add(faces));
    let size = triples
        .and_then(|n| n.checked_mul(12))
        .and_then(|n| n.checked_add(texture.checked_mul(8)?))
        .and_then(|n| n.checked_add(16));
    if size != Some(bytes.len()) {
        return Err(format!("{} bytes for {vertices} vertices and {faces} triangles", bytes.len()));
    }
    let (positions, rest) = bytes[16..].split_at(12 * vertices);
    let indices = &rest[12 * normals + 8 * texture..];
    let mesh = TriangleMesh {
        vertices: positions.chunks(12).map(|c| [float(c), float(&c[4..]), float(&c[8..])]).collect(),
        triangles: indices.chunks(12).map(|c| [count(c), count(&c[4..]), count(&c[8..])]).collect(),
    };
    match mesh.triangles.iter().flatten().find(|vertex| **vertex >= vertices) {
        Some(vertex) => Err(format!("vertex {vertex} of {vertices}")),
        None => finite(mesh),
    }
}

/// Vertices and faces of Wavefront OBJ; faces of more corners are fans.
fn obj(bytes: &[u8]) -> Result<TriangleMesh, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut mesh = TriangleMesh::default();
    for (line, words) in text.lines().enumerate() {
        let mut words = words.split_whitespace();
        let bad = |what: &str| format!("line {}: {what}", line + 1);
        match words.next() {
            Some("v") => {
                let mut vertex = [0.0; 3];
                for value in &mut vertex {
                    let word = words.next().and_then(|word| word.parse::<f32>().ok());
                    *value = f64::from(word.ok_or_else(|| bad("a vertex without three numbers"))?);
                }
                mesh.vertices.push(vertex);
            }
            Some("f") => {
                let corners: Option<Vec<usize>> =
                    words.map(|word| corner(word, mesh.vertices.len())).collect();
                let corners = corners.ok_or_else(|| bad("a face of vertices that are not there"))?;
                let [first, rest @ ..] = &corners[..] else { return Err(bad("a face without vertices")) };
                mesh.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    finite(mesh)
}

/// Number of the vertex that a word of a face names, of `n` so far: from 1, or from the end where it is negative.
fn corner(word: &str, n: usize) -> Option<usize> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let index = if number < 0 { i64::try_from(n).ok()? + number } else { number - 1 };
    usize::try_from(index).ok().filter(|index| *index < n)
}
