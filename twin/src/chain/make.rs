//! A chain from the finite elements of a twin, and what a twin adds to it: cables, loads, accuracy.

use hysteron_base::BadInput;
use hysteron_fem::FemModel;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::body::{CableReach, CableSegment, Chain, ChainPart, PartSum, ScaledBy, Sink};
use super::condense::{Condensed, condense};
use super::cut::Cut;
use super::section::{Interface, Site};
use super::warping::{interfaces, rest};
use super::{PADDED, POSE, WARPINGS};
use crate::Result;
use crate::cable::Cables;
use crate::equilibrium_residual::least_force;
use crate::model::Twin;

/// Adds parts as they are asked for.
struct PartCollector<'a> {
    body: &'a FemModel,
    cut: &'a Cut,
    sections: &'a [Condensed],
    parts: Vec<ChainPart>,
    /// Nodes and weights of each.
    carriers: Vec<Vec<(u32, f64)>>,
}

impl Chain {
    /// Condenses the body of a twin.
    ///
    /// # Errors
    /// A body that cannot be cut into sections, or that nothing holds.
    pub fn new(twin: &Twin) -> Result<Self> {
        let body = &twin.body;
        let ends: Vec<[f64; 3]> = (0..twin.tendons.len())
            .flat_map(|j| {
                let line = twin.cables.polyline(j, &body.rest);
                line.first().copied().into_iter().chain(line.last().copied())
            })
            .collect();
        let cut = Cut::new(body, &ends)?;
        let interfaces = interfaces(twin, &cut)?;
        let mut sections: Vec<Condensed> = (0..cut.n_sections)
            .into_par_iter()
            .map(|e| condense(body, &cut, e, (&interfaces[e], &interfaces[e + 1])))
            .collect::<Result<_>>()?;
        let mut parts =
            PartCollector { body, cut: &cut, sections: &sections, parts: Vec::new(), carriers: Vec::new() };
        let mut known: Vec<(Vec<(u32, f64)>, PartSum)> = Vec::new();
        let mut sum = |point: usize| {
            let carriers = twin.cables.carriers(point);
            let mut sum = match known.iter().find(|(same, _)| same == carriers) {
                Some((_, sum)) => sum.clone(),
                None => {
                    let sum = parts.sum(carriers);
                    known.push((carriers.to_vec(), sum.clone()));
                    sum
                }
            };
            sum.offset += Vector3::from(twin.cables.offset(point));
            sum
        };
        let points = (0..twin.tendons.len()).map(|j| twin.cables.points_of(j).map(&mut sum).collect());
        let points: Vec<Vec<PartSum>> = points.collect();
        let n_carrying = parts.parts.len();
        let tip: Vec<(u32, f64)> =
            twin.tip.nodes.iter().copied().zip(twin.tip.weights.iter().copied()).collect();
        let tip = parts.sum(&tip);
        let masses = parts.masses();
        let forces = parts.forces(&twin.loads_besides_gravity());
        let asymmetry = sections.iter().map(|section| section.asymmetry).fold(0.0, f64::max);
        let PartCollector { parts, carriers, .. } = parts;
        let sinks = sinks(&mut sections, &parts[..n_carrying], &carriers);
        let volume: f64 = body.nodal_volumes.iter().sum();
        let length = interfaces.windows(2).map(|pair| (pair[1].center - pair[0].center).norm()).sum::<f64>();
        let at_rest = |center| Interface { center, rotation: Matrix3::identity(), warping: [0.0; WARPINGS] };
        let mut chain = Self {
            isa: body.isa,
            rest: interfaces.iter().map(|interface| at_rest(interface.center)).collect(),
            laws: sections.into_iter().map(|section| section.law).collect(),
            parts,
            points,
            tip,
            masses,
            forces,
            sinks,
            shape: twin.shape.clone(),
            material: ScaledBy::of(&body.material),
            lever: (volume / length / std::f64::consts::PI).sqrt(),
            asymmetry,
            validation: None,
            cables: twin.cables.clone(),
            segments: Vec::new(),
            reach: Vec::new(),
            loads: Vec::new(),
            tracker: twin.tracker,
            accuracy: twin.accuracy,
            least_force: least_force(twin),
        };
        chain.bind(twin);
        Ok(chain)
    }

    /// The chain of the same body in another twin: with other stiffness, density, gravity, tendon drives, friction or frame of
    /// the tracker, or without auxiliary tendons.
    ///
    /// # Errors
    /// A twin of another body.
    pub fn of(&self, twin: &Twin) -> Result<Self> {
        self.check(twin)?;
        Ok(self.bound(twin))
    }

