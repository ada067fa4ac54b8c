//! The manifest of a set: everything that its shards follow from.

use hysteron_base::{BadInput, file, json};
use serde::{Deserialize, Serialize};

use super::rule::ShardRule;
use crate::COMMIT;
use crate::shared::object_store::{PutOutcome, Store};

/// Name of its object.
pub(super) const MANIFEST: &str = "manifest.json";
/// Format of the file.
pub(super) const FORMAT: &str = "hysteron-shards";
/// Its version.
pub(super) const VERSION: u32 = 1;
/// Version of this program.
pub(super) const PROGRAM: &str = env!("CARGO_PKG_VERSION");

/// A file that workers read, stored by its hash.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InputFile {
    /// Its name, relative to the scene's folder.
    pub name: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

impl InputFile {
    /// The object that holds its bytes.
    pub fn object(&self) -> String {
        format!("inputs/{}", self.sha256)
    }
}

/// The manifest: the program, the inputs, and the rule of the shards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Manifest {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub version: u32,
    /// Version of the program, [`PROGRAM`].
    pub program: String,
    /// Commit of the program.
    pub commit: String,
    /// The command that planned the set; recordings name it as their origin.
    pub command: String,
    /// Name of the robot.
    pub robot: String,
    /// SHA-256 of scene, mesh and chain, see [`hysteron_base::Scene::hash`].
    pub scene_sha256: String,
    /// Name of the plan.
    pub plan_name: String,
    /// Seed of the plan.
    pub seed: u64,
    /// Samples of the plan.
    pub samples: u64,
    /// The plan file.
    pub plan: InputFile,
    /// The scene file.
    pub scene: InputFile,
    /// Its mesh.
    pub mesh: InputFile,
    /// The chain that moves in place of the mesh, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reduced: Option<InputFile>,
    /// The checkpoint of the residual network, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual: Option<InputFile>,
    /// Which trajectories each shard has.
    pub rule: ShardRule,
    /// Side of the cells in which sketches count the tip's positions [m].
    pub cell_m: f64,
}

/// A manifest as it is stored.
#[derive(Debug, Clone)]
pub(super) struct SetManifest {
    /// Its content.
    pub content: Manifest,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

impl Manifest {
    /// All files that workers read.
    pub fn inputs(&self) -> impl Iterator<Item = &InputFile> {
        [&self.plan, &self.scene, &self.mesh].into_iter().chain(&self.reduced).chain(&self.residual)
    }

    /// The first key of which another manifest has another value; the command is not compared, which may be typed in many ways.
    fn difference(&self, other: &Self) -> Option<[String; 3]> {
        let values = |one: &Self| {
            let file =
                |file: &Option<InputFile>| file.as_ref().map_or("none".to_owned(), |f| f.sha256.clone());
            [
                ("program", format!("{} ({})", one.program, one.commit)),
                ("plan.sha256", one.plan.sha256.clone()),
                ("seed", one.seed.to_string()),
                ("mesh.sha256", one.mesh.sha256.clone()),
                ("reduced.sha256", file(&one.reduced)),
                ("scene_sha256", one.scene_sha256.clone()),
                ("scene.sha256", one.scene.sha256.clone()),
                ("residual.sha256", file(&one.residual)),
                ("rule.trajectories", one.rule.trajectories.to_string()),
                ("rule.shards", one.rule.shards.to_string()),
            ]
        };
        let pairs = values(self).into_iter().zip(values(other));
        pairs
            .into_iter()
            .find(|(own, others)| own != others)
            .map(|((key, own), (_, others))| [key.to_owned(), own, others])
    }
}

impl SetManifest {
    /// Stores a manifest; one with the same content may be there already, and then stays.
    ///
    /// # Errors
    /// `BadInput` naming the key of which the manifest that is there has another value; those of the store.
    pub fn publish(store: &Store, new: &Manifest) -> anyhow::Result<(Self, PutOutcome)> {
        let put = store.put_new(MANIFEST, json::to_text(new)?.into_bytes())?;
        let there = Self::read(store)?;
        if let Some([key, expected, found]) = there.content.difference(new) {
            let expected = format!("{expected}, as the set that is there");
            return Err(BadInput::new(format!("{}: {key}", store.place(MANIFEST)), expected, found)
                .hint("a set has one plan: name another place with --to")
                .into());
        }
        Ok((there, put))
    }

    /// Reads the manifest of a set.
    ///
    /// # Errors
    /// `BadInput` where there is none, or of another version; those of the store.
    pub fn read(store: &Store) -> anyhow::Result<Self> {
        let place = store.place(MANIFEST);
        let Some(bytes) = store.get(MANIFEST)? else {
            return Err(BadInput::new(place, "the manifest of a set of shards", "nothing there")
                .hint("`hysteron shards plan` writes it; check the URL")
                .into());
        };
        let content: Manifest =
            json::from_text(&bytes).map_err(|error| BadInput::new(&place, FORMAT, error.to_string()))?;
        if (&*content.format, content.version) != (FORMAT, VERSION) {
            let found = format!("{} {}", content.format, content.version);
            return Err(BadInput::new(place, format!("{FORMAT} {VERSION}"), found)
                .hint("use the program that planned the set")
                .into());
        }
        let ShardRule { trajectories, shards } = content.rule;
        if !(1..=trajectories).contains(&shards) {
            let expected = format!("1 to {trajectories}, the number of trajectories");
            return Err(BadInput::new(format!("{place}: rule.shards"), expected, shards.to_string()).into());
        }
        Ok(Self { content, sha256: file::sha256_hex(&bytes) })
    }

    /// Accepts this program as a worker: another version may give other rows.
    ///
    /// # Errors
    /// `BadInput` naming both versions.
    pub fn check_program(&self, store: &Store) -> Result<(), BadInput> {
        let named = |version: &str, commit: &str| format!("hysteron {version}, commit {commit}");
        let expected = named(&self.content.program, &self.content.commit);
        let found = named(PROGRAM, COMMIT);
        if expected == found {
            return Ok(());
        }
        Err(BadInput::new(format!("{}: program", store.place(MANIFEST)), expected, found)
            .hint("work with the program that planned the set, or plan it again in another place"))
    }

    /// Refuses to go on where the manifest of the set is no longer this one.
    ///
    /// # Errors
    /// `BadInput` naming both hashes; those of the store.
    pub fn check_unchanged(&self, store: &Store) -> anyhow::Result<()> {
        let now = Self::read(store)?.sha256;
        if now == self.sha256 {
            return Ok(());
        }
        let expected = format!("{}, as when this worker began", self.sha256);
        Err(BadInput::new(format!("{}: SHA-256", store.place(MANIFEST)), expected, now)
            .hint("a manifest is never changed: bring the first one back, or plan again in another place")
            .into())
    }
}
