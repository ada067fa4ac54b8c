//! `hysteron mesh`: a round body with bore, channels and taper, straight from its measures.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use hysteron_base::{BadInput, LengthUnit, file};
use hysteron_fem::{
    Distribution, Layers, Mesh, MeshQuality, MshEncoding, Order, TendonChannel, Tube, check_mesh, read_mesh,
    write_mesh, write_vtu,
};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Context;
use crate::shared::outputs::Outputs;

/// Mesh a tube or a tapered body with tendon channels
///
/// Needs its measures; writes a Gmsh file (MSH 4.1, millimetres) of tetrahedra.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Length of the body
    #[cfg_attr(feature = "clap", arg(
        long,
        allow_negative_numbers = true,
        value_parser = crate::shared::number::position_mm,
        value_name = "MM",
        required_unless_present = "profile",
        conflicts_with = "profile"
    ))]
    pub length_mm: Option<f64>,
    /// Outer diameter at the base
    #[cfg_attr(feature = "clap", arg(
        long,
        allow_negative_numbers = true,
        value_parser = crate::shared::number::position_mm,
        value_name = "MM",
        required_unless_present = "profile",
        conflicts_with = "profile"
    ))]
    pub outer_diameter_mm: Option<f64>,
    /// Outer diameter at the tip [default: as at the base]
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_parser = crate::shared::number::position_mm, value_name = "MM", conflicts_with = "profile"))]
    pub tip_diameter_mm: Option<f64>,
    /// Several links: height and outer diameter of every corner in mm, from the base up, as Z:D,Z:D,...
    #[cfg_attr(feature = "clap", arg(long, value_name = "Z:D,...", value_delimiter = ',', value_parser = corner))]
    pub profile: Vec<[f64; 2]>,
    /// Diameter of the central bore at the base; 0 for a solid body
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_parser = crate::shared::number::position_mm, value_name = "MM", default_value_t = 0.0))]
    pub bore_diameter_mm: f64,
    /// Number of tendon channels, evenly spaced, the first on the x axis
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 0, value_parser = crate::shared::number::up_to::<64>))]
    pub channels: u32,
    /// Diameter of every channel at the base
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_parser = crate::shared::number::position_mm, value_name = "MM"))]
    pub channel_diameter_mm: Option<f64>,
    /// Distance of the channels from the axis at the base
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_parser = crate::shared::number::position_mm, value_name = "MM"))]
    pub channel_radius_mm: Option<f64>,
    /// Length of an edge, roughly: sets layers and sides that are not given
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_parser = crate::shared::number::position_mm, value_name = "MM", required_unless_present = "layers"))]
    pub edge_mm: Option<f64>,
    /// Number of layers along the body
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::up_to::<20_000>))]
    pub layers: Option<u32>,
    /// Sides of the outer polygon [default: by edge length, else 16]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::up_to::<512>))]
    pub outer_sides: Option<u32>,
    /// Sides of the bore [default: by edge length, else 8]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::up_to::<512>))]
    pub bore_sides: Option<u32>,
    /// Sides of every channel [default: by edge length, else 4]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::up_to::<512>))]
    pub channel_sides: Option<u32>,
    /// Ten-node tetrahedra
    #[cfg_attr(feature = "clap", arg(long))]
    pub quadratic: bool,
    /// Write the numbers as bytes instead of text
    #[cfg_attr(feature = "clap", arg(long))]
    pub binary: bool,
    /// Mesh file to write (.msh)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// Write the mesh for ParaView too (.vtu)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub vtu: Option<PathBuf>,
}

