//! Public data sets as their authors publish them, each by a map of under 30 lines; numbers by pandas.

use std::path::PathBuf;

use hysteron_base::Metadata;
use hysteron_base::import::{Assembled, ColumnMap, Request, read};
use hysteron_fuzz::recorded;

fn imported(name: &str, files: &[&str], map: Option<&str>) -> Option<Vec<Assembled>> {
    let paths: Option<Vec<PathBuf>> = files.iter().map(|file| recorded(name, file)).collect();
    let columns = map.map(|map| ColumnMap::named(map).unwrap());
    let request = Request { columns, ..Request::default() };
    Some(read(&paths?, &request, Metadata::default()).unwrap())
}

fn range(all: &[Assembled], channel: &str) -> [f64; 2] {
    let values = all.iter().flat_map(|one| one.recording.channel(channel).unwrap());
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)])
}

fn assert_range(all: &[Assembled], channel: &str, expected: [f64; 2]) {
    let found = range(all, channel);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{channel}: {found} for {expected}");
    }
}

#[test]
fn holds_of_a_tendon_robot_stay_where_they_are() {
    let name = "holds_of_a_tendon_robot_stay_where_they_are";
    let train = imported(name, &["ftdcr-v4/train.csv"], None);
    let pulls = imported(name, &["ftdcr-v4/tendon_pull.csv"], None);
    let (Some(train), Some(pulls)) = (train, pulls) else { return };
    assert_eq!((train[0].recording.n_samples(), pulls[0].recording.n_samples()), (1620, 134));
    assert_eq!(train[0].columns, "ftdcr");
    assert_range(&train, "tip_x_m", [-0.161791224, 0.139812774]);
    assert_range(&train, "stroke_1_m", [-0.010001556, 0.004801361]);
    assert_range(&pulls, "tip_x_m", [-0.115877576, 0.056562449]);
    let time = train[0].recording.time();
    assert!((time[1619] - 1462.4453818798065).abs() < 1e-6);
}

#[test]
fn holds_of_a_tentacle_are_in_its_own_frame() {
    let Some(all) =
        imported("holds_of_a_tentacle_are_in_its_own_frame", &["tentacle/static_markers.csv"], None)
    else {
        return;
    };
    let recording = &all[0].recording;
    assert_eq!((recording.n_samples(), all[0].columns.as_str()), (14, "tentacle"));
    assert_range(&all, "tension_1_n", [0.0, 7.692307692307692]);
    // A quarter turn about x of the last marker less the one on the base.
    let tip = recording.tip().unwrap().map(|axis| axis[0]);
    for (found, expected) in
        tip.iter().zip([-0.007333930069930078, -0.048511886946386945, 0.3507638228438228])
    {
        assert!((found - expected).abs() < 1e-15, "{tip:?}");
    }
}

#[test]
fn observations_and_commands_of_a_trunk_are_joined_by_their_number() {
    let name = "observations_and_commands_of_a_trunk_are_joined_by_their_number";
    let commands = "trunk/control_inputs_controlled_1.csv";
    for (observations, lowest) in [
        ("trunk/observations_controlled_1.csv", -0.312843918800354),
        ("trunk/observations_controlled_1_200g.csv", -0.3141762912273407),
    ] {
        let Some(all) = imported(name, &[observations, commands], Some("trunk")) else { return };
        let recording = &all[0].recording;
        // The last observation has no command.
        let gaps: Vec<usize> = (0..recording.n_samples()).filter(|row| recording.gap()[*row]).collect();
        assert_eq!((recording.n_samples(), gaps), (15_001, vec![15_000]));
        let [low, _] = range(&all, "tip_z_m");
        assert!((low - lowest).abs() < 1e-15, "{low}");
        assert_range(&all, "goal_1_rad", [-50_f64.to_radians(), 50_f64.to_radians()]);
    }
}

#[test]
fn characters_are_episodes_of_one_file() {
    let name = "characters_are_episodes_of_one_file";
    let Some(all) = imported(name, &["arms/delan-characters/characters.csv"], Some("delan-characters"))
    else {
        return;
    };
    assert_eq!(all.len(), 20);
    assert_eq!(all.iter().map(|one| one.recording.n_samples()).sum::<usize>(), 2913);
    assert_range(&all, "tau_1_n_m", [-0.4737061482528949, 4.866608235159825]);
}

#[test]
fn recordings_of_arms_keep_their_ranges() {
    let name = "recordings_of_arms_keep_their_ranges";
    // Torques of the first joint that is recorded, by pandas and numpy.
    for (file, map, channel, expected) in [
        ("arms/friction-franka/franka_case3_slow.csv", None, "tau_1_n_m", [-1.0217, 0.506777]),
        ("arms/friction-franka/franka_case3_middle.csv", None, "tau_1_n_m", [-0.611487, 1.02136]),
        ("arms/friction-franka/franka_case3_high.csv", None, "tau_1_n_m", [-1.36799, 0.882109]),
    ] {
        let Some(all) = imported(name, &[file], map) else { continue };
        // Rows at uneven times are resampled, which takes no extreme further.
        let ([low, high], [lowest, highest]) = (range(&all, channel), expected);
        assert!(low >= lowest && high <= highest, "{file}: {low} {high}");
        assert!(low < 0.9 * lowest && high > 0.9 * highest, "{file}: {low} {high}");
    }
}
