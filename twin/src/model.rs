//! The twin of one robot: body, cables, loads and tip. Never changes.

use std::borrow::Cow;
use std::sync::Arc;

use hysteron_base::{
    BadInput, Bounds, Insert, PrescribedQuantity, Region, Scene, Tendon, TipDefinition, parallel,
};
use hysteron_fem::{Embedding, FemModel, Mesh, MeshQuality};
use nalgebra::{Matrix3, Vector3};

use crate::attachment::{carried, carried_tendon_point, shown_mm};
use crate::body_shape::{BodyShape, mesh_hash};
use crate::cable::{CablePoint, Cables};
use crate::chain::Chain;
use crate::friction_points::{FrictionPoint, friction_points, set_compliance};
use crate::layout::auxiliary_tendons;
use crate::registration::Registration;
use crate::report::Accuracy;
use crate::state::TwinState;
use crate::{Error, Result};

/// How one tendon is driven during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Hold this stroke [m] at the pulled end, counted from the tendon's zero, while the tension stays within its
    /// bounds; slack (or slipping) otherwise.
    Stroke(f64),
    /// Hold this tension [N].
    Tension(f64),
    /// Let the inverse problem choose; in the forward problem, the least tension allowed.
    Free,
}

/// A tendon as the twin keeps it.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinTendon {
    /// Name from the scene.
    pub name: String,
    /// Its drive unless a command sets another.
    pub drive: PrescribedQuantity,
    /// Tension bounds [N].
    pub tension: Bounds,
    /// Stroke bounds [m].
    pub stroke: Bounds,
    /// Farthest that a carrying point lies outside the body at rest [m].
    pub outside: f64,
    /// How much it stretches per tension [m/N].
    pub compliance: f64,
    /// Length by which it is pulled at a target stroke of zero [m].
    pub zero: f64,
}

impl TwinTendon {
    fn new(tendon: Tendon, outside: f64) -> Self {
        Self {
            name: tendon.name,
            drive: tendon.drive,
            tension: tendon.tension,
            stroke: tendon.stroke,
            outside,
            compliance: tendon.compliance,
            zero: tendon.zero,
        }
    }

    /// The target of a tendon that nothing drives.
    pub fn resting_target(&self) -> Target {
        match self.drive {
            PrescribedQuantity::Stroke => Target::Stroke(self.stroke.clamp(0.0)),
            PrescribedQuantity::Tension => Target::Tension(self.tension.clamp(0.0)),
            PrescribedQuantity::Free => Target::Free,
        }
    }

    /// Accepts a stroke [m] within the bounds, or a rounding outside of them: a file may have lost its last digits.
    ///
    /// # Errors
    /// `BadInput` at `place`, naming the bounds.
    pub fn check_stroke(
        &self,
        stroke: f64,
        place: impl FnOnce() -> String,
    ) -> std::result::Result<(), BadInput> {
        let Bounds { min, max } = self.stroke;
        let air = 1e-9 * min.abs().max(max.abs());
        if (min - air..=max + air).contains(&stroke) {
            return Ok(());
        }
        let expected =
            format!("{} to {} mm, the bounds of tendon {}", shown_mm(min), shown_mm(max), self.name);
        Err(BadInput::new(place(), expected, format!("{} mm", shown_mm(stroke))).hint(
            "stroke_min_mm and stroke_max_mm in the scene; is the unit of the column its ending, _mm or _m?",
        ))
    }
}

/// A moment fixed in space, spread over nodes as forces: f_i = w_i (S⁻¹ M) × r_i about the nodes' weighted
/// centre, with S = Σ w_i (|r_i|² 1 - r_i r_iᵀ). The forces add up to zero and their moment to M however
/// the nodes have moved.
#[derive(Debug, Clone, PartialEq)]
pub struct Couple {
    /// Nodes (model order) and weights, for example their volumes; not all in one line.
    pub nodes: Vec<(u32, f64)>,
    /// The moment [N m].
    pub moment: [f64; 3],
}

