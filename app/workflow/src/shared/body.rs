//! The body that moves a robot: its mesh, or a chain of condensed sections.

use std::path::{Path, PathBuf};

use hysteron_base::Scene;

/// The body that moves a robot.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct RobotBodyOptions {
    /// Chain by hysteron reduce: it moves the robot in place of the finite elements [default: that of the scene, if it names one]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub reduced: Option<PathBuf>,
}

impl RobotBodyOptions {
    /// The scene of a file, with this body.
    ///
    /// # Errors
    /// Those of [`Scene::read`]; a chain that cannot be read.
    pub fn scene(&self, path: &Path) -> hysteron_base::Result<Scene> {
        Scene::read_with(path, self.reduced.clone())
    }
}
