//! The body: rest mesh, material and supports, in the order the solver wants. Never changes.

use hysteron_base::{BadInput, Material, MaterialLaw};
use nalgebra::Vector3;

use crate::elements::{self, ElementBatch, Tangent};
use crate::mesh::{Cells, Mesh};
use crate::simd::Isa;
use crate::stiffness::{Stiffness, StiffnessPattern};
use crate::{Error, Result, ordering};

/// A clamped elastic body.
///
/// Nodes are kept in *model order*: the free ones as a factorisation eliminates them, then the clamped
/// ones. Positions and forces are arrays of `n_nodes` points in this order, each padded with a zero so
/// that one register holds it; unknown `3 i + c` is coordinate `c` of free node `i`.
#[derive(Debug, Clone)]
pub struct FemModel {
    /// Material of all elements.
    pub material: Material,
    /// Rest positions \[m\], model order.
    pub rest: Vec<[f64; 4]>,
    /// Number of free nodes; they come first.
    pub n_free: usize,
    /// Elements by their nodes in model order, local node order as in the file.
    pub cells: Cells,
    /// Number in the mesh file of each model node.
    pub file_node: Vec<u32>,
    /// Model node of each node of the mesh file.
    pub model_node: Vec<u32>,
    /// Volume of each node in a load, ∫ N_a dV \[m³\]: negative at the corners of quadratic
    /// elements.
    pub nodal_volumes: Vec<f64>,
    /// Stiffness of each element over that of the material \[-\].
    pub modulus_ratios: Vec<f64>,
    /// Instruction set of the kernels.
    pub isa: Isa,
    elements: ElementSet,
}

#[derive(Debug, Clone)]
enum ElementSet {
    Linear(ElementBatch<4, 1>),
    Quadratic(ElementBatch<10, 4>),
}

impl FemModel {
    /// Builds the model of `mesh`, clamped at the file nodes `clamped`.
    ///
    /// # Errors
    /// No node clamped, or all, or one that the mesh lacks; [`MaterialLaw::CorotationalEdges`] on quadratic elements.
    pub fn new(mesh: &Mesh, material: Material, clamped: &[u32]) -> Result<Self> {
        let mut is_clamped = vec![false; mesh.nodes.len()];
        for &node in clamped {
            let Some(flag) = is_clamped.get_mut(node as usize) else {
                let expected = format!("nodes below {}", mesh.nodes.len());
                return Err(BadInput::new("clamp", expected, node.to_string()).into());
            };
            *flag = true;
        }
        let n_free = is_clamped.iter().filter(|clamped| !**clamped).count();
        if n_free == mesh.nodes.len() {
            return Err(BadInput::new("clamp", "at least three nodes held still", "none")
                .hint("a body that nothing holds has no equilibrium")
                .into());
        }
        if n_free == 0 {
            return Err(BadInput::new("clamp", "some free nodes", "all nodes clamped").into());
        }
        let file_node = ordering::model_order(&mesh.nodes, &mesh.cells, &is_clamped);
        let mut model_node = vec![0; file_node.len()];
        for (model, &file) in file_node.iter().enumerate() {
            model_node[file as usize] = model as u32;
        }
        let rest: Vec<[f64; 4]> = file_node
            .iter()
            .map(|&file| {
                let [x, y, z] = mesh.nodes[file as usize];
                [x, y, z, 0.0]
            })
            .collect();
        let sorted = material.law != MaterialLaw::CorotationalEdges;
        let (cells, elements) = match &mesh.cells {
            Cells::Tet4(cells) => {
                let cells = renumbered(cells, &model_node);
                let elements = ElementBatch::new(&in_element_order(&cells, sorted), &rest);
                (Cells::Tet4(cells), ElementSet::Linear(elements))
            }
            Cells::Tet10(_) if !sorted => {
                let found = "ten-node tetrahedra";
                return Err(BadInput::new("material.law", "linear tetrahedra for corotational_edges", found)
                    .hint("use corotational")
                    .into());
            }
            Cells::Tet10(cells) => {
                let cells = renumbered(cells, &model_node);
                let elements = ElementBatch::new(&cells, &rest);
                (Cells::Tet10(cells), ElementSet::Quadratic(elements))
            }
        };
        let nodal_volumes = match &elements {
            ElementSet::Linear(elements) => elements.nodal_volumes(rest.len()),
            ElementSet::Quadratic(elements) => elements.nodal_volumes(rest.len()),
        };
        let (isa, modulus_ratios) = (Isa::detect(), vec![1.0; cells.len()]);
        Ok(Self {
            material,
            rest,
            n_free,
            cells,
            file_node,
            model_node,
            nodal_volumes,
            modulus_ratios,
            isa,
            elements,
        })
    }

    /// The same body with elements that are stiffer than others by these factors, one per element \[-\]; weights stay.
    pub fn with_modulus_ratios(mut self, ratios: Vec<f64>) -> Self {
        let change: Vec<f64> = ratios.iter().zip(&self.modulus_ratios).map(|(new, old)| new / old).collect();
        match &mut self.elements {
            ElementSet::Linear(elements) => elements.stiffen(&change),
            ElementSet::Quadratic(elements) => elements.stiffen(&change),
        }
        self.modulus_ratios = ratios;
        self
    }