impl Couple {
    /// Adds `factor` times the forces at positions `x` to `out`.
    pub(crate) fn add_forces(&self, x: &[[f64; 4]], factor: f64, out: &mut [[f64; 4]]) {
        let at = |node: u32| {
            let [a, b, c, _] = x[node as usize];
            Vector3::new(a, b, c)
        };
        let total: f64 = self.nodes.iter().map(|(_, weight)| weight).sum();
        let center = self.nodes.iter().map(|&(node, weight)| weight * at(node)).sum::<Vector3<f64>>() / total;
        let mut second = Matrix3::zeros();
        for &(node, weight) in &self.nodes {
            let arm = at(node) - center;
            second += weight * (Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose());
        }
        let turn = second.try_inverse().unwrap_or_else(Matrix3::zeros) * Vector3::from(self.moment);
        for &(node, weight) in &self.nodes {
            let force = turn.cross(&(at(node) - center));
            for c in 0..3 {
                out[node as usize][c] += factor * weight * force[c];
            }
        }
    }
}

/// The twin of one robot.
#[derive(Debug, Clone)]
pub struct Twin {
    /// The chain that moves in place of the body, if any.
    pub chain: Option<Arc<Chain>>,
    /// SHA-256 of the mesh.
    mesh_hash: String,
    /// Hashes of all that a chain depends on.
    pub(crate) shape: BodyShape,
    /// The finite elements.
    pub body: Arc<FemModel>,
    /// Tendons: `n_primary` real ones first, then the auxiliary ones.
    pub tendons: Vec<TwinTendon>,
    /// Their geometry, in the same order, then one cable per friction point: its tendon from there on.
    pub cables: Cables,
    /// Where friction acts on the real tendons.
    pub friction: Vec<FrictionPoint>,
    /// How far a servo moves on reversal until its tendon follows [m].
    pub backlash: f64,
    /// Number of real tendons.
    pub n_primary: usize,
    /// Fastest that an identified stroke of an auxiliary tendon may change [m/s]; infinite without a limit.
    pub auxiliary_rate: f64,
    /// Acceleration of gravity, whose forces the loads contain [m/s²].
    pub gravity: [f64; 3],
    /// Constant loads on the nodes [N], model order.
    pub loads: Vec<[f64; 4]>,
    /// Moments on the finite elements, in addition to the loads; a scene has none, and a chain takes none.
    pub couples: Vec<Couple>,
    /// The tip, as weighted nodes.
    pub tip: Embedding,
    /// From the scene's frame to that in which the tip is recorded.
    pub tracker: Registration,
    /// Accuracy of every step.
    pub accuracy: Accuracy,
}

impl Twin {
    /// The error of a primary tendon whose stroke is held, as `is_by_stroke` says by its number, but takes its largest tension in
    /// `state`, if there is one.
    pub fn overloaded(&self, state: &TwinState, is_by_stroke: impl Fn(usize) -> bool) -> Option<Error> {
        (0..self.n_primary).find_map(|j| {
            let TwinTendon { name, tension, .. } = &self.tendons[j];
            let is_met = !is_by_stroke(j) || state.tensions[j] < tension.max;
            (!is_met).then(|| Error::Overloaded { tendon: name.clone(), largest: tension.max })
        })
    }

    /// Reads the scene's mesh and builds its twin, with the chain of the scene if it names one.
    ///
    /// # Errors
    /// Everything that is wrong with the mesh, the clamp, a tendon point, the tip or the chain.
    pub fn from_scene(scene: &Scene) -> Result<Self> {
        Self::new(scene, &read_body(scene)?.0)?.with_body_of(scene)
    }

    /// The same robot, moved by the chain that its scene names, if it names one.
    ///
    /// # Errors
    /// A chain that cannot be read, or of another body.
    pub fn with_body_of(self, scene: &Scene) -> Result<Self> {
        match &scene.reduced_path {
            Some(path) => Chain::read(path, &self).map(|chain| self.with_chain(chain)),
            None => Ok(self),
        }
    }

    /// The same robot, moved by a chain that was made or read for it.
    pub fn with_chain(self, chain: Chain) -> Self {
        Self { chain: Some(Arc::new(chain)), ..self }
    }

    /// The same robot, moved by its finite elements.
    pub fn without_chain(self) -> Self {
        Self { chain: None, ..self }
    }

