//! A chain in a file: JSON, all numbers to the last digit.

use std::path::Path;

use hysteron_base::{BadInput, file, json};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::body::{Chain, ChainPart, PartSum, ScaledBy, Sink};
use super::cubic::Cubic;
use super::errors::Validation;
use super::section::{Interface, SectionLaw, Site};
use super::{PADDED, STRAIN, Strain, WARPINGS};
use crate::Result;
use crate::body_shape::BodyShape;
use crate::model::Twin;

const FORMAT: &str = "hysteron-chain";
const VERSION: u32 = 2;
/// Most sections that are accepted.
const MAX_SECTIONS: usize = 10_000;

/// A chain in a file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ChainFile {
    format: String,
    version: u32,
    /// SHA-256 of what the body is, and of where its auxiliary tendons run.
    body_sha256: String,
    auxiliary_sha256: Option<String>,
    material: ScaledBy,
    /// Command that made it.
    command: String,
    /// Amplitudes of an interface.
    warpings: usize,
    asymmetry: f64,
    validation: Option<Validation>,
    /// Radius that rotations count with [m].
    lever: f64,
    /// Centres of the interfaces at rest [m].
    interfaces: Vec<[f64; 3]>,
    sections: Vec<SectionEntry>,
    parts: Vec<PartEntry>,
    /// Parts that carry each point of each tendon.
    points: Vec<Vec<SumEntry>>,
    tip: SumEntry,
    /// Parts that are masses.
    masses: Vec<u32>,
    /// Forces on parts [N].
    forces: Vec<(u32, [f64; 3])>,
    sinks: Vec<SinkEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SinkEntry {
    parts: Vec<u32>,
    /// Row-major [m/N].
    compliance: Vec<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SectionEntry {
    /// E V [J].
    scale: f64,
    /// Lower triangle of K by rows.
    stiffness: Vec<f64>,
    /// Coefficients of the cubic polynomial: i <= j <= k, by j, then i, then k.
    cubic: Vec<f32>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PartEntry {
    section: usize,
    /// On its end interface.
    on_end: bool,
    share: f64,
    arm: [f64; 3],
    /// Ψ by rows.
    shape: [Vec<f64>; 3],
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SumEntry {
    offset: [f64; 3],
    parts: Vec<u32>,
}

impl Chain {
    /// Writes the chain. `command` is what made it.
    ///
    /// # Errors
    /// Refusals of the file system.
    pub fn write(&self, path: &Path, command: &str) -> Result<()> {
        let content = ChainFile {
            format: FORMAT.into(),
            version: VERSION,
            body_sha256: self.shape.body.clone(),
            auxiliary_sha256: self.shape.auxiliary.clone(),
            material: self.material,
            command: command.into(),
            warpings: WARPINGS,
            asymmetry: self.asymmetry,
            validation: self.validation.clone(),
            lever: self.lever,
            interfaces: self.rest.iter().map(|interface| interface.center.into()).collect(),
            sections: self.laws.iter().map(SectionEntry::new).collect(),
            parts: self.parts.iter().map(PartEntry::new).collect(),
            points: self.points.iter().map(|points| points.iter().map(SumEntry::new).collect()).collect(),
            tip: SumEntry::new(&self.tip),
            masses: self.masses.clone(),
            forces: self.forces.clone(),
            sinks: self
                .sinks
                .iter()
                .map(|sink| SinkEntry { parts: sink.parts.clone(), compliance: sink.compliance.clone() })
                .collect(),
        };
        let text = json::to_line(&content)
            .map_err(|error| BadInput::new(path.display().to_string(), "numbers", error.to_string()))?;
        Ok(file::write_bytes(path, text + "\n")?)
    }

    /// Reads the chain of a twin: of the same body, see [`Self::of`].
    ///
    /// # Errors
    /// Another format, version or body; sizes or numbers that do not fit together.
    pub fn read(path: &Path, twin: &Twin) -> Result<Self> {
        let bad = |what: &str, expected: String, found: String| {
            BadInput::new(format!("{}: {what}", path.display()), expected, found)
        };
        let not_ours = |error: json::Error| bad("content", "a chain by hysteron".into(), error.to_string());
        let value: json::Value = json::from_text(file::read_bytes(path)?).map_err(not_ours)?;
        let (format, version) = (value["format"].as_str().unwrap_or_default(), &value["version"]);
        if format != FORMAT || *version != VERSION {
            return Err(bad("format", format!("{FORMAT} {VERSION}"), format!("{format} {version}"))
                .hint("what another version of the program wrote has to be made again")
                .into());
        }
        let content: ChainFile = json::from_value(&value).map_err(not_ours)?;
        content.check().map_err(|(what, expected, found)| bad(what, expected, found))?;
        let mut chain = content.into_chain(twin);
        chain.check(twin).map_err(|bad| bad.within(path.display().to_string()))?;
        let points =
            (twin.tendons.iter().zip(&chain.points).enumerate()).find_map(|(j, (tendon, points))| {
                let expected = twin.cables.points_of(j).len();
                (expected != points.len()).then_some((tendon, expected, points.len()))
            });
        if let Some((tendon, expected, found)) = points {
            return Err(
                bad("points", format!("{expected} of tendon {}", tendon.name), found.to_string()).into()
            );
        }
        chain.bind(twin);
        Ok(chain)
    }
}

type FileRefusal = (&'static str, String, String);

impl ChainFile {
    /// Fails where sizes or numbers do not fit together.
    fn check(&self) -> std::result::Result<(), FileRefusal> {
        let count = |what, expected: usize, found: usize| {
            if expected == found { Ok(()) } else { Err((what, expected.to_string(), found.to_string())) }
        };
        let n = self.sections.len();
        if !(2..=MAX_SECTIONS).contains(&n) {
            return Err(("sections", format!("2 to {MAX_SECTIONS}"), n.to_string()));
        }
        count("warpings", WARPINGS, self.warpings)?;
        count("interfaces", n + 1, self.interfaces.len())?;
        for section in &self.sections {
            count("sections: stiffness", STRAIN * (STRAIN + 1) / 2, section.stiffness.len())?;
            count("sections: cubic", Cubic::COEFFICIENTS, section.cubic.len())?;
        }
        for part in &self.parts {
            part.shape.iter().try_for_each(|row| count("parts: shape", STRAIN, row.len()))?;
            if part.section >= n {
                return Err(("parts: section", format!("below {n}"), part.section.to_string()));
            }
        }
        let sums = self.points.iter().flatten().chain([&self.tip]).flat_map(|sum| &sum.parts);
        let sums = sums.chain(self.sinks.iter().flat_map(|sink| &sink.parts));
        let loaded = self.masses.iter().chain(self.forces.iter().map(|force| &force.0));
        if let Some(part) = sums.chain(loaded).find(|p| **p as usize >= self.parts.len()) {
            return Err(("part", format!("below {}", self.parts.len()), part.to_string()));
        }
        for sink in &self.sinks {
            count("sinks: compliance", 9 * sink.parts.len() * sink.parts.len(), sink.compliance.len())?;
        }
        match self.numbers().find(|number| !number.is_finite()) {
            Some(number) => Err(("numbers", "finite ones".into(), number.to_string())),
            None if self.lever <= 0.0 => Err(("lever", "a length".into(), self.lever.to_string())),
            None if self.material.youngs_modulus <= 0.0 => {
                Err(("material", "a stiffness".into(), self.material.youngs_modulus.to_string()))
            }
            None => Ok(()),
        }
    }

    fn numbers(&self) -> impl Iterator<Item = f64> {
        let sections = self.sections.iter().flat_map(|section| {
            let cubic = section.cubic.iter().map(|c| f64::from(*c));
            section.stiffness.iter().copied().chain(cubic).chain([section.scale])
        });
        let parts = self
            .parts
            .iter()
            .flat_map(|part| part.shape.iter().flatten().copied().chain(part.arm).chain([part.share]));
        let offsets = self.points.iter().flatten().chain([&self.tip]).flat_map(|sum| sum.offset);
        let rest = self.interfaces.iter().copied().chain(self.forces.iter().map(|force| force.1)).flatten();
        let ScaledBy { youngs_modulus, density } = self.material;
        let single = [self.lever, self.asymmetry, youngs_modulus, density].into_iter();
        let single = single.chain(self.sinks.iter().flat_map(|sink| sink.compliance.iter().copied()));
        sections.chain(parts).chain(offsets).chain(rest).chain(single)
    }

    /// Not bound to the twin yet.
    fn into_chain(self, twin: &Twin) -> Chain {
        let centers: Vec<Vector3<f64>> = self.interfaces.into_iter().map(Vector3::from).collect();
        let at_rest = |center: &Vector3<f64>| Interface {
            center: *center,
            rotation: Matrix3::identity(),
            warping: [0.0; WARPINGS],
        };
        Chain {
            isa: twin.body.isa,
            rest: centers.iter().map(at_rest).collect(),
            laws: self
                .sections
                .iter()
                .zip(centers.windows(2))
                .map(|(section, pair)| section.law(pair[1] - pair[0]))
                .collect(),
            parts: self.parts.iter().map(PartEntry::part).collect(),
            points: self.points.iter().map(|points| points.iter().map(SumEntry::sum).collect()).collect(),
            tip: self.tip.sum(),
            masses: self.masses,
            forces: self.forces,
            sinks: self
                .sinks
                .into_iter()
                .map(|entry| Sink { parts: entry.parts, compliance: entry.compliance, cables: Vec::new() })
                .collect(),
            shape: BodyShape { body: self.body_sha256, auxiliary: self.auxiliary_sha256 },
            material: self.material,
            lever: self.lever,
            asymmetry: self.asymmetry,
            validation: self.validation,
            cables: twin.cables.clone(),
            segments: Vec::new(),
            reach: Vec::new(),
            loads: Vec::new(),
            tracker: twin.tracker,
            accuracy: twin.accuracy,
            least_force: 0.0,
        }
    }
}

impl SumEntry {
    fn new(sum: &PartSum) -> Self {
        Self { offset: sum.offset.into(), parts: sum.parts.iter().map(|(part, _)| *part).collect() }
    }

    fn sum(&self) -> PartSum {
        PartSum { offset: self.offset.into(), parts: self.parts.iter().map(|&part| (part, 1.0)).collect() }
    }
}

impl SectionEntry {
    fn new(law: &SectionLaw) -> Self {
        let lower = (0..STRAIN).flat_map(|i| law.stiffness[i][..=i].to_vec());
        Self { scale: law.scale, stiffness: lower.collect(), cubic: law.cubic.coefficients() }
    }

    fn law(&self, rest: Vector3<f64>) -> SectionLaw {
        let mut stiffness = [[0.0; PADDED]; STRAIN];
        let mut numbers = self.stiffness.iter();
        for i in 0..STRAIN {
            for (j, number) in (0..=i).zip(&mut numbers) {
                stiffness[i][j] = *number;
                stiffness[j][i] = *number;
            }
        }
        SectionLaw { rest, stiffness, cubic: Cubic::from_coefficients(&self.cubic), scale: self.scale }
    }
}

impl PartEntry {
    fn new(part: &ChainPart) -> Self {
        Self {
            section: part.site.section(),
            on_end: matches!(part.site, Site::End(_)),
            share: part.share,
            arm: part.arm.into(),
            shape: part.shape.each_ref().map(|row| row[..STRAIN].to_vec()),
        }
    }

    fn part(&self) -> ChainPart {
        let padded = |row: &Vec<f64>| {
            let mut padded: Strain = [0.0; PADDED];
            padded[..STRAIN].copy_from_slice(row);
            padded
        };
        ChainPart {
            site: if self.on_end { Site::End(self.section) } else { Site::Within(self.section) },
            share: self.share,
            arm: self.arm.into(),
            shape: self.shape.each_ref().map(padded),
        }
    }
}

#[cfg(test)]
mod tests {
    use hysteron_base::MaterialLaw;
    use hysteron_fem::Order;

    use super::*;
    use crate::chain::{Equilibrium, ValidationOptions};
    use crate::{Stepper, Target, scenes};

    fn robot() -> (Twin, Chain) {
        let (mut scene, mesh) = scenes::robot_with(MaterialLaw::Corotational, Order::Linear, 24);
        scene.gravity = [3.0, -5.0, 9.0];
        scenes::roughen(&mut scene, 1e-4);
        let twin = Twin::new(&scene, &mesh).expect("a good scene");
        let chain = Chain::new(&twin).expect("a chain");
        (twin, chain)
    }

    #[test]
    fn chain_that_was_read_makes_the_same_steps() {
        let (twin, mut chain) = robot();
        let options = ValidationOptions { count: 1, stroke: 1e-4, tension: 0.0, seed: 1 };
        let exact = Equilibrium::all(&twin, &options).expect("good targets");
        chain.validate(&twin, &options, &exact).expect("good targets");
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("chain.json");
        chain.write(&path, "test").expect("a file");
        let read = Chain::read(&path, &twin).expect("the same");
        assert_eq!(read.validation, chain.validation);
        let steps = |chain: &Chain| {
            let twin = twin.clone().with_chain(chain.clone());
            let mut stepper = Stepper::new(&twin);
            for k in 1..=3 {
                let stroke = 2e-4 * f64::from(k);
                stepper
                    .step(&twin, &[stroke, 0.0, -stroke, 0.0].map(Target::Stroke))
                    .expect("an equilibrium");
            }
            stepper.state().clone()
        };
        assert_eq!(steps(&read), steps(&chain));
        assert!(steps(&chain).tensions[0] > 0.1);
    }

    #[test]
    fn files_that_do_not_fit_are_refused() {
        let (twin, chain) = robot();
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("chain.json");
        chain.write(&path, "test").expect("a file");
        let refused = || {
            let error = Chain::read(&path, &twin).expect_err("does not fit");
            let place = error.bad_input().map(|bad| bad.place.clone()).unwrap_or_default();
            place.rsplit(": ").next().unwrap_or_default().to_owned()
        };
        let whole = std::fs::read(&path).expect("the file");
        let value: json::Value = json::from_text(&whole).expect("JSON");
        let check = |change: &dyn Fn(&mut json::Value), expected: &str| {
            let mut value = value.clone();
            change(&mut value);
            std::fs::write(&path, json::to_line(&value).expect("a line")).expect("written");
            assert_eq!(refused(), expected);
        };
        check(&|value| value["version"] = 1.into(), "format");
        check(&|value| value["body_sha256"] = "of another".into(), "body");
        check(&|value| value["points"][1] = json::Value::Array(Vec::new()), "points");
        check(&|value| value["material"]["youngs_modulus"] = 0.into(), "material");
        check(&|value| value["other"] = 2.into(), "content");
        check(&|value| value["warpings"] = 9.into(), "warpings");
        check(&|value| value["parts"][3]["section"] = 8.into(), "section");
        check(&|value| value["tip"]["parts"][0] = 1_000_000.into(), "part");
        check(&|value| value["sections"][1]["stiffness"][7] = "NaN".into(), "numbers");
        check(&|value| value["sections"][1]["cubic"] = json::Value::Array(Vec::new()), "cubic");
        check(&|value| value["lever"] = 0.into(), "lever");
        std::fs::write(&path, &whole[..whole.len() / 2]).expect("written");
        assert_eq!(refused(), "content");
    }
}