    /// Fails where the twin is of another body.
    pub(super) fn check(&self, twin: &Twin) -> std::result::Result<(), BadInput> {
        let (own, other) = (&self.shape, &twin.shape);
        let differs = if own.body != other.body {
            Some(("body", &own.body, &other.body))
        } else {
            let layouts = own.auxiliary.as_ref().zip(other.auxiliary.as_ref());
            layouts.filter(|(a, b)| a != b).map(|(a, b)| ("auxiliary", a, b))
        };
        if let Some((place, own, other)) = differs {
            return Err(BadInput::new(place, other.as_str(), own.as_str()).hint(
                "a chain belongs to the mesh, clamp, law, Poisson's ratio, tip and ways of the tendons that it was made with; \
                 make it again",
            ));
        }
        if twin.tendons.len() > self.points.len() {
            let expected = format!("{} auxiliary tendons", twin.tendons.len() - twin.n_primary);
            return Err(BadInput::new("auxiliary", expected, "a chain that was made without them")
                .hint("make it again from the scene that has them"));
        }
        Ok(())
    }

    /// This chain with everything that the twin adds.
    pub(crate) fn bound(&self, twin: &Twin) -> Self {
        let mut bound = self.clone();
        bound.bind(twin);
        bound
    }

    /// Takes over everything that the twin adds.
    pub(super) fn bind(&mut self, twin: &Twin) {
        let ScaledBy { youngs_modulus, density } = self.material;
        let stiffer = twin.body.material.youngs_modulus / youngs_modulus;
        if stiffer != 1.0 {
            self.laws.iter_mut().for_each(|law| law.scale_by(stiffer));
            let compliances = self.sinks.iter_mut().flat_map(|sink| &mut sink.compliance);
            compliances.for_each(|compliance| *compliance /= stiffer);
        }
        let denser = if density > 0.0 { twin.body.material.density / density } else { 0.0 };
        let mut loads = self.forces.clone();
        if twin.gravity != [0.0; 3] {
            loads.extend(self.masses.iter().map(|&part| (part, twin.gravity.map(|g| denser * g))));
        }
        let along = twin.friction.iter().flat_map(|point| &self.points[point.tendon][point.first..]);
        let mut points = self.points[..twin.tendons.len()].iter().flatten().chain(along);
        self.cables = twin.cables.carried_by(|offset, carriers| match points.next() {
            Some(sum) => (sum.offset.into(), sum.parts.clone()),
            None => (offset, carriers.to_vec()),
        });
        self.material.youngs_modulus = twin.body.material.youngs_modulus;
        self.segments = segments(&self.cables);
        self.reach = (0..self.cables.len()).map(|j| self.reach(j)).collect();
        self.connect_sinks();
        (self.loads, self.tracker) = (loads, twin.tracker);
        (self.accuracy, self.least_force) = (twin.accuracy, least_force(twin));
    }

    /// The parts and interfaces that cable `j` pulls at.
    fn reach(&self, j: usize) -> CableReach {
        let carriers = self.cables.points_of(j).flat_map(|point| self.cables.carriers(point));
        let mut parts: Vec<u32> = carriers.map(|(part, _)| *part).collect();
        parts.sort_unstable();
        parts.dedup();
        let sites = parts.iter().map(|part| self.parts[*part as usize].site);
        let (first, last) = sites.fold((self.n_sections(), 0), |(first, last), site| {
            (first.min(site.first().saturating_sub(1)), last.max(site.section() + 1))
        });
        CableReach { parts, blocks: first.min(last)..last, sinks: Vec::new() }
    }

    /// Finds which cables pull at parts within sections.
    fn connect_sinks(&mut self) {
        let mut start = 0;
        for (s, sink) in self.sinks.iter_mut().enumerate() {
            sink.cables.clear();
            for (j, reach) in self.reach.iter_mut().enumerate() {
                if sink.parts.iter().any(|part| reach.parts.binary_search(part).is_ok()) {
                    sink.cables.push((j, start));
                    reach.sinks.push((s, start));
                    start += 3 * sink.parts.len();
                }
            }
        }
    }
}