    /// Refuses a clamp about which the body could turn: fewer than three nodes, or all in one line.
    ///
    /// # Errors
    /// `BadInput` with the number of clamped nodes.
    pub fn check_clamp(&self) -> Result<()> {
        let held = self.rest[self.n_free..].iter().map(|&[x, y, z, _]| Vector3::new(x, y, z));
        let first = held.clone().next().unwrap_or_default();
        let arms: Vec<Vector3<f64>> = held.map(|node| node - first).collect();
        let along = arms.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
        let off_line = arms.iter().map(|arm| arm.cross(&along).norm()).fold(0.0, f64::max);
        if arms.len() >= 3 && off_line > OFF_LINE_MIN * along.norm_squared() {
            return Ok(());
        }
        let found = match arms.len() {
            1 => "one node".to_owned(),
            2 => "two nodes".to_owned(),
            n => format!("{n} nodes in one line"),
        };
        Err(BadInput::new("clamp", "at least three nodes that are not in one line", found)
            .hint("a body that is held in fewer places can turn")
            .into())
    }

    /// The same model with its kernels on another instruction set.
    pub fn with_isa(mut self, isa: Isa) -> Self {
        self.isa = isa;
        self
    }

    /// Number of nodes, clamped ones included.
    pub fn n_nodes(&self) -> usize {
        self.rest.len()
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        3 * self.n_free
    }

    /// Elastic energy \[J\] at positions `x` \[m\] (model order).
    pub fn energy(&self, x: &[[f64; 4]]) -> f64 {
        match &self.elements {
            ElementSet::Linear(elements) => elements::energy(self.isa, elements, &self.material, x),
            ElementSet::Quadratic(elements) => elements::energy(self.isa, elements, &self.material, x),
        }
    }

    /// Internal nodal forces, the gradient of the energy \[N\], written to `out` (model order). False if an element is
    /// inverted, det F <= 0 in one of its quadrature points: no law means anything there, and what balances is no
    /// equilibrium. [`Self::first_inverted`] names it.
    pub fn internal_force_into(&self, x: &[[f64; 4]], out: &mut [[f64; 4]]) -> bool {
        out.fill([0.0; 4]);
        match &self.elements {
            ElementSet::Linear(elements) => elements::force_into(self.isa, elements, &self.material, x, out),
            ElementSet::Quadratic(elements) => {
                elements::force_into(self.isa, elements, &self.material, x, out)
            }
        }
    }

    /// The first element, numbered as in the mesh file from 0, that is inverted at positions `x`, with the least det
    /// F of its quadrature points \[-\]. Slow: to name what [`Self::internal_force_into`] has noticed.
    pub fn first_inverted(&self, x: &[[f64; 4]]) -> Option<(usize, f64)> {
        match &self.cells {
            Cells::Tet4(cells) => elements::first_inverted::<4, 1>(cells, &self.rest, x),
            Cells::Tet10(cells) => elements::first_inverted::<10, 4>(cells, &self.rest, x),
        }
    }

    /// Weight of the nodes under the acceleration `gravity` \[m/s²\]: forces \[N\], model order.
    pub fn weight(&self, gravity: [f64; 3]) -> Vec<[f64; 4]> {
        let density = self.material.density;
        let [x, y, z] = gravity;
        self.nodal_volumes.iter().map(|volume| [x, y, z, 0.0].map(|g| density * volume * g)).collect()
    }

    /// Sparsity of the stiffness, with room for blocks between all nodes of each of the `cliques`
    /// (model nodes; without clamped ones).
    pub fn stiffness_pattern(&self, cliques: &[Vec<u32>]) -> StiffnessPattern {
        match &self.elements {
            ElementSet::Linear(elements) => StiffnessPattern::new(self.n_free, elements, cliques),
            ElementSet::Quadratic(elements) => StiffnessPattern::new(self.n_free, elements, cliques),
        }
    }

    /// Assembles the derivative of the internal forces at positions `x` into `stiffness`.
    pub fn stiffness_into(&self, x: &[[f64; 4]], kind: Tangent, stiffness: &mut Stiffness) {
        stiffness.blocks.fill([[0.0; 4]; 3]);
        let map = &stiffness.pattern.pairs;
        let blocks = &mut stiffness.blocks;
        match &self.elements {
            ElementSet::Linear(elements) => {
                elements::stiffness_into(self.isa, elements, &self.material, kind, x, map, blocks);
            }
            ElementSet::Quadratic(elements) => {
                elements::stiffness_into(self.isa, elements, &self.material, kind, x, map, blocks);
            }
        }
    }

    /// Values given in model order, as points in the order of the mesh file.
    pub fn in_file_order(&self, values: &[[f64; 4]]) -> Vec<[f64; 3]> {
        let point = |&model: &u32| values[model as usize];
        self.model_node.iter().map(point).map(|[x, y, z, _]| [x, y, z]).collect()
    }

    /// Fails, naming the node as in the mesh file, when an entry of `values` (model order) is not finite.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn check_finite(&self, quantity: &'static str, values: &[[f64; 4]]) -> Result<()> {
        match values.iter().position(|point| point.iter().any(|c| !c.is_finite())) {
            Some(model) => Err(Error::NotFinite { quantity, node: self.file_node[model] as usize }),
            None => Ok(()),
        }
    }
}

/// Distance from the line through the others at which a clamped node counts as off it, over the clamp's
/// length [-].
const OFF_LINE_MIN: f64 = 1e-6;

fn renumbered<const N: usize>(cells: &[[u32; N]], model_node: &[u32]) -> Vec<[u32; N]> {
    cells.iter().map(|cell| cell.map(|file| model_node[file as usize])).collect()
}

/// Elements in the order in which the body is numbered, so that neighbours in memory are neighbours in
/// space; and, where `sorted`, local nodes ascending, so that no block needs transposing.
fn in_element_order(cells: &[[u32; 4]], sorted: bool) -> Vec<[u32; 4]> {
    let mut cells = cells.to_vec();
    if sorted {
        for cell in &mut cells {
            cell.sort_unstable();
        }
    }
    cells.sort_by_key(|cell| cell.iter().copied().min());
    cells
}
