//! Options of `hysteron check`.

use std::path::PathBuf;

/// Check a scene with its mesh, or recordings
///
/// Of a scene: the quality of the mesh, every tendon with its length and how far its points lie outside the body, and
/// the size of the equations. Of recordings: one table of suspicious and impossible data, such as units, frozen or copied
/// channels, gaps, spikes, delays and too little motion; exit code 2 for impossible data. Recordings
/// next to a scene are compared with its body too.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file (scene.toml), recordings (.parquet, .csv, .journal) or folders of them
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "FILE"))]
    pub files: Vec<PathBuf>,
}
