//! MSH files of every version and encoding from one small mesh, lies included: what tests and fuzzing of the reader
//! start from.

use std::fmt::Write as _;

/// Versions as the header names them.
pub const VERSIONS: [&str; 6] = ["1", "2", "2.1", "2.2", "4", "4.1"];

/// Byte order of a binary file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Endian {
    Little,
    Big,
}

/// Nodes, elements and groups with their tags, in the unit of the file. Nothing need be true.
#[derive(Debug, Clone)]
pub struct Msh {
    pub nodes: Vec<(u64, [f64; 3])>,
    /// Number, type, physical tag, nodes.
    pub elements: Vec<(u64, i64, i64, Vec<u64>)>,
    /// Dimension, tag and name of the groups.
    pub names: Vec<(i64, i64, String)>,
    /// Added to the counts at the head of nodes and elements.
    pub count_error: i64,
}

impl Msh {
    /// A unit cube of six tetrahedra around its diagonal, a triangle and a point.
    pub fn example() -> Self {
        let corner = |k: u64| [0, 1, 2].map(|d| ((k >> d) & 1) as f64);
        let tets = [[1, 2, 4, 8], [1, 4, 3, 8], [1, 3, 7, 8], [1, 7, 5, 8], [1, 5, 6, 8], [1, 6, 2, 8]];
        let mut elements = vec![(1, 15, 1, vec![1]), (2, 2, 2, vec![1, 2, 4])];
        elements.extend((3..).zip(tets).map(|(number, tet)| (number, 4, 3, tet.to_vec())));
        Self {
            nodes: (0..8).map(|k| (k + 1, corner(k))).collect(),
            elements,
            names: vec![(0, 1, "corner".into()), (2, 2, "base".into()), (3, 3, "body".into())],
            count_error: 0,
        }
    }
}

/// Numbers as text or bytes.
struct Out {
    bytes: Vec<u8>,
    endian: Option<Endian>,
    size_bytes: usize,
}

impl Out {
    fn text(&mut self, text: impl AsRef<str>) {
        self.bytes.extend(text.as_ref().as_bytes());
    }

    fn put(&mut self, text: String, little: &[u8]) {
        match self.endian {
            None => {
                self.bytes.extend(text.as_bytes());
                self.bytes.push(b' ');
            }
            Some(Endian::Little) => self.bytes.extend(little),
            Some(Endian::Big) => self.bytes.extend(little.iter().rev()),
        }
    }

    fn int(&mut self, value: i64) {
        self.put(value.to_string(), &(value as i32).to_le_bytes());
    }

    fn ints<const N: usize>(&mut self, values: [i64; N]) {
        values.into_iter().for_each(|value| self.int(value));
    }

    fn size(&mut self, value: u64) {
        let bytes = value.to_le_bytes();
        self.put(value.to_string(), &bytes[..self.size_bytes]);
    }

    fn float(&mut self, value: f64) {
        self.put(value.to_string(), &value.to_le_bytes());
    }

    fn line(&mut self) {
        if self.endian.is_none() {
            self.bytes.push(b'\n');
        }
    }
}

/// The file, or nothing for version 1 in bytes, which there is not.
pub fn write(msh: &Msh, version: &str, endian: Option<Endian>) -> Option<Vec<u8>> {
    if version == "1" && endian.is_some() {
        return None;
    }
    let size_bytes = if version.starts_with('4') { 8 } else { 4 };
    let mut out = Out { bytes: Vec::new(), endian, size_bytes };
    if version != "1" {
        out.text(format!("$MeshFormat\n{version} {} 8\n", u8::from(endian.is_some())));
        if endian.is_some() {
            out.int(1);
            out.text("\n");
        }
        out.text("$EndMeshFormat\n");
        let mut names = format!("$PhysicalNames\n{}\n", msh.names.len());
        for (dimension, tag, name) in &msh.names {
            let _ = if version == "2" {
                writeln!(names, "{tag} \"{name}\"")
            } else {
                writeln!(names, "{dimension} {tag} \"{name}\"")
            };
        }
        out.text(names + "$EndPhysicalNames\n");
    }
    if version.starts_with('4') {
        blocks(msh, version, &mut out);
    } else {
        legacy(msh, version, &mut out);
    }
    Some(out.bytes)
}

