//! How good the elements of a mesh are, on the console.

use hysteron_fem::{Distribution, Mesh, MeshQuality};

use crate::Context;

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
