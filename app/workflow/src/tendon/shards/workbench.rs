//! The workbench of a worker: the inputs of the set on its own disk, and the twin that they make.

use std::path::{Component, Path, PathBuf};

use hysteron_base::{BadInput, Metadata, Recording, Scene, TrajectoryShard, file, parallel};
use hysteron_control::{LazyPlan, Trajectory};
use hysteron_twin::Twin;
use hysteron_twin::synthetic::SyntheticOutcome;
use tempfile::TempDir;

use super::manifest::{InputFile, MANIFEST, SetManifest};
use super::rule::{rows_name, sketch_name};
use super::sketch::{DataSketch, ShardSketch};
use crate::COMMIT;
use crate::shared::memory;
use crate::shared::network::Network;
use crate::shared::object_store::{PutOutcome, Store};
use crate::tendon::generate::{TrajectorySimulator, reason};

/// The twin of a set, its plan and its manifest.
pub(super) struct Workbench {
    pub manifest: SetManifest,
    plan: LazyPlan,
    scene: Scene,
    twin: Twin,
    network: Option<Network>,
    folder: TempDir,
}

/// A shard in memory.
pub(super) struct BuiltShard {
    shard: usize,
    rows: Vec<u8>,
    sketch: ShardSketch,
    /// Names and families of trajectories that were skipped, and why.
    skipped: Vec<SkippedTrajectory>,
}

/// A trajectory that the twin cannot follow.
struct SkippedTrajectory {
    family: String,
    name: String,
    why: String,
}

/// A trajectory that was simulated.
enum SimulatedTrajectory {
    Made(u64, String, Recording),
    Skipped(SkippedTrajectory),
    Ended,
}

impl BuiltShard {
    /// Samples in it.
    pub fn n_samples(&self) -> u64 {
        self.sketch.data.samples()
    }
}

impl Workbench {
    /// Reads the manifest and the inputs of a set, and refuses what does not fit.
    ///
    /// # Errors
    /// `BadInput` for another program, or an input that is missing, damaged or not that of the manifest; those of the store.
    pub fn fetch(store: &Store) -> anyhow::Result<Self> {
        let manifest = SetManifest::read(store)?;
        manifest.check_program(store)?;
        let content = &manifest.content;
        let folder = tempfile::tempdir()?;
        let inputs = FetchedInputs { store, folder: folder.path() };
        let scene = inputs.scene(&manifest)?;
        let twin = Twin::from_scene(&scene)?;
        let residual = inputs.part(content.residual.as_ref(), "residual.safetensors")?;
        let network = residual.map(|path| Network::read(&path, &scene, &twin)).transpose()?;
        let text = file::read_text(&inputs.stored_at(&content.plan, folder.path().join("plan.toml"))?)?;
        let plan = LazyPlan::from_toml(&text, &store.place(&content.plan.object()))?;
        let (n, m) = (plan.n_trajectories(), content.rule.trajectories);
        if n != m {
            return Err(differs(store, "rule.trajectories", &n.to_string(), &m.to_string()).into());
        }
        Ok(Self { plan, scene, twin, network, folder, manifest })
    }

