//! Where a body is cut into sections across its axis.
//!
//! A plane may cut where no element crosses it: meshes made layer by layer have such planes. Of them, those are taken at which
//! tendons end, where interfaces follow the pull exactly, or the stiffness jumps, and others that make sections nearest to [`LENGTH`] diameters.
//! Other meshes are cut by the centroids of their elements, and interfaces are the nodes that the elements of both sides share.

use hysteron_base::{BadInput, MaterialLaw};
use hysteron_fem::FemModel;

use super::section::Site;
use crate::Result;

/// Length of a section over the diameter of the body there [-]: the shorter, the better a cubic energy holds.
const LENGTH: f64 = 0.4;
/// Distance of nodes of the same plane, over the length of the body [-]: files round coordinates.
const SAME_PLANE: f64 = 1e-6;
/// Distance of a tendon's end from a plane that is made an interface for it, over the length of a section [-].
const AT_END: f64 = 0.1;

/// Fewest nodes of an interface.
const MIN_NODES: usize = 6;

/// Where a node of the body lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NodePlace {
    /// Below the first interface: held still.
    Held,
    /// On this interface.
    Interface(usize),
    /// Within this section.
    Section(usize),
}

/// The cut of a body.
#[derive(Debug, Clone)]
pub(crate) struct Cut {
    /// Place of every node, model order.
    pub places: Vec<NodePlace>,
    /// Section of every element that can deform; `None` below the first interface.
    pub sections: Vec<Option<usize>>,
    /// Number of sections; there is one interface more.
    pub n_sections: usize,
}

impl Cut {
    /// Cuts `body` across the coordinate axis along which it is longest, from its clamp on; tendons end at `ends` [m].
    ///
    /// # Errors
    /// `BadInput` where fewer than two sections are found, where the clamp is not all that lies on one side of a plane, or
    /// for a law without a potential.
    pub fn new(body: &FemModel, ends: &[[f64; 3]]) -> Result<Self> {
        if body.material.law == MaterialLaw::CorotationalEdges {
            let found = "corotational_edges";
            return Err(BadInput::new("material.law", "a law with an energy", found)
                .hint("use corotational")
                .into());
        }
        let range = |c: usize| {
            let along = body.rest.iter().map(|node| node[c]);
            (along.clone().fold(f64::MAX, f64::min), along.fold(f64::MIN, f64::max))
        };
        let ranges = [0, 1, 2].map(range);
        let extent = ranges.map(|(low, high)| high - low);
        let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(2);
        let middle = 0.5 * (ranges[axis].0 + ranges[axis].1);
        let held: f64 = body.rest[body.n_free..].iter().map(|node| node[axis] - middle).sum();
        // From the clamp up.
        let sign = if held > 0.0 { -1.0 } else { 1.0 };
        let heights: Vec<f64> = body.rest.iter().map(|node| sign * (node[axis] - middle)).collect();
        let near = SAME_PLANE * extent[axis];
        let planes = uncrossed_planes(body, &heights, near);
        let length = |height| LENGTH * diameter(body, axis, &heights, height, near);
        let jumps = stiffness_jumps(body);
        let heights_of = jumps.iter().map(|&node| heights[node]);
        let ends: Vec<f64> = ends.iter().map(|end| sign * (end[axis] - middle)).chain(heights_of).collect();
        let first = first_plane(body, &heights);
        let chosen = choose(&planes, &fixed_planes(&planes, &ends, first, length), length);
        if chosen.len() < 3 {
            if !jumps.is_empty() {
                let found = format!("{} such planes, with parts of another stiffness", planes.len());
                return Err(BadInput::new(
                    "mesh",
                    "layers of elements with plane faces across its axis",
                    found,
                )
                .hint("use a mesh that is made layer by layer")
                .into());
            }
            let width = (0..3).filter(|&c| c != axis).map(|c| extent[c]).fold(0.0, f64::max);
            return Self::by_centroids(body, &heights, (first, LENGTH * width), near);
        }
        let places: Vec<NodePlace> = heights.iter().map(|&height| place(&chosen, height, near)).collect();
        check_clamp(body, &places)?;
        let section = |height: f64| chosen.partition_point(|&plane| plane < height).checked_sub(1);
        let sections = (0..body.cells.len()).map(|e| section(centroid(body, &heights, e))).collect();
        Ok(Self { places, sections, n_sections: chosen.len() - 1 })
    }

