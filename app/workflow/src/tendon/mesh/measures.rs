//! From the measures that a person types to those that the mesher takes.

use hysteron_base::BadInput;
use hysteron_base::number::shown;
use hysteron_fem::{Layers, Order, TendonChannel, Tube};

use super::options::Options;

/// The measures as the mesher takes them.
pub(super) fn tube(options: &Options) -> Result<Tube, BadInput> {
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
        return Err(BadInput::new("--edge-mm", "a length above 0 mm", format!("{} mm", shown(edge / MM))));
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
    let layers = match (options.layers, edge, options.end_edge_mm) {
        (Some(layers), ..) => Layers::Count(layers),
        (None, Some(height), Some(end)) => Layers::Graded { height, end: end * MM },
        (None, Some(edge), None) => Layers::Height(edge),
        (None, None, _) => return Err(BadInput::new("tube", "--layers or --edge-mm", "neither")),
    };
    let tube = Tube {
        outer_divisions: sides(options.outer_sides, radius, 8.0, 16),
        bore_divisions: sides(options.bore_sides, bore_radius, 6.0, 8),
        channel_divisions: sides(options.channel_sides, channel_radius, 4.0, 4),
        profile,
        bore_radius,
        channels,
        layers,
        order: if options.quadratic { Order::Quadratic } else { Order::Linear },
    };
    Ok(if options.circle_areas { tube.with_circle_areas() } else { tube })
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
