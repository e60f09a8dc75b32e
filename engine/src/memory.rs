//! Memory: hints to the processor and the system, for which there is no safe way.
//!
//! Two are for lookups all over a large array, where waiting for memory would dominate. Measured on a mesh of a million triangles
//! (decision 0016): 5 to 10 % of the time of a whole run each. The third returns the memory that a new list has left free.

/// Capacity of a list that has grown entry by entry, over its length: between 1 and 2, evenly on a logarithmic scale.
pub const GROWTH: f64 = std::f64::consts::LOG2_E;

/// Size of a large page, bytes, on x86-64 and most of ARM.
#[cfg(all(target_os = "linux", not(miri)))]
const PAGE: usize = 2 << 20;

/// Prefetches the cache lines of a value that is needed soon. Changes nothing; on processors other than x86-64 it does nothing.
#[inline(always)]
pub(crate) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    for line in (0..size_of::<T>()).step_by(64) {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(value).cast::<i8>();
        // SAFETY: the address lies in the value; a prefetch neither reads nor writes anything that a program can see.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(line)) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// Memory for values that are read in random order, in large pages where the system has them (on Linux, where
/// `/sys/kernel/mm/transparent_hugepage/enabled` contains `madvise` or `always`): otherwise finding the addresses of small pages
/// takes about as long as reading the values.
pub(crate) fn in_large_pages<T>(count: usize) -> Vec<T> {
    let room: Vec<T> = Vec::with_capacity(count);
    #[cfg(all(target_os = "linux", not(miri)))]
    {
        let (start, size) = (room.as_ptr().cast::<u8>(), count * size_of::<T>());
        let before = start.align_offset(PAGE);
        let whole = size.saturating_sub(before) / PAGE * PAGE;
        if whole > 0 {
            debug_assert!(before + whole <= size);
            // SAFETY: these pages lie in memory that the vector owns, and the advice changes nothing of their content. If the system
            // refuses it, they stay as they are.
            unsafe {
                libc::madvise(
                    start.add(before).cast_mut().cast(),
                    whole,
                    libc::MADV_HUGEPAGE,
                )
            };
        }
    }
    room
}

/// With more particles than this, memory that a new list has left free is returned (`give_back`).
pub const MANY: usize = 50_000;

/// Returns memory to the system that was freed in many pieces, and that the allocator would keep for later. With glibc; elsewhere
/// it does nothing.
pub(crate) fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu", not(miri)))]
    // SAFETY: it touches free memory only.
    unsafe {
        libc::malloc_trim(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The hints change nothing: values are read back as they were written, in arrays that end before, at and after a large page,
    /// and the last value may be prefetched like the first.
    #[test]
    fn hints_change_nothing() {
        let fits = (2 << 20) / size_of::<[u64; 5]>();
        for count in [0, 1, fits - 1, fits, 3 * fits + 1] {
            let mut values = in_large_pages(count);
            assert!(values.is_empty() && values.capacity() >= count);
            let start = values.as_ptr();
            values.extend((0..count as u64).map(|k| [k, !k, k ^ 7, 0, 1]));
            assert_eq!(values.as_ptr(), start);
            values.iter().for_each(prefetch);
            for (k, value) in (0..).zip(&values) {
                assert_eq!(*value, [k, !k, k ^ 7, 0, 1]);
            }
        }
        assert!(in_large_pages::<()>(10).capacity() >= 10);
    }
}
