//! Gmsh's element types: number, shape, nodes.
//!
//! The table is closed: all types of Gmsh 4.15 whose number of nodes follows from the type. Only tetrahedra of four
//! and ten nodes make a body; points, lines and surfaces of any order give the nodes of a group.

/// The form of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ElementShape {
    Point,
    Line,
    Triangle,
    Quadrangle,
    Tetrahedron,
    Hexahedron,
    Prism,
    Pyramid,
}

impl ElementShape {
    /// 0 point, 1 line, 2 surface, 3 volume.
    pub(super) const fn dimension(self) -> u8 {
        match self {
            Self::Point => 0,
            Self::Line => 1,
            Self::Triangle | Self::Quadrangle => 2,
            _ => 3,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Line => "line",
            Self::Triangle => "triangle",
            Self::Quadrangle => "quadrangle",
            Self::Tetrahedron => "tetrahedron",
            Self::Hexahedron => "hexahedron",
            Self::Prism => "prism",
            Self::Pyramid => "pyramid",
        }
    }

    const fn n_corners(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Line => 2,
            Self::Triangle => 3,
            Self::Quadrangle | Self::Tetrahedron => 4,
            Self::Pyramid => 5,
            Self::Prism => 6,
            Self::Hexahedron => 8,
        }
    }
}

/// One element type of Gmsh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct GmshType {
    /// Gmsh's number.
    pub(super) number: i64,
    /// Form.
    pub(super) shape: ElementShape,
    /// Nodes of one element.
    pub(super) n_nodes: usize,
}

impl GmshType {
    /// For messages: `tetrahedron`, `20-node hexahedron`.
    pub(super) fn name(self) -> String {
        if self.n_nodes == self.shape.n_corners() {
            return self.shape.name().to_owned();
        }
        format!("{}-node {}", self.n_nodes, self.shape.name())
    }
}

/// Number and nodes of every type, by shape.
const TYPES: [(ElementShape, &[(i64, usize)]); 8] = [
    (ElementShape::Point, &[(15, 1)]),
    (
        ElementShape::Line,
        &[(1, 2), (8, 3), (26, 4), (27, 5), (28, 6), (62, 7), (63, 8), (64, 9), (65, 10), (66, 11), (84, 1)],
    ),
    (
        ElementShape::Triangle,
        &[
            (2, 3),
            (9, 6),
            (20, 9),
            (21, 10),
            (22, 12),
            (23, 15),
            (24, 15),
            (25, 21),
            (42, 28),
            (43, 36),
            (44, 45),
            (45, 55),
            (46, 66),
            (52, 18),
            (53, 21),
            (54, 24),
            (55, 27),
            (56, 30),
            (85, 1),
        ],
    ),
    (
        ElementShape::Quadrangle,
        &[
            (3, 4),
            (10, 9),
            (16, 8),
            (36, 16),
            (37, 25),
            (38, 36),
            (39, 12),
            (40, 16),
            (41, 20),
            (47, 49),
            (48, 64),
            (49, 81),
            (50, 100),
            (51, 121),
            (57, 24),
            (58, 28),
            (59, 32),
            (60, 36),
            (61, 40),
            (86, 1),
        ],
    ),
    (
        ElementShape::Tetrahedron,
        &[
            (4, 4),
            (11, 10),
            (29, 20),
            (30, 35),
            (31, 56),
            (32, 22),
            (33, 28),
            (71, 84),
            (72, 120),
            (73, 165),
            (74, 220),
            (75, 286),
            (79, 34),
            (80, 40),
            (81, 46),
            (82, 52),
            (83, 58),
            (87, 1),
            (137, 16),
        ],
    ),
    (
        ElementShape::Hexahedron,
        &[
            (5, 8),
            (12, 27),
            (17, 20),
            (88, 1),
            (92, 64),
            (93, 125),
            (94, 216),
            (95, 343),
            (96, 512),
            (97, 729),
            (98, 1000),
            (99, 32),
            (100, 44),
            (101, 56),
            (102, 68),
            (103, 80),
            (104, 92),
            (105, 104),
        ],
    ),
    (
        ElementShape::Prism,
        &[
            (6, 6),
            (13, 18),
            (18, 15),
            (89, 1),
            (90, 40),
            (91, 75),
            (106, 126),
            (107, 196),
            (108, 288),
            (109, 405),
            (110, 550),
            (111, 24),
            (112, 33),
            (113, 42),
            (114, 51),
            (115, 60),
            (116, 69),
            (117, 78),
        ],
    ),
    (
        ElementShape::Pyramid,
        &[
            (7, 5),
            (14, 14),
            (19, 13),
            (118, 30),
            (119, 55),
            (120, 91),
            (121, 140),
            (122, 204),
            (123, 285),
            (124, 385),
            (125, 21),
            (126, 29),
            (127, 37),
            (128, 45),
            (129, 53),
            (130, 61),
            (131, 69),
            (132, 1),
        ],
    ),
];

const N_NUMBERS: usize = 141;

/// Types by number.
static KINDS: [Option<GmshType>; N_NUMBERS] = by_number();

const fn by_number() -> [Option<GmshType>; N_NUMBERS] {
    let mut kinds = [None; N_NUMBERS];
    let mut s = 0;
    while s < TYPES.len() {
        let (shape, types) = TYPES[s];
        let mut t = 0;
        while t < types.len() {
            let (number, n_nodes) = types[t];
            kinds[number as usize] = Some(GmshType { number, shape, n_nodes });
            t += 1;
        }
        s += 1;
    }
    kinds
}

/// The element type with this number, if Gmsh has one with a fixed number of nodes.
pub(super) fn find(number: i64) -> Option<GmshType> {
    usize::try_from(number).ok().and_then(|n| KINDS.get(n).copied().flatten())
}

/// Name of an element type that cannot be used, for messages.
pub(super) fn describe(number: i64) -> String {
    let name = match number {
        34 | 68 | 69 => "polygon",
        35 => "polyhedron",
        67 | 70 => "line cut at a border",
        133..=136 => "sub-element of an enriched element",
        138..=140 => "bubble-enriched element",
        _ => return format!("type {number}"),
    };
    format!("type {number}, a {name}")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;

    #[test]
    fn numbers_are_used_once_and_orders_have_their_nodes() {
        let listed: usize = TYPES.iter().map(|(_, types)| types.len()).sum();
        assert_eq!(KINDS.iter().flatten().count(), listed);
        // Complete Lagrange elements of order p by number: (p + 1)(p + 2)(p + 3) / 6 nodes, and so on.
        for (number, order) in
            [(4, 1), (11, 2), (29, 3), (30, 4), (31, 5), (71, 6), (72, 7), (73, 8), (74, 9)]
        {
            assert_eq!(find(number).unwrap().n_nodes, (order + 1) * (order + 2) * (order + 3) / 6);
        }
        for (number, order) in
            [(5, 1), (12, 2), (92, 3), (93, 4), (94, 5), (95, 6), (96, 7), (97, 8), (98, 9)]
        {
            assert_eq!(find(number).unwrap().n_nodes, (order + 1_usize).pow(3));
        }
        for (number, order) in
            [(6, 1), (13, 2), (90, 3), (91, 4), (106, 5), (107, 6), (108, 7), (109, 8), (110, 9)]
        {
            assert_eq!(find(number).unwrap().n_nodes, (order + 1_usize).pow(2) * (order + 2) / 2);
        }
        assert_eq!((find(34), find(-1), find(i64::MAX)), (None, None, None));
        assert_eq!(find(11).unwrap().name(), "10-node tetrahedron");
    }
}
