//! The public sets.

use std::path::Path;

use hysteron_base::{BadInput, Error, Result, Table as NumericTable, file};

use super::filter::{check_rate, differentiate, low_pass};
use super::table::TextTable;
use crate::lagrangian::{ArmSamples, Decomposition};
use hysteron_arm_dynamics::Model;

/// A set with its published split, and the arm's kinematics.
#[derive(Debug, Clone, PartialEq)]
pub struct RealSet {
    /// Name in tables.
    pub name: String,
    /// Trajectories to learn from, validation data included.
    pub training: ArmSamples,
    /// Trajectories that are never chosen by.
    pub test: ArmSamples,
    /// Cut-off of the low-pass filter of the velocities that were differentiated, or of all channels [Hz].
    pub cutoff: f64,
}

const BAXTER_JOINTS: [&str; 7] = ["s0", "s1", "e0", "e1", "w0", "w1", "w2"];
const BAXTER_RATE: f64 = 100.0;
const BAXTER_CUTOFF: f64 = 10.0;

/// A recording of positions, velocities and torques, [sample][joint], at a constant rate [Hz].
struct DatasetRecording<'a> {
    q: &'a [f64],
    dq: &'a [f64],
    tau: &'a [f64],
    rate: f64,
}

/// Column by column.
fn by_joint(
    values: &[f64],
    n: usize,
    mut each: impl FnMut(&[f64]) -> std::result::Result<Vec<f64>, BadInput>,
) -> std::result::Result<Vec<f64>, BadInput> {
    let mut found = vec![0.0; values.len()];
    for j in 0..n {
        let column: Vec<f64> = values.iter().skip(j).step_by(n).copied().collect();
        let column = each(&column).map_err(|bad| bad.within(format!("joint {}", j + 1)))?;
        found.iter_mut().skip(j).step_by(n).zip(column).for_each(|(to, v)| *to = v);
    }
    Ok(found)
}

/// Adds a trajectory whose accelerations are differences of low-passed velocities; the velocities stay as they are.
fn push_differentiated(
    samples: &mut ArmSamples,
    recorded: &DatasetRecording<'_>,
    cutoff: f64,
) -> std::result::Result<(), BadInput> {
    let n = samples.n_joints;
    check_rate([recorded.q, recorded.dq], n, recorded.rate)?;
    let times: Vec<f64> = (0..recorded.q.len() / n).map(|i| i as f64 / recorded.rate).collect();
    let ddq =
        by_joint(recorded.dq, n, |dq| Ok(differentiate(&low_pass(dq, cutoff, recorded.rate)?, &times)))?;
    samples.push([recorded.q, recorded.dq, &ddq, recorded.tau], [&[], &[]])
}

/// Names in a folder, in alphabetical order.
fn names_in(folder: &Path) -> Result<Vec<String>> {
    let refused = |e| Error::io(folder, e);
    let entries = std::fs::read_dir(folder).map_err(refused)?;
    let names: std::io::Result<Vec<String>> =
        entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect();
    let mut names = names.map_err(refused)?;
    names.sort();
    Ok(names)
}

/// Training set of Baxter's models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaxterTraining {
    /// The eleven helical files: table 3.
    Helical,
    /// The random one too: table 4, without the spiral file, which is not public.
    All,
}

/// Baxter's left arm. `test` is one file of `test/`.
///
/// # Errors
/// A file that is missing or not as expected, naming it.
pub fn baxter(folder: &Path, test: &str, training: BaxterTraining) -> Result<RealSet> {
    let mut names = names_in(&folder.join("train"))?;
    names.retain(|name| name.ends_with(".csv"));
    if training == BaxterTraining::Helical {
        names.retain(|name| name.starts_with("sin"));
    }
    let read = |samples: &mut ArmSamples, path: &Path| -> Result<()> {
        let table = TextTable::read(path, ' ')?;
        let columns = |what: &str| table.columns(&BAXTER_JOINTS.map(|joint| format!("{what}_left_{joint}")));
        let [q, dq, tau] = [columns("ang")?, columns("vel")?, columns("torq")?];
        let recorded = DatasetRecording { q: &q, dq: &dq, tau: &tau, rate: BAXTER_RATE };
        Ok(push_differentiated(samples, &recorded, BAXTER_CUTOFF)
            .map_err(|bad| bad.within(path.display()))?)
    };
    let (mut training, mut test_set) = (ArmSamples::new(7), ArmSamples::new(7));
    for name in &names {
        read(&mut training, &folder.join("train").join(name))?;
    }
    read(&mut test_set, &folder.join("test").join(test))?;
    let name = format!("Baxter, {}", test.split("_ang").next().unwrap_or(test));
    Ok(RealSet { name, training, test: test_set, cutoff: BAXTER_CUTOFF })
}