    /// Builds the twin of `scene` on a mesh already read, of finite elements.
    ///
    /// # Errors
    /// As [`Self::from_scene`].
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Self> {
        mesh.check_size()?;
        let clamped = region_nodes(mesh, &scene.clamp, "clamp")?;
        let body = FemModel::new(mesh, scene.material.clone(), &clamped)?;
        let body = with_inserts(body, mesh, &scene.inserts)?;
        body.check_clamp()?;
        let tendons = all_tendons(scene);
        let mut cables = parallel::try_map(&tendons, |tendon| attached(&body, tendon))?;
        let distance = |point: &CablePoint| point.carriers().map_or(0.0, |at| at.distance);
        let farthest = |points: &Vec<CablePoint>| points.iter().map(distance).fold(0.0, f64::max);
        let outside: Vec<f64> = cables.iter().map(farthest).collect();
        let friction = friction_of(scene);
        cables.extend(
            friction.iter().map(|point| cables[point.tendon][point.first..].to_vec()).collect::<Vec<_>>(),
        );
        let mut cables = Cables::new(&body, &cables);
        set_compliance(&mut cables, &tendons, &friction, scene.friction.as_ref());
        let tip = match &scene.tip {
            TipDefinition::Group(group) => {
                mean_of(&body, &region_nodes(mesh, &Region::Group(group.clone()), "tip")?)
            }
            TipDefinition::Point(point) => carried(&body, *point, ON_SURFACE, "tip.point_mm")?,
        };
        if !moves(&body, &tip) {
            return Err(BadInput::new("tip", "a part of the body that can move", "one that is clamped")
                .hint("is [clamp] the other end of the robot?")
                .into());
        }
        let mut loads = body.weight(scene.gravity);
        for (k, load) in scene.point_forces.iter().enumerate() {
            let place = format!("point_force[{}].at_mm", k + 1);
            let at = carried(&body, load.at, ON_SURFACE, &place)?;
            if !moves(&body, &at) {
                return Err(BadInput::new(place, "a point that can move", "one that is clamped").into());
            }
            for (node, weight) in at.nodes.iter().zip(&at.weights) {
                for c in 0..3 {
                    loads[*node as usize][c] += weight * load.force[c];
                }
            }
        }
        let specs =
            tendons.into_iter().zip(outside).map(|(tendon, outside)| TwinTendon::new(tendon, outside));
        let mesh_hash = mesh_hash(mesh);
        Ok(Self {
            chain: None,
            shape: BodyShape::new(scene, &mesh_hash),
            mesh_hash,
            body: Arc::new(body),
            tendons: specs.collect(),
            cables,
            friction,
            backlash: backlash(scene),
            n_primary: scene.tendons.len(),
            auxiliary_rate: auxiliary_rate(scene),
            gravity: scene.gravity,
            loads,
            couples: Vec::new(),
            tip,
            tracker: Registration::new(&scene.tracker),
            accuracy: accuracy(scene),
        })
    }

    /// The same robot with the numbers of another scene of it, on the same body and with the same chain: stiffness, density,
    /// gravity, what moves the tendons, their zeros and compliance, friction, tracker, accuracy. `None` where the scene is of
    /// another body or has other tendons or friction points.
    pub(crate) fn with_numbers_of(mut self, scene: &Scene) -> Option<Self> {
        let friction = friction_of(scene);
        let is_there = |(a, b): (&FrictionPoint, &FrictionPoint)| (a.tendon, a.first) == (b.tendon, b.first);
        let has_same_points =
            friction.len() == self.friction.len() && friction.iter().zip(&self.friction).all(is_there);
        if BodyShape::new(scene, &self.mesh_hash) != self.shape || !has_same_points {
            return None;
        }
        self.loads = self.loads_besides_gravity();
        if scene.material != self.body.material {
            Arc::make_mut(&mut self.body).material = scene.material.clone();
        }
        for (load, weight) in self.loads.iter_mut().zip(self.body.weight(scene.gravity)) {
            load.iter_mut().zip(weight).for_each(|(load, weight)| *load += weight);
        }
        self.gravity = scene.gravity;
        let tendons = all_tendons(scene);
        self.cables.compliance.iter_mut().for_each(Vec::clear);
        set_compliance(&mut self.cables, &tendons, &friction, scene.friction.as_ref());
        self.friction = friction;
        for (known, tendon) in self.tendons.iter_mut().zip(tendons) {
            *known = TwinTendon::new(tendon, known.outside);
        }
        self.backlash = backlash(scene);
        self.auxiliary_rate = auxiliary_rate(scene);
        self.tracker = Registration::new(&scene.tracker);
        self.accuracy = accuracy(scene);
        self.chain = self.chain.take().map(|chain| Arc::new(chain.bound(&self)));
        Some(self)
    }

    /// Constant forces on the nodes without those of gravity [N].
    pub(crate) fn loads_besides_gravity(&self) -> Vec<[f64; 4]> {
        let weight = self.body.weight(self.gravity);
        let rest = self.loads.iter().zip(&weight).map(|(all, weight)| {
            let mut rest = *all;
            rest.iter_mut().zip(weight).for_each(|(all, weight)| *all -= weight);
            rest
        });
        rest.collect()
    }

