//! Options of `hysteron mesh`.

use std::path::PathBuf;

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
    /// Height of the layers where a link of the profile ends, which then grow away from there: a third of the radius of the
    /// anchor of the tendons that end there [default: as the other layers]
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_parser = crate::shared::number::position_mm, value_name = "MM", requires = "edge_mm", conflicts_with = "layers"))]
    pub end_edge_mm: Option<f64>,
    /// Give every polygon the area of its circle: the corners then lie outside the circle, the middles of the sides inside
    #[cfg_attr(feature = "clap", arg(long))]
    pub circle_areas: bool,
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

/// `Z:D` as two numbers.
#[cfg(feature = "clap")]
fn corner(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(':');
    let numbers = numbers.and_then(|(z, d)| {
        Some([crate::shared::number::position_mm(z).ok()?, crate::shared::number::position_mm(d).ok()?])
    });
    numbers.ok_or_else(|| "expected Z:D in mm, for example 305:12.8".to_owned())
}
