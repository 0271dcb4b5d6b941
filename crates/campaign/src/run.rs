//! Simulation of the missing flights on all cores.
//!
//! Each batch is a file, written after its last flight: a killed run loses only its unfinished batches and can be
//! resumed. A flight depends on its number and the seed only, so that neither the number of cores nor an interruption
//! changes a bit of the results.

use crate::error::Error;
use crate::flight::Row;
use crate::plan::Plan;
use crate::table::{bytes, read};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use squid_base::files::{self, write};
use std::collections::BTreeSet;
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Flights per file: a few seconds on one core.
pub const BATCH: u64 = 64;

/// Returns the flights missing in a directory, in contiguous parts; each part becomes a file.
///
/// # Errors
/// Errors of [`results`].
pub fn missing(
    plan: &Plan<'_>,
    flights: Range<u64>,
    directory: &Path,
) -> Result<Vec<RangeInclusive<u64>>, Error> {
    let present: BTreeSet<u64> = results(plan, directory)?.iter().map(|row| row.flight).collect();
    let mut parts: Vec<RangeInclusive<u64>> = Vec::new();
    for flight in flights.filter(|flight| !present.contains(flight)) {
        match parts.last_mut() {
            Some(part) if part.end() + 1 == flight && flight % BATCH != 0 => *part = *part.start()..=flight,
            _ => parts.push(flight..=flight),
        }
    }
    Ok(parts)
}

/// Simulates the flights of each part, and calls `back` after each file with the number of flights completed.
///
/// # Errors
/// [`Error`], or the error of a flight; completed files remain.
pub fn run<E: From<Error> + Send>(
    plan: &Plan<'_>,
    parts: &[RangeInclusive<u64>],
    directory: &Path,
    fly: &(impl Fn(u64) -> Result<Row, E> + Sync),
    back: &(dyn Fn(u64) + Sync),
) -> Result<(), E> {
    let completed = AtomicU64::new(0);
    parts.par_iter().try_for_each(|part| {
        let rows = part.clone().map(fly).collect::<Result<Vec<Row>, E>>()?;
        let path = directory.join(format!("flights-{:08}-{:08}.parquet", part.start(), part.end()));
        write(&path, &bytes(plan, &rows)?).map_err(Error::from)?;
        let count = rows.len() as u64;
        back(count + completed.fetch_add(count, Ordering::Relaxed));
        Ok(())
    })
}

/// Returns all rows of a campaign in a directory, in the order of the flights.
///
/// # Errors
/// [`Error::Results`]; [`Error::Other`] if a file is of another campaign.
pub fn results(plan: &Plan<'_>, directory: &Path) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for path in files(directory)? {
        let (identity, found) = read(&path)?;
        if let Some(what) = identity.differs_from(&plan.identity) {
            return Err(Error::Other { path: path.display().to_string(), what: what.into() });
        }
        rows.extend(found);
    }
    rows.sort_by_key(|row: &Row| row.flight);
    Ok(rows)
}

/// Returns the result files in a directory; none if it does not exist.
fn files(directory: &Path) -> Result<Vec<PathBuf>, Error> {
    if !directory.exists() {
        return Ok(Vec::new());
    }
    let unreadable = |reason| files::Error::Unreadable { path: directory.display().to_string(), reason };
    let all = std::fs::read_dir(directory).map_err(unreadable)?;
    let paths = all.map(|entry| Ok(entry.map_err(unreadable)?.path())).collect::<Result<Vec<_>, Error>>()?;
    let is_data = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "parquet");
    let mut data: Vec<PathBuf> = paths.into_iter().filter(is_data).collect();
    // The order of a directory depends on the file system.
    data.sort();
    Ok(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_an_unreadable_directory() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = files(file.path()).unwrap_err();
        assert!(matches!(error, Error::File(files::Error::Unreadable { .. })), "{error}");
    }
}