    fn simulator(&self) -> TrajectorySimulator<'_> {
        TrajectorySimulator {
            scene: &self.scene,
            twin: &self.twin,
            network: self.network.as_ref(),
            limits: self.plan.limits(),
            command: &self.manifest.content.command,
        }
    }

    /// Builds a shard in memory, its trajectories on all threads; `None` where `go_on`, which is called after each sample, has
    /// returned false.
    ///
    /// # Errors
    /// Those of the twin but for trajectories that it cannot follow, which are skipped.
    pub fn build(
        &self,
        shard: usize,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> anyhow::Result<Option<BuiltShard>> {
        let range = self.manifest.content.rule.range(shard);
        let trajectories =
            range.map(|k| Ok((k as u64, self.plan.trajectory(k)?))).collect::<anyhow::Result<Vec<_>>>()?;
        let n_rows = trajectories.iter().map(|(_, one)| one.n_samples()).sum();
        memory::check_result(Path::new("shard"), n_rows, 5 + 5 * self.twin.n_primary)?;
        let simulate = |(number, one): &(u64, Trajectory)| self.simulate(*number, one, go_on);
        let (mut parts, mut families, mut skipped) = (Vec::new(), Vec::new(), Vec::new());
        for simulated in parallel::try_map(&trajectories, simulate)? {
            match simulated {
                SimulatedTrajectory::Made(number, family, recording) => {
                    parts.push((number, recording));
                    families.push(family);
                }
                SimulatedTrajectory::Skipped(one) => skipped.push(one),
                SimulatedTrajectory::Ended => return Ok(None),
            }
        }
        let rows = TrajectoryShard::new(self.shared_metadata(), parts)?;
        let bytes = rows.to_bytes()?;
        let sketch = self.sketch(shard, (&rows, &bytes), &skipped)?;
        Ok(Some(BuiltShard { shard, rows: bytes, sketch, skipped }))
    }

    fn simulate(
        &self,
        number: u64,
        trajectory: &Trajectory,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> anyhow::Result<SimulatedTrajectory> {
        let family = trajectory.motion.family.name().to_owned();
        Ok(match self.simulator().run(trajectory, &mut || go_on())? {
            SyntheticOutcome::Ended => SimulatedTrajectory::Ended,
            SyntheticOutcome::Made(recording) => SimulatedTrajectory::Made(number, family, recording),
            SyntheticOutcome::Dropped(sample, why) => {
                let why = reason(trajectory, sample, &why);
                tracing::warn!("{}: skipped: {why}", trajectory.name);
                SimulatedTrajectory::Skipped(SkippedTrajectory { family, name: trajectory.name.clone(), why })
            }
        })
    }

    /// The metadata of all trajectories.
    fn shared_metadata(&self) -> Metadata {
        let content = &self.manifest.content;
        Metadata {
            scene_hash: self.scene.hash.clone(),
            seed: Some(content.seed),
            commit: COMMIT.to_owned(),
            source: format!("twin {}, plan {}", self.scene.name, content.plan_name),
            command: content.command.clone(),
            extra: [("plan.sha256".to_owned(), content.plan.sha256.clone())].into(),
        }
    }

    /// The sketch of the rows of a shard.
    fn sketch(
        &self,
        shard: usize,
        (rows, bytes): (&TrajectoryShard, &[u8]),
        skipped: &[SkippedTrajectory],
    ) -> anyhow::Result<ShardSketch> {
        let mut data = DataSketch::default();
        let family =
            |recording: &Recording| recording.meta().extra.get("plan.family").cloned().unwrap_or_default();
        let recordings: Vec<(String, &Recording)> =
            rows.parts().iter().map(|(_, one)| (family(one), one)).collect();
        data.add(&recordings, self.manifest.content.cell_m)?;
        skipped.iter().for_each(|one| data.skip(&one.family, &one.name, &one.why));
        Ok(ShardSketch::new(shard, self.manifest.sha256.clone(), bytes, data))
    }

    /// Stores a shard: its rows, and then its sketch, with which it is done.
    ///
    /// # Errors
    /// `BadInput` where the manifest was changed meanwhile; those of the store.
    pub fn store(&self, store: &Store, built: BuiltShard) -> anyhow::Result<PutOutcome> {
        self.manifest.check_unchanged(store)?;
        let BuiltShard { shard, rows, sketch, skipped } = built;
        let name = rows_name(shard);
        let put = store.put_new(&name, rows)?;
        let sketch = match put {
            PutOutcome::Written => sketch,
            // Another processor may round otherwise: the sketch is that of the rows that are there.
            PutOutcome::AlreadyThere => {
                let path = self.folder.path().join("stored.parquet");
                let bytes = store.get(&name)?.unwrap_or_default();
                match file::sha256_hex(&bytes) == sketch.rows_sha256 {
                    true => sketch,
                    false => {
                        file::write_bytes(&path, &bytes)?;
                        let there = TrajectoryShard::read(&path)?;
                        self.sketch(shard, (&there, &bytes), &skipped)?
                    }
                }
            }
        };
        store.put_new(&sketch_name(shard), sketch.to_bytes()?)?;
        Ok(put)
    }
}

/// Inputs of a set that are read into a folder.
struct FetchedInputs<'a> {
    store: &'a Store,
    folder: &'a Path,
}

impl FetchedInputs<'_> {
    /// The scene, with mesh and chain next to it.
    fn scene(&self, manifest: &SetManifest) -> anyhow::Result<Scene> {
        let content = &manifest.content;
        // As deep as the mesh's name leads upwards, so that it stays within the folder.
        let ups = check_relative(&content.mesh.name).map_err(|bad| bad.within(self.store.place(MANIFEST)))?;
        let folder = self.folder.join("scene/".repeat(ups + 1));
        std::fs::create_dir_all(&folder)?;
        self.stored_at(&content.mesh, folder.join(&content.mesh.name))?;
        let path = self.stored_at(&content.scene, folder.join("scene.toml"))?;
        let scene = Scene::read_with(&path, self.part(content.reduced.as_ref(), "reduced.json")?)?;
        match scene.hash == content.scene_sha256 {
            true => Ok(scene),
            false => Err(differs(self.store, "scene_sha256", &scene.hash, &content.scene_sha256).into()),
        }
    }

    /// The file of an input that a set may be without.
    fn part(&self, input: Option<&InputFile>, name: &str) -> anyhow::Result<Option<PathBuf>> {
        input.map(|input| self.stored_at(input, self.folder.join(name))).transpose()
    }

    /// The file of an input, whose bytes are those that the set was planned with.
    fn stored_at(&self, input: &InputFile, path: PathBuf) -> anyhow::Result<PathBuf> {
        let place = self.store.place(&input.object());
        let Some(bytes) = self.store.get(&input.object())? else {
            let bad = BadInput::new(place, format!("the input {}", input.name), "nothing there");
            return Err(bad.hint("run the command of `hysteron shards plan` again").into());
        };
        let found = file::sha256_hex(&bytes);
        if found != input.sha256 {
            let expected = format!("the input {} with the SHA-256 of its name", input.name);
            let bad = BadInput::new(place, expected, found);
            return Err(bad.hint("it was changed: delete it and plan again").into());
        }
        file::write_bytes(&path, bytes)?;
        Ok(path)
    }
}

/// A value of the manifest that is not that of its inputs.
fn differs(store: &Store, key: &str, expected: &str, found: &str) -> BadInput {
    BadInput::new(format!("{}: {key}", store.place(MANIFEST)), expected, found)
        .hint("the manifest does not belong to these inputs: plan again in another place")
}

/// By how many folders a path leads upwards; one that does not begin at the scene's folder is refused.
pub(super) fn check_relative(name: &str) -> Result<usize, BadInput> {
    let path = Path::new(name);
    if path.is_absolute() || path.file_name().is_none() {
        return Err(BadInput::new("mesh.file", "a path relative to the scene", name)
            .hint("workers on other machines have no other folders: put the mesh next to the scene"));
    }
    Ok(path.components().filter(|part| *part == Component::ParentDir).count())
}