const KUKA_CUTOFF: f64 = 10.0;

/// KUKA LWR4+: learns from the first run, in blocks, and is tested on the second. All channels are low-passed alike.
///
/// # Errors
/// A file that is missing or not as expected, naming it.
pub fn kuka(folder: &Path) -> Result<RealSet> {
    let read = |name: &str| -> Result<ArmSamples> {
        let path = folder.join(name);
        let within = |bad: BadInput| bad.within(path.display());
        let table = NumericTable::read(&path, None)?;
        let column = |name: &str| {
            let missing = || BadInput::new(name, "an array", table.names());
            table.index(name).map(|k| &table.columns()[k].values[..]).ok_or_else(missing)
        };
        let get = |name: &str| -> std::result::Result<Vec<f64>, BadInput> {
            let columns: Vec<&[f64]> =
                (1..=7).map(|k| column(&format!("{name}[{k}]"))).collect::<std::result::Result<_, _>>()?;
            Ok((0..table.n_rows()).flat_map(|i| columns.iter().map(move |values| values[i])).collect())
        };
        let times = check_times(column("times").map_err(within)?).map_err(within)?;
        let rate = (times.len() - 1) as f64 / (times[times.len() - 1] - times[0]);
        let channels = ["positions", "velocities", "torques"].map(get);
        let mut filtered = Vec::new();
        for channel in channels {
            let values = channel.map_err(within)?;
            filtered.push(by_joint(&values, 7, |x| low_pass(x, KUKA_CUTOFF, rate)).map_err(within)?);
        }
        let ddq = by_joint(&filtered[1], 7, |x| Ok(differentiate(x, times))).map_err(within)?;
        blocks(7, [&filtered[0], &filtered[1], &ddq, &filtered[2]]).map_err(|bad| within(bad).into())
    };
    let (training, test) = (read("measurements_1.npz")?, read("measurements_2.npz")?);
    Ok(RealSet { name: "KUKA LWR4+, second run".to_owned(), training, test, cutoff: KUKA_CUTOFF })
}

/// The arm of [`kuka`]: the identified robot that comes with the recordings, whose friction, below zero in four joints, is left out. Of
/// the other two files one gives a joint two origins, one a link a body that cannot exist.
///
/// # Errors
/// A file that is missing or not as expected, naming it.
pub fn kuka_arm(folder: &Path) -> Result<Model> {
    let path = folder.join("kuka_lwr4_identified.urdf");
    let text = file::read_text(&path)?;
    let lines: Vec<&str> = text.lines().filter(|line| !line.contains("<dynamics")).collect();
    Ok(Model::from_urdf(&lines.join("\n"), &path.display().to_string())?)
}

const PANDA_CUTOFF: f64 = 8.0;
/// Every so many samples of 1 kHz are kept after the filter.
const PANDA_STRIDE: usize = 5;
/// Part of the recording that is learned from.
const PANDA_TRAINING: f64 = 0.7;

