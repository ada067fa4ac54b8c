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
    /// Figures are written as PNG too, next to the SVG.
    pub png: bool,
}

impl ReportFolder<'_> {
    /// Writes `metrics.json`.
    ///
    /// # Errors
    /// A file of another program with this name; files that cannot be written.
    pub fn write_metrics(&self, outcome: &impl Serialize) -> anyhow::Result<()> {
        write_metrics(self.path, outcome)
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use crate::lines::{Curve, TimeChart, TimePanel};

    #[test]
    fn a_report_has_its_figures_as_files_and_on_its_page() {
        let chart = || {
            let panel = TimePanel::new("x [mm]", vec![Curve::new("tip", 0, vec![0.0, 1.0])]);
            TimeChart::over_time("tip", "Tip over time", "A caption.", &[0.0, 1.0], vec![panel])
        };
        for png in [false, true] {
            let scratch = tempfile::tempdir().unwrap();
            let folder = ReportFolder { path: scratch.path(), png };
            let mut page = Page::concluded("Title", "A result.", "About.", "hysteron verb");
            folder.add(&mut page, &chart()).unwrap();
            folder.write_metrics(&[1, 2]).unwrap();
            folder.write_page(page, "abc").unwrap();
            let text = |name: &str| std::fs::read_to_string(scratch.path().join(name)).unwrap();
            assert!(text("tip.svg").contains("Tip over time"));
            assert!(
                text("report.html").contains("A caption.") && text("report.html").contains("Program abc.")
            );
            assert_eq!(text("metrics.json").split_whitespace().collect::<String>(), "[1,2]");
            assert_eq!(scratch.path().join("tip.png").exists(), png);
        }
    }
}