    /// The unloaded body: at rest, no tension, no load applied yet.
    pub fn rest(&self) -> TwinState {
        let (positions, interfaces) = match &self.chain {
            Some(chain) => (Vec::new(), chain.rest.clone()),
            None => (self.body.rest.clone(), Vec::new()),
        };
        TwinState {
            positions,
            interfaces,
            tensions: vec![0.0; self.cables.len()],
            load: 0.0,
            slip: vec![0.0; self.friction.len()],
            backlash: vec![0.0; self.n_backlash()],
        }
    }

    /// Number of nodes and of interfaces that a state has.
    pub(crate) fn configuration(&self) -> [usize; 2] {
        match &self.chain {
            Some(chain) => [0, chain.rest.len()],
            None => [self.body.n_nodes(), 0],
        }
    }

    /// Number of tendons with backlash.
    pub(crate) fn n_backlash(&self) -> usize {
        if self.backlash > 0.0 { self.n_primary } else { 0 }
    }

    /// Stroke of every tendon [m]: how much shorter its way through the body has become. Geometry alone, without the
    /// tendon's stretch and zero.
    pub fn strokes_of(&self, state: &TwinState) -> Vec<f64> {
        let mut strokes = match &self.chain {
            Some(chain) => chain.shape_of(state).strokes,
            None => {
                let mut shape = self.cables.shape();
                self.cables.measure(&state.positions, &mut shape);
                shape.strokes
            }
        };
        strokes.truncate(self.tendons.len());
        strokes
    }

    /// Positions of the nodes [m], model order, padded. Those of a chain move with the frames of its interfaces, without their
    /// warping: for pictures, not for forces.
    pub fn nodes_of<'a>(&self, state: &'a TwinState) -> Cow<'a, [[f64; 4]]> {
        match &self.chain {
            Some(chain) => Cow::Owned(chain.nodes_of(&self.body, state)),
            None => Cow::Borrowed(&state.positions),
        }
    }

    /// Tension of tendon `j` at its pulled end, and behind each of its friction points [N].
    pub fn tensions_along(&self, j: usize, state: &TwinState) -> Vec<f64> {
        let mut along = vec![state.tensions[j]];
        let jumps = self.friction.iter().zip(&state.tensions[self.tendons.len()..]);
        for (_, jump) in jumps.filter(|(point, _)| point.tendon == j) {
            along.push(along[along.len() - 1] + jump);
        }
        along
    }

    /// Length by which every tendon has been pulled at its end, s + C T (n_tendons) [m].
    pub(crate) fn pulled(&self, state: &TwinState) -> Vec<f64> {
        let mut pulled = self.strokes_of(state);
        for (j, stroke) in pulled.iter_mut().enumerate() {
            *stroke += self.cables.stretch(j, &state.tensions);
        }
        pulled
    }

    /// The stroke that a servo shows for every tendon [m], stretch and zero included: as [`Target::Stroke`] these keep
    /// the equilibrium where it is.
    pub fn commands_of(&self, state: &TwinState) -> Vec<f64> {
        let pulled = self.pulled(state);
        pulled.iter().zip(&self.tendons).map(|(stroke, tendon)| stroke - tendon.zero).collect()
    }
}

/// The tendons of a scene, auxiliary ones last.
fn all_tendons(scene: &Scene) -> Vec<Tendon> {
    scene.tendons.iter().cloned().chain(scene.auxiliary.iter().flat_map(auxiliary_tendons)).collect()
}

/// Where friction acts on the tendons of a scene.
fn friction_of(scene: &Scene) -> Vec<FrictionPoint> {
    scene.friction.iter().flat_map(|friction| friction_points(&scene.tendons, friction)).collect()
}

/// How far a servo moves on reversal until its tendon follows [m].
fn backlash(scene: &Scene) -> f64 {
    scene.friction.map_or(0.0, |friction| friction.backlash)
}

/// Fastest change of an identified stroke [m/s].
fn auxiliary_rate(scene: &Scene) -> f64 {
    scene.auxiliary.as_ref().map_or(f64::INFINITY, |layout| layout.stroke_rate)
}

fn accuracy(scene: &Scene) -> Accuracy {
    Accuracy { relative_residual: scene.solver.relative_residual, stroke: scene.solver.stroke_tolerance }
}

