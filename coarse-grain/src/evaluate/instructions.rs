//! Work that is compiled once more for processors with wide registers, chosen when the program runs.
//!
//! Both compilations make the same operations of IEEE 754 in the same order, several at a time and never fused: the bytes are
//! those of every processor. `docs/performance.md` gives the gain.

/// Work to be done with whatever instructions the processor has.
pub(crate) trait Task {
    /// Does it. To be marked `inline(always)`, as all that it calls in its inner loops: only what is inlined here is compiled for the
    /// processor that was found.
    fn run(self);
}

/// Instructions that this processor has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Instructions(Kind);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Instructions that every processor of its kind has.
    Common,
    /// Registers of four numbers.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Instructions {
    /// Instructions that every processor has.
    #[cfg(test)]
    pub(crate) const COMMON: Self = Self(Kind::Common);

    /// The widest of this processor.
    pub(crate) fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            return Self(Kind::Avx2);
        }
        Self(Kind::Common)
    }

    /// Does a task with them.
    #[inline]
    pub(crate) fn run<T: Task>(self, task: T) {
        match self.0 {
            Kind::Common => task.run(),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: only `widest` makes this value, and it has checked that the processor has the feature.
            Kind::Avx2 => unsafe { with_avx2(task) },
        }
    }
}

// Not with fused multiply-add, which would change the bits.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<T: Task>(task: T) {
    task.run();
}