    /// Cuts a body by the centroids of its elements into sections as long as `length` nearly, from `first` on.
    fn by_centroids(
        body: &FemModel,
        heights: &[f64],
        (first, length): (f64, f64),
        near: f64,
    ) -> Result<Self> {
        let last = heights.iter().copied().fold(f64::MIN, f64::max);
        let n_sections = ((last - first) / length).round().max(2.0) as usize;
        let long = (last - first) / n_sections as f64;
        let is_held = |node: &u32| *node as usize >= body.n_free;
        let section = |e: usize| {
            let beyond = ((centroid(body, heights, e) - first) / long).max(0.0) as usize;
            (!body.cells.nodes(e).iter().all(is_held)).then(|| beyond.min(n_sections - 1))
        };
        let sections: Vec<Option<usize>> = (0..body.cells.len()).map(section).collect();
        // First and last section of each node.
        let mut touched = vec![(usize::MAX, 0); body.n_nodes()];
        for (e, own) in sections.iter().enumerate().filter_map(|(e, own)| Some((e, (*own)?))) {
            for &node in body.cells.nodes(e) {
                let (low, high) = &mut touched[node as usize];
                (*low, *high) = ((*low).min(own), (*high).max(own));
            }
        }
        let place = |(node, &(low, high)): (usize, &(usize, usize))| match high.checked_sub(low) {
            _ if node >= body.n_free && low > 0 => Some(NodePlace::Held).filter(|_| low == usize::MAX),
            _ if node >= body.n_free => Some(NodePlace::Interface(0)).filter(|_| high == 0),
            Some(0) if low + 1 == n_sections && heights[node] > last - near => {
                Some(NodePlace::Interface(n_sections))
            }
            Some(0) => Some(NodePlace::Section(low)),
            Some(1) => Some(NodePlace::Interface(high)),
            _ => None,
        };
        let places: Option<Vec<NodePlace>> = touched.iter().enumerate().map(place).collect();
        let cut = places.map(|places| Self { places, sections, n_sections });
        cut.filter(|cut| cut.has_wide_interfaces()).ok_or_else(|| {
            let expected = "a body that sections of 0.4 diameters divide, with a clamp at one end and a plane face at the other";
            BadInput::new("mesh", expected, "elements, a clamp or an end that no section fits")
                .hint("use a finer mesh, made layer by layer if you can; clamp one end as a whole")
                .into()
        })
    }

    /// Whether every interface has nodes enough to hold a rotation.
    fn has_wide_interfaces(&self) -> bool {
        let count = |i: usize| self.places.iter().filter(|place| **place == NodePlace::Interface(i)).count();
        (0..=self.n_sections).all(|i| count(i) >= MIN_NODES)
    }

    /// The frame that a node moves with; `None` where it is held.
    pub fn site(&self, node: u32) -> Option<Site> {
        match self.places[node as usize] {
            NodePlace::Held => None,
            NodePlace::Interface(i) => i.checked_sub(1).map(Site::End),
            NodePlace::Section(e) => Some(Site::Within(e)),
        }
    }
}

/// Nodes between elements of different stiffness. A section of both would turn its stiff part by a first-order shape, whose
/// spurious strain that part multiplies.
fn stiffness_jumps(body: &FemModel) -> Vec<usize> {
    let mut range = vec![(f64::INFINITY, 0.0f64); body.n_nodes()];
    for (e, &ratio) in body.modulus_ratios.iter().enumerate() {
        for node in body.cells.corners(e) {
            let (least, most) = &mut range[node as usize];
            (*least, *most) = (least.min(ratio), most.max(ratio));
        }
    }
    (0..range.len()).filter(|&node| range[node].0 < range[node].1).collect()
}

/// Height of an element's centroid.
fn centroid(body: &FemModel, heights: &[f64], e: usize) -> f64 {
    body.cells.corners(e).iter().map(|&node| heights[node as usize]).sum::<f64>() / 4.0
}

/// Height of the highest clamped node.
fn first_plane(body: &FemModel, heights: &[f64]) -> f64 {
    heights[body.n_free..].iter().copied().fold(f64::MIN, f64::max)
}

