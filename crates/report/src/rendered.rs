//! Rendered report, cached next to its design and computed again only if its inputs have changed.

use crate::error::Error;
use crate::page::html;
use crate::report::Report;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use squid_base::files::Files;
use squid_base::progress::Progress;
use squid_design::inputs::{Inputs, sha256};
use squid_design::store::Stored;
use squid_finding::Finding;
use std::fmt::Debug;
use std::path::{Path, PathBuf};

/// Name of the cache file.
pub const FILE: &str = "report.json";

/// Rendered report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rendered {
    /// Key of the inputs; see [`key`].
    key: Option<String>,
    /// Findings on proofs that fail.
    pub unproved: Vec<Finding>,
    /// Verdict for a terminal.
    pub summary: String,
    /// Program and input files.
    origin: String,
    /// Parts of the page before and after the inserted origin and remarks.
    head: String,
    body: String,
    /// Names and SVG files of the figures.
    figures: Vec<(String, String)>,
}

impl Rendered {
    /// Renders a report without a cache.
    pub fn of(report: &Report) -> Self {
        Self::new(report, None)
    }

    fn new(report: &Report, key: Option<String>) -> Self {
        let (head, body) = html::page(report);
        let figures = report.figures().map(|f| (f.name.clone(), f.file(&f.caption))).collect();
        let (unproved, origin) = (report.unproved.clone(), report.origin.clone());
        Self { key, unproved, summary: report.summary.clone(), origin, head, body, figures }
    }

    /// Returns the page, with the paragraphs `about` below its heading.
    pub fn page(&self, about: &[String]) -> String {
        self.page_of(&self.origin, about)
    }

    fn page_of(&self, origin: &str, about: &[String]) -> String {
        let about: String = about.iter().map(|text| html::paragraph(text)).collect();
        let (style, origin) = html::origin(origin);
        let head = self.head.replacen("</head>", &format!("{style}</head>"), 1);
        format!("{head}{origin}{about}{}", self.body)
    }

    /// Writes `report.html`, with the date of the inputs, and each figure as `figures/NAME.svg`, and returns the path
    /// of the page.
    ///
    /// # Errors
    /// [`files::Error`](squid_base::files::Error).
    pub fn save(&self, inputs: &Inputs, directory: &Path) -> Result<PathBuf, Error> {
        let mut files = Files::default();
        for (name, figure) in &self.figures {
            files.add(directory.join("figures").join(format!("{name}.svg")), figure.clone());
        }
        let path = directory.join("report.html");
        let dated = date(inputs).map(|date| format!("{}; files of {date}", self.origin));
        files.add(path.clone(), self.page_of(dated.as_ref().unwrap_or(&self.origin), &[]));
        files.save(directory)?;
        Ok(path)
    }
}

/// Returns the full report of a stored design: read from `directory` if its inputs and `options` are unchanged,
/// otherwise computed by `make` and stored there.
///
/// # Errors
/// Errors of `make`; [`files::Error`](squid_base::files::Error).
pub fn rendered(
    inputs: &Inputs,
    stored: &Stored,
    directory: &Path,
    options: &impl Debug,
    make: impl FnOnce() -> Result<Report, Error>,
    progress: &Progress,
) -> Result<Rendered, Error> {
    let path = directory.join(FILE);
    // The key includes the running program, so that no report of another version is shown.
    let program = std::env::current_exe().and_then(std::fs::read).ok();
    let key = program.map(|program| key(&program, inputs, stored, options));
    let kept = std::fs::read_to_string(&path).ok();
    let kept = kept.and_then(|text| serde_json::from_str::<Rendered>(&text).ok());
    if let Some(kept) = kept.filter(|kept| key.is_some() && kept.key == key) {
        kept.unproved.iter().for_each(|found| progress.warn(found));
        progress.done("report", "taken from an earlier run with the same files");
        return Ok(kept);
    }
    let fresh = Rendered::new(&progress.timed("report", "computing the figures", make).0?, key);
    let mut files = Files::default();
    files.add_json(path, &fresh)?;
    files.save(directory)?;
    Ok(fresh)
}

