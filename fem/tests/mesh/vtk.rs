use hysteron_fem::{ArrayValues, Cells, Error, Polylines, Pvd, VtkArray, write_polylines, write_vtu};
use vtkio::model::{Attribute, CellType, DataSet, IOBuffer, Piece, Vtk};

use super::{bad_input, read_sample};

#[test]
fn deformed_mesh_reads_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("body.vtu");
    for (name, kind) in
        [("cylinder.msh", CellType::Tetra), ("cylinder-quadratic.msh", CellType::QuadraticTetra)]
    {
        let mesh = read_sample(name);
        let moved: Vec<[f64; 3]> = mesh.nodes.iter().map(|x| [x[0] + 0.1, x[1], x[2]]).collect();
        let energy: Vec<f64> = (0..mesh.cells.len()).map(|e| e as f64).collect();
        write_vtu(
            &path,
            &moved,
            &mesh.cells,
            &[VtkArray { name: "rest_m", values: ArrayValues::Vectors(&mesh.nodes) }],
            &[VtkArray { name: "energy_j", values: ArrayValues::Scalars(&energy) }],
        )
        .expect("written");

        let DataSet::UnstructuredGrid { pieces, .. } = Vtk::import(&path).expect("read").data else {
            panic!("expected an unstructured grid")
        };
        let [Piece::Inline(piece)] = &pieces[..] else { panic!("expected one piece") };
        assert_eq!(piece.points, IOBuffer::F64(moved.concat()));
        assert_eq!(piece.cells.types, vec![kind; mesh.cells.len()]);
        let (connectivity, offsets) = piece.cells.cell_verts.clone().into_xml();
        let nodes: Vec<u64> =
            (0..mesh.cells.len()).flat_map(|e| mesh.cells.nodes(e)).map(|n| u64::from(*n)).collect();
        assert_eq!(connectivity, nodes);
        assert_eq!(offsets.last(), Some(&(nodes.len() as u64)));
        let [Attribute::DataArray(rest)] = &piece.data.point[..] else { panic!("expected one array") };
        assert_eq!((rest.name.as_str(), &rest.data), ("rest_m", &IOBuffer::F64(mesh.nodes.concat())));
        let [Attribute::DataArray(array)] = &piece.data.cell[..] else { panic!("expected one array") };
        assert_eq!((array.name.as_str(), &array.data), ("energy_j", &IOBuffer::F64(energy)));
    }
}

#[test]
fn tendons_read_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tendons.vtp");
    let lines = [vec![[0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 2.0]], vec![[1.0; 3], [2.0; 3]]];
    let tension = [3.0, 4.0];
    let line_data = [VtkArray { name: "tension_n", values: ArrayValues::Scalars(&tension) }];
    write_polylines(&path, Polylines { lines: &lines, line_data: &line_data }).expect("written");
    let DataSet::PolyData { pieces, .. } = Vtk::import(&path).expect("read").data else {
        panic!("expected poly data")
    };
    let [Piece::Inline(piece)] = &pieces[..] else { panic!("expected one piece") };
    assert_eq!(piece.points, IOBuffer::F64(lines.concat().concat()));
    let (connectivity, offsets) = piece.lines.clone().expect("lines").into_xml();
    assert_eq!((connectivity, offsets), (vec![0, 1, 2, 3, 4], vec![3, 5]));
    let [Attribute::DataArray(array)] = &piece.data.cell[..] else { panic!("expected one array") };
    assert_eq!((array.name.as_str(), &array.data), ("tension_n", &IOBuffer::F64(tension.to_vec())));
}

#[test]
fn series_is_whole_at_any_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.pvd");
    let listed = || -> usize {
        let text = std::fs::read_to_string(&path).expect("there");
        assert!(text.ends_with("</VTKFile>\n"));
        text.matches("<DataSet").count()
    };
    let mut series = Pvd::new(&path).expect("written");
    assert_eq!(listed(), 0);
    for k in 0..500_usize {
        series.add(0.02 * k as f64, 0, &folder.path().join(format!("frames/{k}.vtu"))).expect("added");
        assert!(listed() + listed() / 20 + 1 >= k, "too far behind at {k}");
    }
    series.finish().expect("written");
    assert_eq!(listed(), 500);
    let text = std::fs::read_to_string(&path).expect("there");
    assert!(
        text.contains("<DataSet timestep=\"0.02\" group=\"\" part=\"0\" file=\"frames/1.vtu\"/>"),
        "{text}"
    );
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
}

#[test]
fn bad_pictures_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bad.vtu");
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let cells = Cells::Tet4(vec![[0, 1, 2, 3]]);
    let short = [VtkArray { name: "u", values: ArrayValues::Scalars(&[1.0]) }];
    assert_eq!(bad_input(write_vtu(&path, &points, &cells, &short, &[])).found, "1");
    write_vtu(&path, &points, &cells, &[], &short).expect("one cell, one value");
    let named = [VtkArray { name: "a<b", values: ArrayValues::Scalars(&[1.0]) }];
    assert!(bad_input(write_vtu(&path, &points, &cells, &[], &named)).expected.contains("names"));
    let far = Cells::Tet4(vec![[0, 1, 2, 4]]);
    assert!(bad_input(write_vtu(&path, &points, &far, &[], &[])).place.contains("tetrahedron 0"));
    let mut lost = points;
    lost[2][1] = f64::NAN;
    let refusal = write_vtu(&path, &lost, &cells, &[], &[]);
    assert!(matches!(refusal, Err(Error::NotFinite { quantity: "position", node: 2 })), "{refusal:?}");
    let lines = [vec![[0.0; 3]]];
    let refusal = bad_input(write_polylines(&path, Polylines { lines: &lines, line_data: &[] }));
    assert!(refusal.place.contains("line 0"));
    let mut series = Pvd::new(&folder.path().join("s.pvd")).expect("written");
    assert!(bad_input(series.add(f64::NAN, 0, &path)).expected.contains("finite time"));
    assert!(matches!(Pvd::new(folder.path()), Err(Error::File(_))));
}
