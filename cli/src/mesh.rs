//! `hysteron mesh`: a round body with bore, channels and taper, straight from its measures.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use hysteron_base::{BadInput, LengthUnit, file};
use hysteron_fem::{
    Channel, Distribution, Encoding, Layers, Mesh, MeshQuality, Order, Tube, check_mesh, write_mesh,
    write_vtu,
};

use serde::Serialize;

use crate::outputs::Outputs;
use crate::terminal::say;
use crate::{number, terminal};

const HELP: &str = "\
The axis is z, the base lies at z = 0. The mesh has the groups base, tip and body, for the scene to name. Circles \
become polygons: an edge length sets their sides, or give the sides yourself.

Prints the quality of the elements. A mesh that could not be computed with is refused, and nothing is written.

Examples, from the root of the repository:
  hysteron mesh --length-mm 80 --outer-diameter-mm 12 --bore-diameter-mm 6 \\
      --channels 4 --channel-diameter-mm 1.5 --channel-radius-mm 4.5 \\
      --layers 17 --out out/tube.msh
  hysteron mesh --profile 0:30.8,305:12.8,360:9.6 --edge-mm 6 --quadratic \\
      --out out/tentacle.msh

Exit codes: 0 done, 1 failed, 2 bad input (nothing is written).";

/// Mesh a tube or a tapered body with tendon channels
///
/// Needs its measures; writes a Gmsh file (MSH 4.1, millimetres) of tetrahedra.
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Length of the body
    #[arg(
        long,
        allow_negative_numbers = true,
        value_parser = number::position_mm,
        value_name = "MM",
        required_unless_present = "profile",
        conflicts_with = "profile"
    )]
    length_mm: Option<f64>,
    /// Outer diameter at the base
    #[arg(
        long,
        allow_negative_numbers = true,
        value_parser = number::position_mm,
        value_name = "MM",
        required_unless_present = "profile",
        conflicts_with = "profile"
    )]
    outer_diameter_mm: Option<f64>,
    /// Outer diameter at the tip [default: as at the base]
    #[arg(long, allow_negative_numbers = true, value_parser = number::position_mm, value_name = "MM", conflicts_with = "profile")]
    tip_diameter_mm: Option<f64>,
    /// Several links: height and outer diameter of every corner in mm, from the base up, as Z:D,Z:D,...
    #[arg(long, value_name = "Z:D,...", value_delimiter = ',', value_parser = corner)]
    profile: Vec<[f64; 2]>,
    /// Diameter of the central bore at the base; 0 for a solid body
    #[arg(long, allow_negative_numbers = true, value_parser = number::position_mm, value_name = "MM", default_value_t = 0.0)]
    bore_diameter_mm: f64,
    /// Number of tendon channels, evenly spaced, the first on the x axis
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = number::up_to::<64>)]
    channels: u32,
    /// Diameter of every channel at the base
    #[arg(long, allow_negative_numbers = true, value_parser = number::position_mm, value_name = "MM")]
    channel_diameter_mm: Option<f64>,
    /// Distance of the channels from the axis at the base
    #[arg(long, allow_negative_numbers = true, value_parser = number::position_mm, value_name = "MM")]
    channel_radius_mm: Option<f64>,
    /// Length of an edge, roughly: sets layers and sides that are not given
    #[arg(long, allow_negative_numbers = true, value_parser = number::position_mm, value_name = "MM", required_unless_present = "layers")]
    edge_mm: Option<f64>,
    /// Number of layers along the body
    #[arg(long, value_name = "N", value_parser = number::up_to::<20_000>)]
    layers: Option<u32>,
    /// Sides of the outer polygon [default: by edge length, else 16]
    #[arg(long, value_name = "N", value_parser = number::up_to::<512>)]
    outer_sides: Option<u32>,
    /// Sides of the bore [default: by edge length, else 8]
    #[arg(long, value_name = "N", value_parser = number::up_to::<512>)]
    bore_sides: Option<u32>,
    /// Sides of every channel [default: by edge length, else 4]
    #[arg(long, value_name = "N", value_parser = number::up_to::<512>)]
    channel_sides: Option<u32>,
    /// Ten-node tetrahedra
    #[arg(long)]
    quadratic: bool,
    /// Write the numbers as bytes instead of text
    #[arg(long)]
    binary: bool,
    /// Mesh file to write (.msh)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Write the mesh for ParaView too (.vtu)
    #[arg(long, value_name = "FILE")]
    vtu: Option<PathBuf>,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    check_ending(&arguments.out, "--out", "msh")?;
    if let Some(vtu) = &arguments.vtu {
        check_ending(vtu, "--vtu", "vtu")?;
    }
    let mut mesh = tube(arguments)?.mesh()?;
    // Whole nanometres: shorter files, and the same on machines whose sines differ in the last digit.
    mesh.nodes.iter_mut().flatten().for_each(|x| *x = (*x * 1e9).round() / 1e9);
    let quality = check_mesh(&mesh, "the mesh of these measures")?;
    let encoding = if arguments.binary { Encoding::Binary } else { Encoding::Ascii };
    write_new("--out", &arguments.out, |path| {
        write_mesh(path, &mesh, LengthUnit::Millimetre.to_m(), encoding)
    })?;
    if let Some(vtu) = &arguments.vtu {
        write_new("--vtu", vtu, |path| write_vtu(path, &mesh.nodes, &mesh.cells, &[], &[]))?;
    }
    say(format_args!("{}", arguments.out.display()));
    print_quality(&mesh, &quality);
    terminal::summarise(&Meshed { out: &arguments.out, mesh: Summary::new(&mesh, &quality) })
}