/// Returns the date (UTC) of the last change of the input files. It is not cached, so that the same files give the same
/// bytes on any day.
fn date(inputs: &Inputs) -> Option<String> {
    let files = ["vehicle.toml", &inputs.design.file];
    let changed = |file: &&str| std::fs::metadata(inputs.directory.join(file)).ok()?.modified().ok();
    let latest = files.iter().filter_map(changed).max()?;
    humantime::format_rfc3339_seconds(latest).to_string().split('T').next().map(str::to_owned)
}

/// Returns the SHA-256 of all inputs of a report: vehicle and design file, stored design, options, and program.
fn key(program: &[u8], inputs: &Inputs, stored: &Stored, options: &impl Debug) -> String {
    sha256(&format!("{:?}", (Sha256::digest(program), &inputs.hashes, &inputs.design.name, stored, options)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_design::store::load;
    use squid_design::verdict::row::Advice;
    use squid_flight::sea::Sea;
    use std::time::{Duration, SystemTime};

    /// The page of a design with changed bandwidth has the date and name of its file.
    #[test]
    fn altered_design_has_the_date_of_its_file() {
        let vehicle = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles/squid"));
        let folder = tempfile::tempdir().unwrap();
        for name in ["vehicle.toml", "design.toml"] {
            std::fs::copy(vehicle.join(name), folder.path().join(name)).unwrap();
        }
        let file = std::fs::File::options().write(true).open(folder.path().join("design.toml")).unwrap();
        file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_hours(24 * 365 * 100)).unwrap();
        let inputs = Inputs::read(folder.path(), "design").unwrap().with_bandwidth(0.1).unwrap();
        assert_eq!(date(&inputs).as_deref(), Some("2069-12-07"));
        let origin = Rendered::of(&Report::without_sections(&inputs, vec![])).origin;
        assert!(origin.contains(" design-bandwidth-0.1 "), "{origin}");
    }

    /// Every input of the report changes the key, so that no other report is shown.
    #[test]
    fn key_depends_on_every_input() {
        let vehicle = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles/squid"));
        let inputs = Inputs::read(vehicle, "design").unwrap();
        let stored = load(&vehicle.join("frozen"), &inputs).unwrap();
        let options = (true, None::<(Sea, String)>);
        let of = |inputs: &Inputs, stored: &Stored| key(b"squid", inputs, stored, &options);
        let mut keys = vec![of(&inputs, &stored)];
        assert_eq!(keys[0], of(&inputs, &stored));

        let mut other = stored.clone();
        other.controller.gamma.bound *= 1.0 + f64::EPSILON;
        keys.push(of(&inputs, &other));
        let mut other = stored.clone();
        other.certificate = Err(other.certificate.unwrap());
        keys.push(of(&inputs, &other));
        let mut other = stored.clone();
        other.plant.as_mut().unwrap().trim[0].pitch += 1e-9;
        keys.push(of(&inputs, &other));
        let mut other = stored.clone();
        other.manoeuvre.steps.values_mut().for_each(|step| *step *= 0.5);
        keys.push(of(&inputs, &other));
        let mut other = stored.clone();
        other.rows[0].advice = Some(Advice { change: None, text: "no key".into() });
        keys.push(of(&inputs, &other));
        let mut other = inputs.clone();
        other.hashes.design_sha256.push('0');
        keys.push(of(&other, &stored));
        let text = "seed = 1\n";
        let sea = Some((Sea::parse(text, "sea.toml").unwrap(), text.to_owned()));
        for other in [(false, None), (true, sea)] {
            keys.push(key(b"squid", &inputs, &stored, &other));
        }
        keys.push(key(b"squid of another version", &inputs, &stored, &options));
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), 10);
    }
}