/// Franka Panda: one exciting trajectory; learns from the first 70 %, in blocks, and is tested on the rest. All channels
/// are low-passed alike.
///
/// # Errors
/// A file that is missing or not as expected, naming it.
pub fn panda(folder: &Path) -> Result<RealSet> {
    let read = |name: &str| -> Result<Vec<f64>> {
        let path = folder.join(format!("exciting_traj_{name}.txt"));
        let text = file::read_text(&path)?;
        let numbers =
            text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).map(|(i, line)| {
                let number = line.trim().parse::<f64>().ok().filter(|v| v.is_finite());
                let place = format!("{}: line {}", path.display(), i + 1);
                number.ok_or_else(|| BadInput::new(place, "a finite number", line.trim()))
            });
        Ok(numbers.collect::<std::result::Result<_, _>>()?)
    };
    let times = read("time")?;
    let times = check_times(&times)?;
    let rate = (times.len() - 1) as f64 / (times[times.len() - 1] - times[0]);
    let mut channels = Vec::new();
    for name in ["positions", "velocity", "torques"] {
        let values = read(name)?;
        if values.len() != 7 * times.len() {
            let expected = format!("7 joints at {} times", times.len());
            return Err(BadInput::new(name, expected, format!("{} numbers", values.len())).into());
        }
        channels.push(by_joint(&values, 7, |x| low_pass(x, PANDA_CUTOFF, rate))?);
    }
    let ddq = by_joint(&channels[1], 7, |x| Ok(differentiate(x, times)))?;
    let decimated = |values: &[f64], rows: std::ops::Range<usize>| -> Vec<f64> {
        rows.step_by(PANDA_STRIDE).flat_map(|row| values[7 * row..7 * row + 7].to_vec()).collect()
    };
    let border = (PANDA_TRAINING * times.len() as f64) as usize;
    let part = |rows: std::ops::Range<usize>| {
        let arrays =
            [&channels[0], &channels[1], &ddq, &channels[2]].map(|values| decimated(values, rows.clone()));
        blocks(7, [&arrays[0], &arrays[1], &arrays[2], &arrays[3]])
    };
    let (training, test) = (part(0..border)?, part(border..times.len())?);
    Ok(RealSet { name: "Panda, last 30 %".to_owned(), training, test, cutoff: PANDA_CUTOFF })
}

/// Blocks of a single recording that count as trajectories.
const BLOCKS: usize = 8;

/// A recording in blocks of time.
fn blocks(n: usize, motion: [&[f64]; 4]) -> std::result::Result<ArmSamples, BadInput> {
    let rows = motion[0].len() / n;
    let mut samples = ArmSamples::new(n);
    for b in 0..BLOCKS {
        let part = n * (b * rows / BLOCKS)..n * ((b + 1) * rows / BLOCKS);
        samples.push(motion.map(|values| values.get(part.clone()).unwrap_or_default()), [&[], &[]])?;
    }
    Ok(samples)
}

/// # Errors
/// `BadInput` naming the first sample that is not later than the one before.
fn check_times(times: &[f64]) -> std::result::Result<&[f64], BadInput> {
    if times.len() < 2 {
        return Err(BadInput::new("time", "two samples or more", times.len().to_string()));
    }
    match times.windows(2).position(|pair| pair[1] <= pair[0] || !(pair[1] - pair[0]).is_finite()) {
        Some(i) => {
            let expected = format!("a time after {} s", times[i]);
            Err(BadInput::new(format!("time: sample {}", i + 2), expected, format!("{} s", times[i + 1])))
        }
        None => Ok(times),
    }
}

/// Lutter's simulated two-joint arm that writes characters, with the true parts of its torques: training and test (`e`, `q`,
/// `v`).
///
/// # Errors
/// A file that is missing or not as expected, naming it.
/// # Reference
/// Lutter, Ritter, Peters (2019), Deep Lagrangian networks; the data are those of their published code.
pub fn characters(file: &Path) -> Result<[(ArmSamples, Decomposition); 2]> {
    let table = TextTable::read(file, ',')?;
    let columns = |name: &str, unit: &str| table.columns(&[1, 2].map(|j| format!("{name}_{j}_{unit}")));
    let motion =
        [columns("q", "rad")?, columns("dq", "rad_s")?, columns("ddq", "rad_s2")?, columns("tau", "nm")?];
    let momenta = [columns("p", "kg_m2_s")?, columns("pdot", "nm")?];
    let parts = [columns("inertial", "nm")?, columns("coriolis", "nm")?, columns("gravity", "nm")?];
    let labels = table.texts("label")?;
    let mut sets = [(); 2].map(|()| (ArmSamples::new(2), Decomposition::default()));
    let mut start = 0;
    for end in 1..=labels.len() {
        if end < labels.len() && labels[end] == labels[start] {
            continue;
        }
        let part = 2 * start..2 * end;
        let (samples, truth) = &mut sets[usize::from(["e", "q", "v"].contains(&labels[start]))];
        samples.push(
            [0, 1, 2, 3].map(|k| &motion[k][part.clone()]),
            [0, 1].map(|k| &momenta[k][part.clone()]),
        )?;
        truth.torque.extend_from_slice(&motion[3][part.clone()]);
        truth.inertial.extend_from_slice(&parts[0][part.clone()]);
        truth.coriolis.extend_from_slice(&parts[1][part.clone()]);
        truth.gravity.extend_from_slice(&parts[2][part.clone()]);
        truth.other.resize(truth.torque.len(), 0.0);
        start = end;
    }
    Ok(sets)
}