/// Carries out the verb.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    check_ending(&options.out, "--out", "msh")?;
    if let Some(vtu) = &options.vtu {
        check_ending(vtu, "--vtu", "vtu")?;
    }
    let mut mesh = tube(options)?.mesh()?;
    // Whole nanometres: shorter files, and the same on machines whose sines differ in the last digit.
    mesh.nodes.iter_mut().flatten().for_each(|x| *x = (*x * 1e9).round() / 1e9);
    let quality = check_mesh(&mesh, "the mesh of these measures")?;
    let encoding = if options.binary { MshEncoding::Binary } else { MshEncoding::Ascii };
    write_new("--out", &options.out, context, |path| {
        write_mesh(path, &mesh, LengthUnit::Millimetre.to_m(), encoding)
    })?;
    if let Some(vtu) = &options.vtu {
        write_new("--vtu", vtu, context, |path| write_vtu(path, &mesh.nodes, &mesh.cells, &[], &[]))?;
    }
    context.wrote(&options.out);
    print_quality(&mesh, &quality, context);
    Ok(Outcome { out: options.out.clone(), mesh: MeshSummary::new(&mesh, &quality) })
}

/// The outcome of `mesh`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The file.
    pub out: PathBuf,
    /// The mesh in it.
    #[serde(flatten)]
    pub mesh: MeshSummary,
}

impl crate::shared::outcome::Outcome for Outcome {}

/// Size and quality of a mesh.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MeshSummary {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of tetrahedra.
    pub tetrahedra: usize,
    /// Volume of the body [m³].
    pub volume_m3: f64,
    /// Number of nodes in each group, by its name.
    pub groups: BTreeMap<String, usize>,
    /// Three times the radius of the inscribed over that of the circumscribed sphere [-]: 1 for a regular tetrahedron.
    pub radius_ratio: Spread,
    /// Smallest angle between two faces [rad].
    pub smallest_angle_rad: Spread,
}

/// The distribution of a measure of quality over the tetrahedra.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct Spread {
    /// Smallest value.
    pub min: f64,
    /// The tetrahedron that has it, by its number in the file.
    pub min_tetrahedron: usize,
    /// A hundredth of the tetrahedra are below this.
    pub percentile_1: f64,
    /// A twentieth of the tetrahedra are below this.
    pub percentile_5: f64,
    /// Half of the tetrahedra are below this.
    pub median: f64,
    /// Mean.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
}

impl MeshSummary {
    /// Of a mesh that was checked.
    pub fn new(mesh: &Mesh, quality: &MeshQuality) -> Self {
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
            groups: mesh.groups.iter().map(|(name, nodes)| (name.clone(), nodes.len())).collect(),
            radius_ratio: spread(&quality.radius_ratio),
            smallest_angle_rad: spread(&quality.smallest_angle),
        }
    }
}

/// Writes a file that does not say who made it: one that is there must be the same already, or with `--overwrite` a mesh as this
/// program writes it, byte for byte, which no other program does.
fn write_new(
    option: &'static str,
    path: &Path,
    context: &Context,
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
        if context.overwrite && is_own_mesh(path, &new) {
            return Ok(file::write_bytes(path, file::read_bytes(&new)?)?);
        }
        let found = format!("{}, which these measures do not give", path.display());
        return Err(BadInput::new(option, "a new file", found)
            .hint(format!(
                "remove it, choose another {option}, or add --overwrite where it is a mesh by hysteron mesh"
            ))
            .into());
    }
    let _claim = Outputs::default().file(option, path).check(context)?;
    Ok(write(path)?)
}

/// Whether a file is a mesh that this program wrote: what it reads there it would write with the same bytes. `scratch` is written
/// over, and holds what it held before.
fn is_own_mesh(path: &Path, scratch: &Path) -> bool {
    let rewritten = || -> anyhow::Result<bool> {
        let (found, kept) = (file::read_bytes(path)?, file::read_bytes(scratch)?);
        let mesh = read_mesh(path, 1.0)?;
        let mut is_own = false;
        for encoding in [MshEncoding::Ascii, MshEncoding::Binary] {
            write_mesh(scratch, &mesh, 1.0, encoding)?;
            is_own |= file::read_bytes(scratch)? == found;
        }
        file::write_bytes(scratch, kept)?;
        Ok(is_own)
    };
    // What cannot be read is not this program's.
    rewritten().unwrap_or(false)
}

