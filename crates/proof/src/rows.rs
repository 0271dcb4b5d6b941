//! Plants and controllers in the form of a certificate, lists of rows.

use certificate::{Controller as ControllerRows, Plant as PlantRows, Rows};
use lpv::controller::Controller;
use lpv::matrix::{Mat, from_rows, to_rows};
use lpv::partition::{self, CONTROLLER, NamedBlock, Names, Partitioned};
use lpv::plant::GeneralisedPlant;

/// A plant in the form of the certificate.
pub fn plant_rows(p: &GeneralisedPlant) -> PlantRows {
    let mut out = PlantRows::default();
    out.named_mut().into_iter().for_each(|(key, rows)| *rows = rows_of(&p.parts, key));
    out
}

fn rows_of(parts: &Partitioned, key: &str) -> Rows {
    parts.named(key).map_or_else(Vec::new, |m| to_rows(&m))
}

/// A direct path from u to y in the form of the certificate: nothing where it is 0.
pub fn direct_path(d22: &Mat) -> Rows {
    if d22.iter().all(|entry| *entry == 0.0) { vec![] } else { to_rows(d22) }
}

/// A controller in the form of the certificate.
pub fn controller_rows(k: &Controller) -> ControllerRows {
    let mut out = ControllerRows::default();
    out.named_mut().into_iter().for_each(|(key, rows)| *rows = rows_of(&k.parts, key));
    out
}

/// The controller of such rows; `None` when its matrices do not fit together.
pub fn controller(blocks: &[usize], rows: &ControllerRows) -> Option<Controller> {
    Controller::new(blocks.to_vec(), &blocks_of(CONTROLLER, &rows.named())?).ok()
}

/// The blocks of a partition whose matrices are given with their keys; `None` when one is ragged or no part of it. A
/// matrix without rows is left out.
pub fn blocks_of(names: Names, matrices: &[(&'static str, &Rows)]) -> Option<Vec<NamedBlock>> {
    let given = matrices.iter().filter(|(_, rows)| !rows.is_empty());
    let block = |(key, rows): &(&'static str, &Rows)| {
        let (_, row, column) = partition::names(names).find(|(name, _, _)| name == key)?;
        Some((row, column, from_rows(rows, rows.first()?.len())?))
    };
    given.map(block).collect()
}

/// The name of the first matrix that differs in any bit, but for the sign of zero.
pub fn first_unlike(a: &[(&'static str, &Rows)], b: &[(&'static str, &Rows)]) -> Option<&'static str> {
    a.iter().zip(b).find(|((_, p), (_, q))| p != q).map(|((name, _), _)| *name)
}
