//! The flights that are missing, on all cores.
//!
//! Each batch is a file, written when all its flights are flown: what is killed costs the batches under way, and
//! begins there again. A flight depends on its number and the seed alone, so that neither the number of cores nor an
//! interruption changes a bit of the results.

use crate::error::Error;
use crate::flight::Row;
use crate::plan::Plan;
use crate::table::{bytes, read};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use squid_design::error::StoreError;
use squid_design::store::files::write;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Flights a file: some seconds of a core's work.
pub const BATCH: u64 = 64;

/// Flies those of the first `flights` flights that the directory does not have, and calls back after each file with the
/// number of flights that are there.
///
/// # Errors
/// [`Error`]; what was flown before is kept.
pub fn run(
    plan: &Plan<'_>,
    flights: u64,
    directory: &Path,
    back: &(dyn Fn(u64) + Sync),
) -> Result<(), Error> {
    let known: BTreeSet<u64> = results(plan, directory)?.iter().map(|row| row.flight).collect();
    let missing = |batch: u64| -> Vec<u64> {
        let flights = batch * BATCH..flights.min((batch + 1) * BATCH);
        flights.filter(|flight| !known.contains(flight)).collect()
    };
    let batches: Vec<Vec<u64>> =
        (0..flights.div_ceil(BATCH)).map(missing).filter(|batch| !batch.is_empty()).collect();
    let to_fly: u64 = batches.iter().map(|batch| batch.len() as u64).sum();
    let done = std::sync::atomic::AtomicU64::new(flights - to_fly);
    back(flights - to_fly);
    batches.par_iter().try_for_each(|batch| {
        let rows =
            batch.iter().map(|flight| Ok(plan.fly(*flight)?.0)).collect::<Result<Vec<Row>, Error>>()?;
        let (first, last) = (rows[0].flight, rows[rows.len() - 1].flight);
        let path = directory.join(format!("flights-{first:08}-{last:08}.parquet"));
        write(&path, &bytes(plan, &rows)?)?;
        let before = done.fetch_add(rows.len() as u64, std::sync::atomic::Ordering::Relaxed);
        back(before + rows.len() as u64);
        Ok(())
    })
}

/// All rows that a directory has of a campaign, by their flights.
///
/// # Errors
/// [`Error::Results`]; [`Error::Other`] where a file is of another campaign.
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

/// The files of results in a directory, which need not be there.
fn files(directory: &Path) -> Result<Vec<PathBuf>, Error> {
    if !directory.exists() {
        return Ok(Vec::new());
    }
    let unreadable = |reason| StoreError::Unwritable { path: directory.display().to_string(), reason };
    let all = std::fs::read_dir(directory).map_err(unreadable)?;
    let paths = all.map(|entry| Ok(entry.map_err(unreadable)?.path())).collect::<Result<Vec<_>, Error>>()?;
    Ok(paths.into_iter().filter(|path| path.extension().is_some_and(|kind| kind == "parquet")).collect())
}