/// What the verb came to.
#[derive(Serialize)]
struct Meshed<'a> {
    out: &'a std::path::Path,
    #[serde(flatten)]
    mesh: Summary<'a>,
}

/// A mesh in numbers.
#[derive(Serialize)]
pub struct Summary<'a> {
    nodes: usize,
    tetrahedra: usize,
    volume_m3: f64,
    /// Nodes of each group.
    groups: BTreeMap<&'a str, usize>,
    radius_ratio: Spread,
    smallest_angle_rad: Spread,
}

/// How a figure is spread over the tetrahedra.
#[derive(Serialize)]
struct Spread {
    min: f64,
    min_tetrahedron: usize,
    percentile_1: f64,
    percentile_5: f64,
    median: f64,
    mean: f64,
    max: f64,
}

impl<'a> Summary<'a> {
    /// Of a mesh that was checked.
    pub fn new(mesh: &'a Mesh, quality: &MeshQuality) -> Self {
        let spread = |of: &Distribution| Spread {
            min: of.min,
            min_tetrahedron: of.min_cell,
            percentile_1: of.percentile_1,
            percentile_5: of.percentile_5,
            median: of.median,
            mean: of.mean,
            max: of.max,
        };
        Self {
            nodes: quality.n_nodes,
            tetrahedra: quality.n_cells,
            volume_m3: quality.volume.sum,
            groups: mesh.groups.iter().map(|(name, nodes)| (name.as_str(), nodes.len())).collect(),
            radius_ratio: spread(&quality.radius_ratio),
            smallest_angle_rad: spread(&quality.smallest_angle),
        }
    }
}

/// Writes a file that does not say who made it: one that is there must be the same already.
fn write_new(
    option: &'static str,
    path: &Path,
    write: impl Fn(&Path) -> hysteron_fem::Result<()>,
) -> anyhow::Result<()> {
    if path.exists() {
        let folder = tempfile::tempdir().context("making a temporary folder")?;
        let new = folder.path().join("new");
        write(&new)?;
        let found = std::fs::metadata(path)?;
        if found.is_file()
            && found.len() == std::fs::metadata(&new)?.len()
            && file::read_bytes(path)? == file::read_bytes(&new)?
        {
            return Ok(());
        }
        let found = format!("{}, which these measures do not give", path.display());
        return Err(BadInput::new(option, "a new file", found)
            .hint(format!("remove it, or choose another {option}"))
            .into());
    }
    let _claim = Outputs::default().file(option, path).check()?;
    Ok(write(path)?)
}