fn off(n: usize, by: i64) -> u64 {
    (n as u64).saturating_add_signed(by)
}

/// Versions 1 and 2.
fn legacy(msh: &Msh, version: &str, out: &mut Out) {
    let [nodes, end_nodes, elements, end_elements] = if version == "1" {
        ["$NOD", "$ENDNOD", "$ELM", "$ENDELM"]
    } else {
        ["$Nodes", "$EndNodes", "$Elements", "$EndElements"]
    };
    out.text(format!("{nodes}\n{}\n", off(msh.nodes.len(), msh.count_error)));
    for (tag, x) in &msh.nodes {
        out.int(*tag as i64);
        x.iter().for_each(|x| out.float(*x));
        out.line();
    }
    out.text(format!("\n{end_nodes}\n{elements}\n{}\n", off(msh.elements.len(), msh.count_error)));
    for (number, kind, physical, nodes) in &msh.elements {
        match (version, out.endian) {
            ("1", _) => out.ints([*number as i64, *kind, *physical, 7, nodes.len() as i64]),
            (_, None) => out.ints([*number as i64, *kind, 2, *physical, 7]),
            (_, Some(_)) => out.ints([*kind, 1, 2, *number as i64, *physical, 7]),
        }
        nodes.iter().for_each(|node| out.int(*node as i64));
        out.line();
    }
    out.text(format!("\n{end_elements}\n"));
}

/// Versions 4.0 and 4.1: one entity a group.
fn blocks(msh: &Msh, version: &str, out: &mut Out) {
    let is_41 = version == "4.1";
    let dimension = |kind: i64| match kind {
        15 => 0,
        1 | 8 | 26 => 1,
        2 | 3 | 9 => 2,
        _ => 3,
    };
    let entities: std::collections::BTreeSet<(i64, i64)> =
        msh.elements.iter().map(|(_, kind, physical, _)| (dimension(*kind), *physical)).collect();
    out.text("$Entities\n");
    for d in 0..4 {
        out.size(entities.iter().filter(|(dimension, _)| *dimension == d).count() as u64);
    }
    out.line();
    for &(d, tag) in &entities {
        out.int(tag);
        for _ in 0..if d == 0 && is_41 { 3 } else { 6 } {
            out.float(0.0);
        }
        out.size(1);
        out.int(tag);
        if d > 0 {
            out.size(0);
        }
        out.line();
    }
    out.text("\n$EndEntities\n$Nodes\n");
    let tag = |out: &mut Out, value: u64| if is_41 { out.size(value) } else { out.int(value as i64) };
    let head = |out: &mut Out, blocks: usize, items: usize| {
        out.size(blocks as u64);
        out.size(off(items, msh.count_error));
        if is_41 {
            out.size(1);
            out.size(items as u64);
        }
        out.line();
    };
    head(out, 1, msh.nodes.len());
    out.ints([3, 3, 0]);
    out.size(msh.nodes.len() as u64);
    out.line();
    if is_41 {
        msh.nodes.iter().for_each(|(number, _)| tag(out, *number));
        out.line();
    }
    for (number, x) in &msh.nodes {
        if !is_41 {
            tag(out, *number);
        }
        x.iter().for_each(|x| out.float(*x));
        out.line();
    }
    out.text("\n$EndNodes\n$Elements\n");
    head(out, msh.elements.len(), msh.elements.len());
    for (number, kind, physical, nodes) in &msh.elements {
        let entity = [dimension(*kind), *physical];
        out.ints(if is_41 { entity } else { [entity[1], entity[0]] });
        out.int(*kind);
        out.size(1);
        out.line();
        tag(out, *number);
        nodes.iter().for_each(|node| tag(out, *node));
        out.line();
    }
    out.text("\n$EndElements\n");
}