/// Heights of corner nodes, ascending, that no element crosses.
fn uncrossed_planes(body: &FemModel, heights: &[f64], near: f64) -> Vec<f64> {
    let spans: Vec<(f64, f64)> = (0..body.cells.len())
        .map(|e| {
            let of = body.cells.corners(e).map(|node| heights[node as usize]);
            (of.iter().copied().fold(f64::MAX, f64::min), of.iter().copied().fold(f64::MIN, f64::max))
        })
        .collect();
    let mut levels: Vec<f64> = spans.iter().flat_map(|&(low, high)| [low, high]).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup_by(|next, kept| *next - *kept < near);
    // Elements that begin below and end above a level cross it.
    let mut begins: Vec<f64> = spans.iter().map(|span| span.0 + near).collect();
    let mut ends: Vec<f64> = spans.iter().map(|span| span.1 - near).collect();
    begins.sort_by(f64::total_cmp);
    ends.sort_by(f64::total_cmp);
    levels.retain(|&level| {
        begins.partition_point(|&begin| begin < level) == ends.partition_point(|&end| end <= level)
    });
    levels
}

/// The first plane, those at which tendons end, and the last.
fn fixed_planes(planes: &[f64], ends: &[f64], first: f64, length: impl Fn(f64) -> f64) -> Vec<f64> {
    let nearest =
        |height: f64| planes.iter().copied().min_by(|a, b| (a - height).abs().total_cmp(&(b - height).abs()));
    let Some((first, &last)) = nearest(first).zip(planes.last()) else { return Vec::new() };
    let at_ends = ends
        .iter()
        .filter_map(|&end| nearest(end).filter(|&plane| (plane - end).abs() < AT_END * length(plane)));
    let mut fixed: Vec<f64> =
        at_ends.filter(|&plane| plane > first && plane < last).chain([first, last]).collect();
    fixed.sort_by(f64::total_cmp);
    fixed.dedup();
    fixed
}

/// The `fixed` planes and others between, nearest to `length` apart.
fn choose(planes: &[f64], fixed: &[f64], length: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut chosen = fixed.first().map_or_else(Vec::new, |&first| vec![first]);
    for pair in fixed.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        let mut plane = low;
        while plane < high {
            let next = plane + length(plane);
            // What remains beyond is at least half a section.
            let open = planes.iter().copied().filter(|&other| other > plane && other <= high);
            let open = open.filter(|&other| other == high || high - other > 0.5 * length(other));
            plane = open.min_by(|a, b| (a - next).abs().total_cmp(&(b - next).abs())).unwrap_or(high);
            chosen.push(plane);
        }
    }
    chosen
}

/// Largest extent of the nodes of a plane [m].
fn diameter(body: &FemModel, axis: usize, heights: &[f64], height: f64, near: f64) -> f64 {
    let across = (0..3).filter(|&c| c != axis).map(|c| {
        let on_plane = body.rest.iter().zip(heights).filter(|(_, h)| (**h - height).abs() < near);
        let (low, high) = on_plane
            .fold((f64::MAX, f64::MIN), |(low, high), (node, _)| (low.min(node[c]), high.max(node[c])));
        high - low
    });
    across.fold(0.0, f64::max)
}

fn place(planes: &[f64], height: f64, near: f64) -> NodePlace {
    match planes.partition_point(|&plane| plane < height - near) {
        0 if planes[0] > height + near => NodePlace::Held,
        i if i < planes.len() && planes[i] <= height + near => NodePlace::Interface(i),
        i => NodePlace::Section(i.saturating_sub(1)),
    }
}