/// The measures as the mesher takes them.
fn tube(options: &Options) -> Result<Tube, BadInput> {
    const MM: f64 = 1e-3;
    let profile: Vec<[f64; 2]> = match (options.length_mm, options.outer_diameter_mm) {
        (Some(length), Some(base)) => {
            vec![[0.0, base], [length, options.tip_diameter_mm.unwrap_or(base)]]
        }
        _ => options.profile.clone(),
    };
    let profile: Vec<[f64; 2]> =
        profile.into_iter().map(|[z, diameter]| [z * MM, 0.5 * diameter * MM]).collect();
    let channels = channels(options)?;
    let edge = options.edge_mm.map(|edge| edge * MM);
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
    let bore_radius = 0.5 * options.bore_diameter_mm * MM;
    let channel_radius = channels.first().map_or(0.0, |channel| channel.radius);
    let layers = match (options.layers, edge) {
        (Some(layers), _) => Layers::Count(layers),
        (None, Some(edge)) => Layers::Height(edge),
        (None, None) => return Err(BadInput::new("tube", "--layers or --edge-mm", "neither")),
    };
    Ok(Tube {
        outer_divisions: sides(options.outer_sides, radius, 8.0, 16),
        bore_divisions: sides(options.bore_sides, bore_radius, 6.0, 8),
        channel_divisions: sides(options.channel_sides, channel_radius, 4.0, 4),
        profile,
        bore_radius,
        channels,
        layers,
        order: if options.quadratic { Order::Quadratic } else { Order::Linear },
    })
}

fn channels(options: &Options) -> Result<Vec<TendonChannel>, BadInput> {
    let n = options.channels;
    match (n, options.channel_diameter_mm, options.channel_radius_mm) {
        (0, None, None) => Ok(Vec::new()),
        (1.., Some(diameter), Some(distance)) => {
            let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(n);
            let channel = |k| TendonChannel {
                angle: angle(k),
                center_radius: 1e-3 * distance,
                radius: 0.5e-3 * diameter,
            };
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
#[cfg(feature = "clap")]
fn corner(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(':');
    let numbers = numbers.and_then(|(z, d)| {
        Some([crate::shared::number::position_mm(z).ok()?, crate::shared::number::position_mm(d).ok()?])
    });
    numbers.ok_or_else(|| "expected Z:D in mm, for example 305:12.8".to_owned())
}

fn check_ending(path: &std::path::Path, option: &str, ending: &str) -> Result<(), BadInput> {
    if path.extension().is_some_and(|extension| extension == ending) {
        return Ok(());
    }
    Err(BadInput::new(option, format!("a name ending in .{ending}"), path.display().to_string()))
}

/// Prints how good the elements are.
pub fn print_quality(mesh: &Mesh, quality: &MeshQuality, context: &Context) {
    let groups: Vec<String> =
        mesh.groups.iter().map(|(name, nodes)| format!("{name} ({})", nodes.len())).collect();
    context.print(format_args!(
        "{} nodes, {} tetrahedra, {:.1} mm3",
        quality.n_nodes,
        quality.n_cells,
        1e9 * quality.volume.sum
    ));
    context.print(format_args!("groups (nodes): {}", groups.join(", ")));
    context.print("");
    context.print(
        "                        worst (tetrahedron)        1 %        5 %     median       mean       best",
    );
    let row = |name: &str, unit: f64, spread: &Distribution| {
        let figure = |value: f64| format!("{:>11.4}", value * unit);
        context.print(format_args!(
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
    context.print("");
    histogram("radius ratio [-]", 1.0, &quality.radius_ratio, context);
    context.print("");
    histogram("smallest angle [deg]", 1f64.to_degrees(), &quality.smallest_angle, context);
}

fn histogram(name: &str, unit: f64, spread: &Distribution, context: &Context) {
    const WIDTH: usize = 50;
    context.print(name);
    let most = spread.counts.iter().copied().max().unwrap_or(0).max(1);
    for (limits, count) in spread.limits.windows(2).zip(&spread.counts) {
        let [low, high] = [limits[0] * unit, limits[1] * unit];
        let bar = "#".repeat((count * WIDTH).div_ceil(most));
        context.print(format!("{low:>6.1} to {high:<5.1} {count:>9}  {bar}").trim_end());
    }
}
