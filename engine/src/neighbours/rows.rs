//! Passes over all rows, by one thread or by all.

use rayon::prelude::*;

/// Rows that a thread takes at a time.
pub(super) const RUN: usize = 2048;

/// The results of a function of the row, in the order of the rows; `parallel`: with the threads of the pool from which this is
/// called.
pub(crate) fn each<T: Send>(
    count: usize,
    parallel: bool,
    of_row: impl Fn(usize) -> T + Sync + Send,
) -> Vec<T> {
    if parallel {
        let rows = (0..count).into_par_iter().with_min_len(RUN);
        rows.map(of_row).collect()
    } else {
        (0..count).map(of_row).collect()
    }
}

/// Changes each element of a list by its row.
pub(super) fn change_each<T: Send>(
    all: &mut [T],
    parallel: bool,
    change: impl Fn(usize, &mut T) + Sync + Send,
) {
    if parallel {
        let rows = all.par_iter_mut().with_min_len(RUN).enumerate();
        rows.for_each(|(row, one)| change(row, one));
    } else {
        let rows = all.iter_mut().enumerate();
        rows.for_each(|(row, one)| change(row, one));
    }
}

/// Calls a function for each of a few parts, in parallel if there are several.
pub(super) fn each_of<T: Send>(parts: Vec<T>, work: impl Fn(T) + Sync + Send) {
    if parts.len() > 1 {
        parts.into_par_iter().with_max_len(1).for_each(work);
    } else {
        parts.into_iter().for_each(work);
    }
}