impl PartCollector<'_> {
    /// The sum of nodes with weights.
    fn sum(&mut self, carriers: &[(u32, f64)]) -> PartSum {
        let mut sum = PartSum::default();
        let mut groups: Vec<(Site, Vec<(u32, f64)>)> = Vec::new();
        for &(node, weight) in carriers {
            match self.cut.site(node) {
                None => sum.offset += weight * rest(self.body, node),
                Some(site) => match groups.iter_mut().find(|(known, _)| *known == site) {
                    Some((_, group)) => group.push((node, weight)),
                    None => groups.push((site, vec![(node, weight)])),
                },
            }
        }
        sum.parts = groups.iter().map(|(site, group)| (self.add(*site, group), 1.0)).collect();
        sum
    }

    /// One part; its number.
    fn add(&mut self, site: Site, carriers: &[(u32, f64)]) -> u32 {
        let section = &self.sections[site.section()];
        let (center, rigid) = match site {
            Site::End(_) => (section.end, POSE + WARPINGS),
            Site::Within(_) => (section.center, 0),
        };
        let mut part = ChainPart { site, share: 0.0, arm: Vector3::zeros(), shape: [[0.0; PADDED]; 3] };
        for &(node, weight) in carriers {
            // Nodes of a section are few: a linear search.
            let Some(i) = section.nodes.iter().position(|&own| own == node) else { continue };
            part.share += weight;
            part.arm += weight * (rest(self.body, node) - center);
            for c in 0..3 {
                for (sum, shape) in part.shape[c].iter_mut().zip(&section.shapes[i][c]).skip(rigid) {
                    *sum += weight * shape;
                }
            }
        }
        self.parts.push(part);
        self.carriers.push(carriers.to_vec());
        self.parts.len() as u32 - 1
    }

    /// The masses of all nodes [kg], a part for each site.
    fn masses(&mut self) -> Vec<u32> {
        let mass = self.body.weight([1.0, 0.0, 0.0]);
        self.on_sites(|node| mass[node as usize][0])
    }

    /// Constant nodal forces [N] as forces of one newton on parts, one per site and axis.
    fn forces(&mut self, nodal: &[[f64; 4]]) -> Vec<(u32, [f64; 3])> {
        (0..3)
            .flat_map(|c| {
                let unit = [0, 1, 2].map(|axis| f64::from(u8::from(axis == c)));
                self.on_sites(|node| nodal[node as usize][c]).into_iter().map(move |part| (part, unit))
            })
            .collect()
    }

    /// A part with these weights of the free nodes for each site that has some.
    fn on_sites(&mut self, weight: impl Fn(u32) -> f64) -> Vec<u32> {
        let mut by_site = vec![Vec::new(); 2 * self.sections.len()];
        for node in (0..self.body.n_free as u32).filter(|node| weight(*node) != 0.0) {
            if let Some(site) = self.cut.site(node) {
                by_site[2 * site.section() + usize::from(matches!(site, Site::End(_)))]
                    .push((node, weight(node)));
            }
        }
        let sites = (0..self.sections.len()).flat_map(|e| [Site::Within(e), Site::End(e)]);
        let loaded = sites.zip(by_site).filter(|(_, own)| !own.is_empty());
        loaded.map(|(site, own)| self.add(site, &own)).collect()
    }
}

/// Local compliance of every section that has parts within it.
fn sinks(sections: &mut [Condensed], parts: &[ChainPart], carriers: &[Vec<(u32, f64)>]) -> Vec<Sink> {
    let mut sinks = Vec::new();
    for (e, section) in sections.iter_mut().enumerate() {
        let within = (0..parts.len()).filter(|&p| parts[p].site == Site::Within(e));
        let own: Vec<u32> = within.map(|p| p as u32).collect();
        if !own.is_empty() {
            let sums: Vec<&[(u32, f64)]> = own.iter().map(|&p| &carriers[p as usize][..]).collect();
            let compliance = section.local_compliance(&sums);
            sinks.push(Sink { compliance, parts: own, cables: Vec::new() });
        }
    }
    sinks
}

/// The distinct segments of all cables: those of friction run along their tendons.
pub(super) fn segments(cables: &Cables) -> Vec<CableSegment> {
    let mut segments: Vec<CableSegment> = Vec::new();
    for j in 0..cables.len() {
        for p in cables.points_of(j).skip(1).map(|next| next - 1) {
            match segments.iter_mut().find(|known| cables.is_same_segment(known.first, p)) {
                Some(known) => known.cables.push(j),
                None => segments.push(CableSegment { first: p, cables: vec![j] }),
            }
        }
    }
    segments
}
