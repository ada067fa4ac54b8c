//! Mesh and CAD files in other formats than Gmsh's: their kinds, and the commands that make a volume mesh of
//! them.

use std::path::Path;

use hysteron_base::BadInput;

/// Route from a file to tetrahedra.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Route {
    /// Gmsh meshes the solid.
    Solid,
    /// Gmsh meshes the solid that faces make which are sewn together: the format has faces alone.
    Faces,
    /// Gmsh meshes what the closed surface encloses.
    Surface,
    /// Gmsh reads the volume mesh, and writes its own format.
    Volume,
    /// Meshio does.
    Meshio,
    /// A closed surface that Gmsh does not read: meshio makes STL of it.
    MeshioSurface,
    /// Neither does; the program that wrote it must.
    Export,
}

/// Ending, name and route of every format that is known by name.
const FORMATS: [(&str, &str, Route); 24] = [
    ("step", "a STEP file", Route::Solid),
    ("stp", "a STEP file", Route::Solid),
    ("brep", "a BREP file", Route::Solid),
    ("iges", "an IGES file", Route::Faces),
    ("igs", "an IGES file", Route::Faces),
    ("stl", "an STL surface", Route::Surface),
    ("obj", "an OBJ surface", Route::Surface),
    ("off", "an OFF surface", Route::Surface),
    ("ply", "a PLY surface", Route::MeshioSurface),
    ("vtk", "a VTK file", Route::Volume),
    ("mesh", "a Medit mesh", Route::Volume),
    ("bdf", "a Nastran mesh", Route::Volume),
    ("nas", "a Nastran mesh", Route::Volume),
    ("unv", "an I-deas universal file", Route::Volume),
    ("vtu", "a VTU file", Route::Meshio),
    ("inp", "an Abaqus input file", Route::Meshio),
    ("su2", "an SU2 mesh", Route::Meshio),
    ("xdmf", "an XDMF file", Route::Meshio),
    ("e", "an Exodus file", Route::Meshio),
    ("exo", "an Exodus file", Route::Meshio),
    ("3mf", "a 3MF file", Route::Export),
    ("sldprt", "a SolidWorks part", Route::Export),
    ("f3d", "a Fusion design", Route::Export),
    ("geo", "a Gmsh geometry", Route::Solid),
];

/// First bytes of formats that may come under another ending.
const STARTS: [(&[u8], &str); 8] = [
    (b"ISO-10303-21", "step"),
    (b"solid ", "stl"),
    (b"# vtk DataFile", "vtk"),
    (b"<VTKFile", "vtu"),
    (b"<?xml", "vtu"),
    (b"ply\n", "ply"),
    (b"OFF", "off"),
    (b"DBRep_DrawableShape", "brep"),
];

/// The refusal of a file that is known not to be Gmsh's mesh; nothing for one that is, or whose kind is unknown.
pub(super) fn refusal(path: &Path, bytes: &[u8]) -> Option<BadInput> {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    // A comment of Nastran begins with the same sign, and a blank.
    if start.is_empty() || matches!(start, [b'$', name, ..] if name.is_ascii_alphabetic()) {
        return None;
    }
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_ascii_lowercase();
    let by_ending = FORMATS.iter().find(|(known, ..)| *known == ending);
    let by_start = STARTS.iter().find(|(mark, _)| start.starts_with(mark));
    let by_start = by_start.and_then(|(_, ending)| FORMATS.iter().find(|(known, ..)| known == ending));
    let &(ending, name, route) = by_ending.or(by_start)?;
    let hint = if by_ending.is_some() {
        commands(path, ending, route)
    } else {
        format!("give it the ending .{ending}, and its commands are shown here")
    };
    Some(BadInput::new("the mesh", "a Gmsh mesh (.msh)", name).hint(hint))
}

/// The commands that make a .msh file of this one, to be run from the folder it is in.
fn commands(path: &Path, ending: &str, route: Route) -> String {
    let file = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let enclosed = |surface: &str| {
        format!(
            "`printf 'Merge \"{surface}\"; Surface Loop(1) = Surface{{:}}; Volume(1) = {{1}};\\n' > '{stem}.geo'`, then \
             `gmsh '{stem}.geo' -3 -format msh41 -o '{stem}.msh'`"
        )
    };
    let make = match route {
        Route::Solid => format!("`gmsh '{file}' -3 -format msh41 -o '{stem}.msh'`"),
        Route::Faces => format!(
            "`gmsh '{file}' -setnumber Geometry.Tolerance 1e-5 -setnumber Geometry.OCCSewFaces 1 -setnumber \
             Geometry.OCCMakeSolids 1 -3 -format msh41 -o '{stem}.msh'` (better: export STEP, which has solids)"
        ),
        Route::Surface => enclosed(&file),
        Route::Volume => format!("`gmsh '{file}' -save -format msh41 -o '{stem}.msh'`"),
        Route::Meshio => format!(
            "`pip install meshio`, then `meshio convert '{file}' '{stem}.msh' --output-format gmsh22`"
        ),
        Route::MeshioSurface => format!(
            "`pip install meshio`, then `meshio convert '{file}' '{stem}.stl'`, then {}",
            enclosed(&format!("{stem}.stl"))
        ),
        Route::Export => {
            return format!("export the part as STEP or STL (not .{ending}), and name that file");
        }
    };
    format!("make tetrahedra of it: {make}; then name {stem}.msh in [mesh], and `hysteron check` the scene")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;

    fn hint(file: &str, bytes: &[u8]) -> String {
        let bad = refusal(Path::new(file), bytes).unwrap();
        assert_eq!(bad.expected, "a Gmsh mesh (.msh)");
        bad.hint
    }

    #[test]
    fn every_format_has_commands_with_the_names_of_the_file() {
        for (ending, _, route) in FORMATS {
            let hint = hint(&format!("a/my part.{}", ending.to_uppercase()), b"x");
            match route {
                Route::Export => assert!(hint.contains("export the part as STEP or STL"), "{hint}"),
                _ => assert!(hint.contains("'my part.msh'") && hint.contains("hysteron check"), "{hint}"),
            }
        }
    }

    #[test]
    fn content_decides_without_a_known_ending() {
        assert!(hint("part.msh", b"solid part\n facet").contains("ending .stl"));
        assert!(hint("part.msh", b"ISO-10303-21;\n").contains("ending .step"));
        assert_eq!(refusal(Path::new("part.stl"), b"\xef\xbb\xbf$MeshFormat\n"), None);
        assert_eq!(refusal(Path::new("part.msh"), b"hello"), None);
        assert!(hint("part.bdf", b"$ Created by Gmsh\nGRID").contains("'part.bdf' -save"));
    }
}
