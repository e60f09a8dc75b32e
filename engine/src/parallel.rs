//! Work on all rows, or on a few parts, by one thread or by all.

use std::sync::{LockResult, Mutex, PoisonError};

use rayon::ThreadPool;
use rayon::prelude::*;

/// Rows that a thread takes at a time.
pub(crate) const RUN: usize = 2048;

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

/// Whether a condition holds for all elements of a list.
pub(crate) fn holds_for_all<T: Sync>(
    all: &[T],
    parallel: bool,
    condition: impl Fn(&T) -> bool + Sync + Send,
) -> bool {
    if parallel {
        all.par_iter().with_min_len(RUN).all(condition)
    } else {
        all.iter().all(condition)
    }
}

/// Changes each element of a list by its row.
pub(crate) fn change_each<T: Send>(
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

/// Calls a function for each of a few parts; `parallel`: with the threads of the pool from which this is called.
pub(crate) fn each_part<T: Send>(
    parallel: bool,
    parts: impl IntoIterator<Item = T>,
    work: impl Fn(T) + Sync,
) {
    if parallel {
        share(None, parts, work);
    } else {
        parts.into_iter().for_each(work);
    }
}

/// Calls a function for each of a few parts, with the threads of a pool if there is one.
pub(crate) fn each_part_by<T: Send>(
    pool: Option<&ThreadPool>,
    parts: impl IntoIterator<Item = T>,
    work: impl Fn(T) + Sync,
) {
    if pool.is_some() {
        share(pool, parts, work);
    } else {
        parts.into_iter().for_each(work);
    }
}

/// The results of a function of each of a few parts, in their order; `parallel` as in [`each_part`].
pub(crate) fn map_parts<T: Send, U: Send>(
    parallel: bool,
    parts: impl IntoIterator<Item = T>,
    of_part: impl Fn(T) -> U + Sync,
) -> Vec<U> {
    if parallel {
        share(None, parts, of_part)
    } else {
        parts.into_iter().map(of_part).collect()
    }
}

/// The results of a function of each part, with the threads of a pool, or of the one from which this is called.
fn share<T: Send, U: Send>(
    pool: Option<&ThreadPool>,
    parts: impl IntoIterator<Item = T>,
    work: impl Fn(T) -> U + Sync,
) -> Vec<U> {
    let place = |part| Mutex::new((Some(part), None));
    let places: Vec<Mutex<(Option<T>, Option<U>)>> = parts.into_iter().map(place).collect();
    each_number(pool, places.len(), &|k| {
        let (part, result) = &mut *content(places[k].lock());
        *result = part.take().map(&work);
    });
    let results = places
        .into_iter()
        .map(|place| content(place.into_inner()).1);
    results.flatten().collect()
}

/// Calls a function with each number below `count`. The code of rayon is compiled here once, and not with the laws of each
/// contact loop.
fn each_number(pool: Option<&ThreadPool>, count: usize, work: &(dyn Fn(usize) + Sync)) {
    let all = || {
        let numbers = (0..count).into_par_iter().with_max_len(1);
        numbers.for_each(work);
    };
    match pool {
        Some(pool) => pool.install(all),
        None => all(),
    }
}

/// The content of a lock. A panic elsewhere ends the run anyway, so a poisoned lock is ignored.
fn content<T>(locked: LockResult<T>) -> T {
    locked.unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Each part is worked on once, and results keep the order of the parts, with threads and without.
        #[test]
        fn parts_are_worked_on_once_and_in_order(count in 0..200usize, threads in 1..4usize) {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let expected: Vec<usize> = (0..count).map(|k| k * k + 1).collect();
            for parallel in [false, true] {
                let squares = pool.install(|| map_parts(parallel, 0..count, |k| k * k + 1));
                prop_assert_eq!(&squares, &expected);
                let mut visits = vec![1; count];
                let parts = visits.iter_mut().enumerate();
                each_part_by(parallel.then_some(&pool), parts, |(k, visit)| *visit += k * k);
                prop_assert_eq!(&visits, &expected);
            }
        }
    }
}
