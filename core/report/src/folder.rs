//! The folder of a report: figures, `report.html` and `metrics.json`.

use std::path::Path;

use serde::Serialize;

use crate::figure::{Drawn, Figure, register_embedded_font, save};
use crate::page::{Page, write_metrics, write_page};

/// Where a report is written, and in which formats its figures are.
#[derive(Debug, Clone, Copy)]
pub struct ReportFolder<'a> {
    /// Folder of all files.
    pub path: &'a Path,
    /// Figures are written as PNG too, beside the SVG.
    pub png: bool,
}

impl ReportFolder<'_> {
    /// Writes `metrics.json`.
    ///
    /// # Errors
    /// A file of another program with this name; files that cannot be written.
    pub fn write_metrics(&self, outcome: &impl Serialize) -> anyhow::Result<()> {
        write_metrics(self.path, outcome).map(|_| ())
    }

    /// Writes a figure to its files and gives it back for a page.
    ///
    /// # Errors
    /// A figure that cannot be drawn, and those of [`Self::write_metrics`].
    pub fn save(&self, figure: &impl Figure) -> anyhow::Result<Drawn> {
        register_embedded_font()?;
        save(self.path, figure, self.png)
    }

    /// Writes a figure to its files and adds it to a page.
    ///
    /// # Errors
    /// Those of [`Self::save`].
    pub fn add(&self, page: &mut Page, figure: &impl Figure) -> anyhow::Result<()> {
        page.figure(&self.save(figure)?);
        Ok(())
    }

    /// Ends a page with the commit of the program, and writes it as `report.html`.
    ///
    /// # Errors
    /// Those of [`Self::write_metrics`].
    pub fn write_page(&self, page: Page, commit: &str) -> anyhow::Result<()> {
        write_page(self.path, page.finish(commit))
    }
}
