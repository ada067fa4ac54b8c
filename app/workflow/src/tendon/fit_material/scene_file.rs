//! A scene file with other numbers in it: comments, order and everything else stay.

use std::path::{Component, Path, PathBuf};

use anyhow::Context as _;
use hysteron_base::units::Unit;
use hysteron_base::{Scene, file};
use toml_edit::{DocumentMut, Item, TableLike, value};

use crate::Context;
use crate::shared::paths::plain;
use hysteron_report::maker::MADE_BY;

/// Digits of a fitted number: more than any fit knows.
const DIGITS: usize = 6;

/// Writes the scene file `from`, which holds `old`, to `to` with the numbers of `new`.
pub fn write(from: &Path, old: &Scene, new: &Scene, to: &Path, context: &Context) -> anyhow::Result<()> {
    let mut text: DocumentMut = file::read_text(from)?.parse().context("reading the scene again")?;
    let material = text.get_mut("material").and_then(Item::as_table_like_mut).context("no [material]")?;
    for (stem, old, new) in [
        ("youngs_modulus", old.material.youngs_modulus, new.material.youngs_modulus),
        ("poisson_ratio", old.material.poisson_ratio, new.material.poisson_ratio),
        ("density_kg_m3", old.material.density, new.material.density),
    ] {
        if new != old {
            let key = material.iter().find(|(key, _)| key.starts_with(stem)).map(|(key, _)| key.to_owned());
            set(material, &key.context("a key that was there")?, new);
        }
    }
    let tendons = text.get_mut("tendon").and_then(Item::as_array_of_tables_mut);
    let tendons = tendons.into_iter().flat_map(|tables| tables.iter_mut());
    for ((table, old), new) in tendons.zip(&old.tendons).zip(&new.tendons) {
        if new.zero != old.zero {
            set(table, "zero_mm", new.zero);
        }
        if new.compliance != old.compliance {
            set(table, "compliance_mm_per_n", new.compliance);
        }
    }
    if let (Some(old), Some(new)) = (&old.friction, &new.friction) {
        let friction = text.get_mut("friction").and_then(Item::as_table_like_mut).context("no [friction]")?;
        for (key, old, new) in [
            ("coefficient", old.coefficient, new.coefficient),
            ("coulomb_n", old.coulomb, new.coulomb),
            ("sheath_exponent", old.sheath_exponent, new.sheath_exponent),
            ("sheath_coulomb_n", old.sheath_coulomb, new.sheath_coulomb),
            ("sheath_compliance_share", old.sheath_compliance_share, new.sheath_compliance_share),
            ("backlash_mm", old.backlash, new.backlash),
        ] {
            if new != old {
                set(friction, key, new);
            }
        }
    }
    if new.gravity != old.gravity {
        let gravity = text.get_mut("gravity").and_then(Item::as_table_like_mut).context("no [gravity]")?;
        set_vector(gravity, "acceleration_m_s2", new.gravity);
    }
    if new.tracker != old.tracker {
        let tracker = text.entry("tracker").or_insert_with(toml_edit::table);
        let tracker = tracker.as_table_like_mut().context("no [tracker]")?;
        set_vector(tracker, "turn_deg", new.tracker.turn);
        set_vector(tracker, "shift_mm", new.tracker.shift);
    }
    let files = [("mesh", Some(&new.mesh_path)), ("reduced", new.reduced_path.as_ref())];
    for (table, path) in files.into_iter().filter_map(|(table, path)| Some((table, path?))) {
        let path = relative(path, to.parent().unwrap_or(Path::new("")))?;
        let place = text.entry(table).or_insert_with(toml_edit::table);
        let place = place.as_table_like_mut().with_context(|| format!("no [{table}]"))?;
        replace(place, "file", value(path.to_string_lossy().into_owned()));
    }

    // The written file must be a scene with these numbers up to the digits written.
    let text = text.to_string();
    let own: Vec<&str> = text.lines().filter(|line| !line.starts_with(MADE_BY)).collect();
    let text = format!("{MADE_BY}{}\n{}\n", context.command.clone(), own.join("\n"));
    Scene::from_toml(&text, &to.display().to_string(), to.parent().unwrap_or(Path::new("")))?;
    Ok(file::write_bytes(to, text)?)
}

/// Sets a number, in the unit of its key.
fn set(table: &mut dyn TableLike, key: &str, si: f64) {
    replace(table, key, value(shown(key, si)));
}

/// Sets three numbers, in the unit of their key.
fn set_vector(table: &mut dyn TableLike, key: &str, si: [f64; 3]) {
    let numbers: toml_edit::Array = si.iter().map(|number| shown(key, *number)).collect();
    replace(table, key, value(numbers));
}

/// A number in the unit of its key, with the digits that are written.
fn shown(key: &str, si: f64) -> f64 {
    let own = Unit::of_name(key).map_or(si, |(_, unit)| unit.from_si(si));
    format!("{own:.*e}", DIGITS - 1).parse().unwrap_or(own)
}

/// Sets a key; the comment behind an old value stays.
fn replace(table: &mut dyn TableLike, key: &str, mut new: Item) {
    if let (Some(old), Some(new)) = (table.get(key).and_then(Item::as_value), new.as_value_mut()) {
        *new.decor_mut() = old.decor().clone();
    }
    table.insert(key, new);
}

/// `path` as seen from `folder`.
fn relative(path: &Path, folder: &Path) -> anyhow::Result<PathBuf> {
    let here = std::env::current_dir()?;
    let (path, folder) = (plain(&here.join(path)), plain(&here.join(folder)));
    let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    Ok(up.chain(path.components().skip(shared)).collect())
}
