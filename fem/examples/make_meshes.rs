//! Regenerates the meshes of the folder `meshes/`, byte for byte:
//! `cargo run --release -p hysteron-fem --example make_meshes -- meshes`

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};

use hysteron_fem::{Layers, Mesh, MshEncoding, Order, Result, TendonChannel, Tube, check_mesh, write_mesh};

const MM: f64 = 1e-3;

fn main() -> Result<()> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "meshes".to_owned()));

    let coarse = rounded(tpu80(16, 8, 4, 17).mesh()?);
    save(&folder.join("tpu80/tpu80.msh"), &coarse, MshEncoding::Ascii)?;
    save(&folder.join("tpu80/tpu80-quadratic.msh"), &coarse.to_quadratic(), MshEncoding::Ascii)?;
    save(&folder.join("tpu80/tpu80-fine.msh"), &rounded(tpu80(24, 12, 6, 36).mesh()?), MshEncoding::Ascii)?;

    let anchored = Tube { layers: Layers::Graded { height: 5.0 * MM, end: 0.7 * MM }, ..tpu80(12, 8, 6, 0) };
    let anchored = rounded(anchored.with_circle_areas().mesh()?).to_quadratic();
    save(&folder.join("tpu80/tpu80-anchored.msh"), &anchored, MshEncoding::Ascii)?;

    save(&folder.join("tentacle/tentacle.msh"), &rounded(tentacle(16, 90).mesh()?), MshEncoding::Ascii)?;
    let coarse = rounded(tentacle(12, 60).mesh()?);
    save(&folder.join("tentacle/tentacle-quadratic.msh"), &coarse.to_quadratic(), MshEncoding::Ascii)?;

    let ftdcr = rounded(ftdcr_v4(6, 18).mesh()?);
    save(&folder.join("ftdcr-v4/ftdcr-v4.msh"), &ftdcr.to_quadratic(), MshEncoding::Ascii)
}

/// Solid cylinder, its polygon as wide as to bend like the circle.
fn ftdcr_v4(outer_divisions: u32, layers: u32) -> Tube {
    let radius = wider(outer_divisions) * 5.5 * MM;
    Tube {
        profile: vec![[0.0, radius], [186.5 * MM, radius]],
        bore_radius: 0.0,
        channels: Vec::new(),
        outer_divisions,
        bore_divisions: 0,
        channel_divisions: 0,
        layers: Layers::Count(layers),
        order: Order::Linear,
    }
}

/// How much wider than a circle a polygon is with the same second moment of area:
/// n R⁴ sin(2π/n) (2 + cos(2π/n)) / 24 = π r⁴ / 4.
fn wider(divisions: u32) -> f64 {
    let turn = TAU / f64::from(divisions);
    (3.0 * turn / (turn.sin() * (2.0 + turn.cos()))).powf(0.25)
}

/// Tube of 80 mm with a bore and four tendon channels.
fn tpu80(outer_divisions: u32, bore_divisions: u32, channel_divisions: u32, layers: u32) -> Tube {
    let channel = |k: u32| TendonChannel {
        angle: f64::from(k) * FRAC_PI_2,
        center_radius: 4.5 * MM,
        radius: 0.75 * MM,
    };
    Tube {
        profile: vec![[0.0, 6.0 * MM], [80.0 * MM, 6.0 * MM]],
        bore_radius: 3.0 * MM,
        channels: (0..4).map(channel).collect(),
        outer_divisions,
        bore_divisions,
        channel_divisions,
        layers: Layers::Count(layers),
        order: Order::Linear,
    }
}

/// Solid tapered body of two links. Its polygons have the bending stiffness of the circles: they have the same
/// second moment of area.
fn tentacle(outer_divisions: u32, layers: u32) -> Tube {
    let wider = wider(outer_divisions);
    Tube {
        profile: [[0.0, 15.41], [305.0, 6.42], [360.0, 4.80]].map(|[z, r]| [z * MM, wider * r * MM]).to_vec(),
        bore_radius: 0.0,
        channels: Vec::new(),
        outer_divisions,
        bore_divisions: 0,
        channel_divisions: 0,
        layers: Layers::Count(layers),
        order: Order::Linear,
    }
}

/// Moves the nodes to whole nanometres: shorter files, and no trace of the machine's sine and cosine.
fn rounded(mut mesh: Mesh) -> Mesh {
    mesh.nodes.iter_mut().flatten().for_each(|v| *v = (*v * 1e9).round() / 1e9);
    mesh
}

#[expect(clippy::print_stdout, reason = "a program for the terminal")]
fn save(path: &Path, mesh: &Mesh, encoding: MshEncoding) -> Result<()> {
    let quality = check_mesh(mesh, &path.display().to_string())?;
    write_mesh(path, mesh, MM, encoding)?;
    println!(
        "{}: {} nodes, {} tetrahedra, radius ratio min {:.3} median {:.3}, smallest angle min {:.1} deg, {:.1} mm3",
        path.display(),
        quality.n_nodes,
        quality.n_cells,
        quality.radius_ratio.min,
        quality.radius_ratio.median,
        quality.smallest_angle.min.to_degrees(),
        quality.volume.sum * 1e9,
    );
    Ok(())
}