/// The scene's mesh, and how good its tetrahedra are.
///
/// # Errors
/// Everything that is wrong with the mesh.
pub fn read_body(scene: &Scene) -> Result<(Mesh, MeshQuality)> {
    let mesh = hysteron_fem::read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
    let quality = hysteron_fem::check_mesh(&mesh, &scene.mesh_path.display().to_string())?;
    Ok((mesh, quality))
}

/// The points of a tendon on the body.
fn attached(body: &FemModel, tendon: &Tendon) -> Result<Vec<CablePoint>> {
    let point = |(k, point): (usize, &[f64; 3])| {
        let place = format!("tendon.{}.points_mm[{k}]", tendon.name);
        if tendon.fixed.contains(&k) {
            return Ok(CablePoint::Fixed(*point));
        }
        carried_tendon_point(body, tendon, k, &place)
    };
    let points: Vec<CablePoint> = tendon.points.iter().enumerate().map(point).collect::<Result<_>>()?;
    if !points.iter().filter_map(CablePoint::carriers).any(|at| moves(body, at)) {
        let place = format!("tendon.{}.points_mm", tendon.name);
        let found = "clamped or fixed ones alone";
        return Err(BadInput::new(place, "a point beyond the clamp", found).into());
    }
    Ok(points)
}

/// The body with its stiffer parts.
fn with_inserts(body: FemModel, mesh: &Mesh, inserts: &[Insert]) -> Result<FemModel> {
    if inserts.is_empty() {
        return Ok(body);
    }
    let mut ratios = vec![1.0; body.cells.len()];
    for (k, insert) in inserts.iter().enumerate() {
        let place = format!("insert[{}]", k + 1);
        let mut is_in = vec![false; body.n_nodes()];
        for node in region_nodes(mesh, &insert.region, &place)? {
            is_in[body.model_node[node as usize] as usize] = true;
        }
        let whole = (0..ratios.len()).filter(|&e| body.cells.corners(e).iter().all(|c| is_in[*c as usize]));
        let whole: Vec<usize> = whole.collect();
        if whole.is_empty() {
            let expected = "a part of the mesh with whole elements in it";
            return Err(BadInput::new(place, expected, "none")
                .hint("layers of the mesh must end where the part ends")
                .into());
        }
        whole.into_iter().for_each(|e| ratios[e] = insert.modulus_ratio);
    }
    Ok(body.with_modulus_ratios(ratios))
}

/// Whether a point that these nodes carry can move: clamped nodes come after the free ones.
fn moves(body: &FemModel, carrier: &Embedding) -> bool {
    let mut carriers = carrier.nodes.iter().zip(&carrier.weights);
    carriers.any(|(node, weight)| (*node as usize) < body.n_free && *weight != 0.0)
}

/// How far outside the body a load or tip may lie [m]: round-off of typed coordinates on a surface.
const ON_SURFACE: f64 = 1e-6;

/// File nodes of a region.
fn region_nodes(mesh: &Mesh, region: &Region, place: &str) -> Result<Vec<u32>> {
    match region {
        Region::Group(name) => {
            mesh.groups.get(name).filter(|nodes| !nodes.is_empty()).cloned().ok_or_else(|| {
                let known: Vec<&str> = mesh.groups.keys().map(String::as_str).collect();
                let found = format!("no nodes in {name:?}; the mesh has {}", known.join(", "));
                let hint = "name a physical group when meshing, or use box_min_mm and box_max_mm";
                BadInput::new(format!("{place}.group"), "a physical group of the mesh", found)
                    .hint(hint)
                    .into()
            })
        }
        Region::Box { min, max } => {
            let inside = |node: &[f64; 3]| (0..3).all(|c| node[c] >= min[c] && node[c] <= max[c]);
            let nodes = mesh.nodes.iter().zip(0..).filter(|(node, _)| inside(node)).map(|(_, i)| i);
            let nodes: Vec<u32> = nodes.collect();
            if nodes.is_empty() {
                let hint = "compare with the extent of the mesh";
                return Err(BadInput::new(place, "a box with nodes in it", "none").hint(hint).into());
            }
            Ok(nodes)
        }
    }
}

fn mean_of(body: &FemModel, file_nodes: &[u32]) -> Embedding {
    Embedding {
        nodes: file_nodes.iter().map(|&file| body.model_node[file as usize]).collect(),
        weights: vec![1.0 / file_nodes.len() as f64; file_nodes.len()],
        distance: 0.0,
    }
}