/// The clamp must be all that lies up to the first interface.
fn check_clamp(body: &FemModel, places: &[NodePlace]) -> Result<()> {
    let below = |place: &NodePlace| matches!(place, NodePlace::Held | NodePlace::Interface(0));
    let (free, clamped) = places.split_at(body.n_free);
    if free.iter().any(below) || !clamped.iter().all(below) {
        let expected = "all nodes up to a plane across the body's longest axis, and no others";
        return Err(BadInput::new("clamp", expected, "another set of nodes")
            .hint("clamp one end as a whole")
            .into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use hysteron_base::MaterialLaw;
    use hysteron_fem::Order;

    use super::*;
    use crate::{Twin, scenes};

    /// Elements of each section, all of whose nodes lie in it or on its interfaces.
    fn elements_by_section(body: &FemModel, cut: &Cut) -> Vec<usize> {
        let mut counts = vec![0; cut.n_sections];
        for (e, section) in cut.sections.iter().enumerate() {
            let section = section.expect("nothing lies below the clamp");
            let touches = |node: &u32| match cut.places[*node as usize] {
                NodePlace::Held => false,
                NodePlace::Interface(i) => i == section || i == section + 1,
                NodePlace::Section(own) => own == section,
            };
            assert!(body.cells.nodes(e).iter().all(touches), "{e}");
            counts[section] += 1;
        }
        counts
    }

    #[test]
    fn sections_take_whole_elements_and_all_of_them() {
        // 24 layers of 1.67 mm, 12 mm wide: three layers are 5 mm, 0.42 diameters.
        let (scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Quadratic, 24);
        let body = Twin::new(&scene, &mesh).expect("a good scene").body;
        let cut = Cut::new(&body, &[]).expect("a cut");
        assert_eq!(cut.n_sections, 8);
        // The 14th plane cuts a section in two where a tendon ends; one between two planes does not.
        for (layers, n_sections) in [(14.0, 9), (13.5, 8)] {
            let end = [0.0, 4.5e-3, 0.04 / 24.0 * layers];
            assert_eq!(Cut::new(&body, &[end]).expect("a cut").n_sections, n_sections, "{layers}");
        }
        let counts = elements_by_section(&body, &cut);
        assert!(counts.iter().all(|&count| count == body.cells.len() / 8), "{counts:?}");
        let on = |i: usize| cut.places.iter().filter(|place| **place == NodePlace::Interface(i)).count();
        assert!((1..=8).all(|i| on(i) == on(0)), "planes alike");
        assert_eq!(on(0), body.n_nodes() - body.n_free);
    }

    #[test]
    fn another_clamp_or_a_law_without_energy_is_refused() {
        let (mut scene, mesh) = scenes::robot();
        let height = 0.04 / 12.0;
        scene.clamp = hysteron_base::Region::Box { min: [0.0, -1.0, -1.0], max: [1.0, 1.0, height] };
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let error = Cut::new(&twin.body, &[]).expect_err("half a layer is clamped");
        assert_eq!(error.bad_input().map(|bad| bad.place.as_str()), Some("clamp"));
        let (scene, mesh) = scenes::robot_with(MaterialLaw::CorotationalEdges, Order::Linear, 12);
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let error = Cut::new(&twin.body, &[]).expect_err("no energy");
        assert_eq!(error.bad_input().map(|bad| bad.place.as_str()), Some("material.law"));
    }

    /// The robot of the tests with its inner layers' nodes moved along the axis, each by another part of a layer.
    fn uneven(order: Order) -> Twin {
        let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
        let mut uneven = mesh.clone();
        let layer = 0.04 / 24.0;
        for (i, node) in uneven.nodes.iter_mut().enumerate() {
            if node[2] > 0.5 * layer && node[2] < 0.04 - 0.5 * layer {
                node[2] += 0.3 * layer * (2.1 * i as f64).sin();
            }
        }
        let uneven = if order == Order::Quadratic { uneven.to_quadratic() } else { uneven };
        scene.tendons.iter_mut().for_each(|tendon| tendon.attach_within = 1e-3);
        Twin::new(&scene, &uneven).expect("a good scene")
    }

    #[test]
    fn mesh_without_layers_is_cut_by_centroids() {
        for order in [Order::Linear, Order::Quadratic] {
            let twin = uneven(order);
            let body = &twin.body;
            let cut = Cut::new(body, &[]).expect("a cut");
            assert_eq!(cut.n_sections, 8);
            assert!(elements_by_section(body, &cut).iter().all(|&count| count > 0));
            let on = |i: usize| cut.places.iter().filter(|place| **place == NodePlace::Interface(i)).count();
            assert_eq!(on(0), body.n_nodes() - body.n_free);
            assert!((1..=8).all(|i| on(i) >= on(0)), "an interface with holes");
        }
    }

    #[test]
    fn chain_of_a_mesh_without_layers_follows_it() {
        let twin = uneven(Order::Linear);
        let mut chain = crate::chain::Chain::new(&twin).expect("a chain");
        let options = crate::chain::ValidationOptions { count: 4, stroke: 1e-3, tension: 0.0, seed: 3 };
        let exact = crate::chain::Equilibrium::all(&twin, &options).expect("good targets");
        chain.validate(&twin, &options, &exact).expect("good targets");
        let validation = chain.validation.expect("a validation");
        // Interfaces are not plane, and their ten warpings leave more of the responses out than those of layers.
        assert_eq!((validation.count, validation.refused), (4, [0; 2]));
        assert!(validation.tip.largest < 1e-2 && validation.tensions.largest < 1e-2, "{validation:?}");
    }
}
