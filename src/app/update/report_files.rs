//! The report as text, for the clipboard and for files.

use std::path::PathBuf;
use std::sync::Arc;

use super::files::{is_source, save_as};
use super::report::vertices;
use crate::analysis::{Section, measures_csv, report_json, sections_csv, vertices_csv};
use crate::app::jobs::Job;
use crate::app::model::{Model, SavedWhat};
use crate::app::report::{Measured, ReportFile};
use crate::io;
use crate::mesh::LoadReport;

/// The data of a written report.
struct Sheet {
    file: ReportFile,
    name: String,
    load: Option<LoadReport>,
    measured: Arc<Measured>,
    section: Option<Arc<Section>>,
}

impl Sheet {
    /// The newest measures, or a message if there are none.
    fn new(model: &mut Model, file: ReportFile) -> Option<Self> {
        let Some(measured) = model.report.measured.clone() else {
            model
                .log
                .info("nothing was measured: open the report (Analyze > Report) and wait for it");
            model.view.windows.analysis = true;
            return None;
        };
        let section = model.report.cut.as_ref().map(|c| Arc::clone(&c.section));
        if file == ReportFile::Section && section.is_none() {
            model
                .log
                .info("there is no section: choose one in the report first");
            return None;
        }
        let origin = &model.document.origin;
        Some(Self {
            file,
            name: origin.name(),
            load: Some(origin.report.clone()),
            measured,
            section,
        })
    }

    fn text(&self) -> Result<String, String> {
        let measured = &self.measured;
        let sections: Vec<_> = self.section.iter().map(|s| (**s).clone()).collect();
        Ok(match self.file {
            ReportFile::Json => {
                let mut analysis = measured.analysis.clone();
                analysis.sections = sections;
                return report_json(&self.name, self.load.as_ref(), &analysis)
                    .map_err(|e| e.to_string());
            }
            ReportFile::Measures => measures_csv(&measured.analysis),
            ReportFile::Vertices => {
                let vertices = vertices(measured.request.on_surface);
                vertices_csv(&measured.mesh, vertices, &measured.analysis)
            }
            ReportFile::Section => sections_csv(&sections),
        })
    }
}

/// Copies a report to the clipboard.
pub(super) fn copy(model: &mut Model, file: ReportFile) {
    if let Some(sheet) = Sheet::new(model, file) {
        let job = Job::spawn("copying the report", &model.wake, move |_| sheet.text());
        model.report.copying = Some(job);
    }
}

/// Writes a report.
pub(super) fn save(model: &mut Model, file: ReportFile, path: PathBuf) {
    let reference = model.view.report.reference.as_ref();
    let is_reference = reference.is_some_and(|r| io::same_file(r, &path));
    if is_source(model, &path) || is_reference {
        model.log.error(format!(
            "{} is an open mesh, which is never overwritten: choose another name",
            path.display()
        ));
        return;
    }
    let Some(sheet) = Sheet::new(model, file) else {
        return;
    };
    save_as(model, path, SavedWhat::Report, move |path| {
        let text = sheet.text()?;
        io::save_text(path, &text).map_err(|e| e.to_string())?;
        Ok(Vec::new())
    });
}
