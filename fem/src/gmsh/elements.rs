//! Gmsh's element types: number, dimension, nodes, name.

/// One element type of Gmsh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Kind {
    /// Gmsh's number.
    pub(super) number: i64,
    /// 0 point, 1 line, 2 surface, 3 volume.
    pub(super) dimension: u8,
    /// Nodes of one element.
    pub(super) n_nodes: usize,
    /// For messages.
    pub(super) name: &'static str,
}

const fn kind(number: i64, dimension: u8, n_nodes: usize, name: &'static str) -> Kind {
    Kind { number, dimension, n_nodes, name }
}

const KINDS: [Kind; 40] = [
    kind(1, 1, 2, "line"),
    kind(2, 2, 3, "triangle"),
    kind(3, 2, 4, "quadrangle"),
    kind(4, 3, 4, "tetrahedron"),
    kind(5, 3, 8, "hexahedron"),
    kind(6, 3, 6, "prism"),
    kind(7, 3, 5, "pyramid"),
    kind(8, 1, 3, "3-node line"),
    kind(9, 2, 6, "6-node triangle"),
    kind(10, 2, 9, "9-node quadrangle"),
    kind(11, 3, 10, "10-node tetrahedron"),
    kind(12, 3, 27, "27-node hexahedron"),
    kind(13, 3, 18, "18-node prism"),
    kind(14, 3, 14, "14-node pyramid"),
    kind(15, 0, 1, "point"),
    kind(16, 2, 8, "8-node quadrangle"),
    kind(17, 3, 20, "20-node hexahedron"),
    kind(18, 3, 15, "15-node prism"),
    kind(19, 3, 13, "13-node pyramid"),
    kind(20, 2, 9, "9-node triangle"),
    kind(21, 2, 10, "10-node triangle"),
    kind(22, 2, 12, "12-node triangle"),
    kind(23, 2, 15, "15-node triangle"),
    kind(24, 2, 15, "15-node triangle"),
    kind(25, 2, 21, "21-node triangle"),
    kind(26, 1, 4, "4-node line"),
    kind(27, 1, 5, "5-node line"),
    kind(28, 1, 6, "6-node line"),
    kind(29, 3, 20, "20-node tetrahedron"),
    kind(30, 3, 35, "35-node tetrahedron"),
    kind(31, 3, 56, "56-node tetrahedron"),
    kind(36, 2, 16, "16-node quadrangle"),
    kind(37, 2, 25, "25-node quadrangle"),
    kind(38, 2, 36, "36-node quadrangle"),
    kind(90, 3, 40, "40-node prism"),
    kind(91, 3, 75, "75-node prism"),
    kind(92, 3, 64, "64-node hexahedron"),
    kind(93, 3, 125, "125-node hexahedron"),
    kind(118, 3, 30, "30-node pyramid"),
    kind(119, 3, 55, "55-node pyramid"),
];

/// The element type with this number, if it is one of the common ones.
pub(super) fn find(number: i64) -> Option<Kind> {
    KINDS.into_iter().find(|k| k.number == number)
}