/// The measures as the mesher takes them.
fn tube(arguments: &Arguments) -> Result<Tube, BadInput> {
    const MM: f64 = 1e-3;
    let profile: Vec<[f64; 2]> = match (arguments.length_mm, arguments.outer_diameter_mm) {
        (Some(length), Some(base)) => {
            vec![[0.0, base], [length, arguments.tip_diameter_mm.unwrap_or(base)]]
        }
        _ => arguments.profile.clone(),
    };
    let profile: Vec<[f64; 2]> =
        profile.into_iter().map(|[z, diameter]| [z * MM, 0.5 * diameter * MM]).collect();
    let channels = channels(arguments)?;
    let edge = arguments.edge_mm.map(|edge| edge * MM);
    if let Some(edge) = edge.filter(|edge| !(edge.is_finite() && *edge > 0.0)) {
        return Err(BadInput::new("--edge-mm", "a length above 0 mm", format!("{} mm", edge / MM)));
    }
    // The sides of a circle whose length is nearest to the edge.
    let sides = |given: Option<u32>, radius: f64, least: f64, default: u32| match (given, edge) {
        (Some(sides), _) => sides,
        (None, Some(edge)) => (std::f64::consts::TAU * radius / edge).round().max(least) as u32,
        (None, None) => default,
    };
    let radius = profile.first().map_or(0.0, |corner| corner[1]);
    let bore_radius = 0.5 * arguments.bore_diameter_mm * MM;
    let channel_radius = channels.first().map_or(0.0, |channel| channel.radius);
    let layers = match (arguments.layers, edge) {
        (Some(layers), _) => Layers::Count(layers),
        (None, Some(edge)) => Layers::Height(edge),
        (None, None) => return Err(BadInput::new("tube", "--layers or --edge-mm", "neither")),
    };
    Ok(Tube {
        outer_divisions: sides(arguments.outer_sides, radius, 8.0, 16),
        bore_divisions: sides(arguments.bore_sides, bore_radius, 6.0, 8),
        channel_divisions: sides(arguments.channel_sides, channel_radius, 4.0, 4),
        profile,
        bore_radius,
        channels,
        layers,
        order: if arguments.quadratic { Order::Quadratic } else { Order::Linear },
    })
}

fn channels(arguments: &Arguments) -> Result<Vec<Channel>, BadInput> {
    let n = arguments.channels;
    match (n, arguments.channel_diameter_mm, arguments.channel_radius_mm) {
        (0, None, None) => Ok(Vec::new()),
        (1.., Some(diameter), Some(distance)) => {
            let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(n);
            let channel =
                |k| Channel { angle: angle(k), center_radius: 1e-3 * distance, radius: 0.5e-3 * diameter };
            Ok((0..n).map(channel).collect())
        }
        (0, ..) => Err(BadInput::new("--channels", "their number, with a diameter or radius given", "0")),
        _ => Err(BadInput::new(
            "--channels",
            "--channel-diameter-mm and --channel-radius-mm with it",
            "not both",
        )),
    }
}

/// `Z:D` as two numbers.
fn corner(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(':');
    let numbers =
        numbers.and_then(|(z, d)| Some([number::position_mm(z).ok()?, number::position_mm(d).ok()?]));
    numbers.ok_or_else(|| "expected Z:D in mm, for example 305:12.8".to_owned())
}

fn check_ending(path: &std::path::Path, option: &str, ending: &str) -> Result<(), BadInput> {
    if path.extension().is_some_and(|extension| extension == ending) {
        return Ok(());
    }
    Err(BadInput::new(option, format!("a name ending in .{ending}"), path.display().to_string()))
}

/// Prints how good the elements are.
pub fn print_quality(mesh: &Mesh, quality: &MeshQuality) {
    let groups: Vec<String> =
        mesh.groups.iter().map(|(name, nodes)| format!("{name} ({})", nodes.len())).collect();
    say(format_args!(
        "{} nodes, {} tetrahedra, {:.1} mm3",
        quality.n_nodes,
        quality.n_cells,
        1e9 * quality.volume.sum
    ));
    say(format_args!("groups (nodes): {}", groups.join(", ")));
    say("");
    say("                        worst (tetrahedron)        1 %        5 %     median       mean       best");
    let row = |name: &str, unit: f64, spread: &Distribution| {
        let figure = |value: f64| format!("{:>11.4}", value * unit);
        say(format_args!(
            "{name:<22}{}{:>14}{}{}{}{}{}",
            figure(spread.min),
            format!("({})", spread.min_cell),
            figure(spread.percentile_1),
            figure(spread.percentile_5),
            figure(spread.median),
            figure(spread.mean),
            figure(spread.max),
        ));
    };
    row("radius ratio [-]", 1.0, &quality.radius_ratio);
    row("smallest angle [deg]", 1f64.to_degrees(), &quality.smallest_angle);
    row("volume [mm3]", 1e9, &quality.volume);
    say("");
    histogram("radius ratio [-]", 1.0, &quality.radius_ratio);
    say("");
    histogram("smallest angle [deg]", 1f64.to_degrees(), &quality.smallest_angle);
}

fn histogram(name: &str, unit: f64, spread: &Distribution) {
    const WIDTH: usize = 50;
    say(name);
    let most = spread.counts.iter().copied().max().unwrap_or(0).max(1);
    for (limits, count) in spread.limits.windows(2).zip(&spread.counts) {
        let [low, high] = [limits[0] * unit, limits[1] * unit];
        let bar = "#".repeat((count * WIDTH).div_ceil(most));
        say(format!("{low:>6.1} to {high:<5.1} {count:>9}  {bar}").trim_end());
    }
}
