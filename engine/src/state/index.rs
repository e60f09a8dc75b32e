//! Indices, each a type of its own: a row cannot be used as a body, and a missing index is `None`, not a number.

use std::fmt;
use std::num::NonZeroU32;

use bytemuck::{Pod, Zeroable};

use super::Plain;

macro_rules! index {
    ($(#[$text:meta])* $name:ident) => {
        $(#[$text])*
        // The complement, so that an `Option` of it takes no more memory.
        #[derive(Clone, Copy, PartialEq, Eq, Hash)]
        pub struct $name(NonZeroU32);

        impl $name {
            /// The one with this index, from 0.
            ///
            /// # Panics
            /// From 2^32 - 1 on; no run holds so many.
            #[inline]
            #[must_use]
            pub fn new(index: usize) -> Self {
                let number = u32::try_from(index).map_or(u32::MAX, |index| index);
                match NonZeroU32::new(!number) {
                    Some(complement) => Self(complement),
                    None => panic!("index {index} is beyond 2^32 - 2"),
                }
            }

            /// Its index, from 0.
            #[inline]
            #[must_use]
            pub fn index(self) -> usize {
                self.number() as usize
            }

            /// The index as a number, as columns hold it.
            #[inline]
            #[must_use]
            pub fn number(self) -> u32 {
                !self.0.get()
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}({})", stringify!($name), self.number())
            }
        }

        impl PartialOrd for $name {
            fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
                Some(self.cmp(other))
            }
        }

        impl Ord for $name {
            fn cmp(&self, other: &Self) -> std::cmp::Ordering {
                self.number().cmp(&other.number())
            }
        }

        impl Plain for $name {
            fn put(&self, bytes: &mut Vec<u8>) {
                self.number().put(bytes);
            }

            fn take(bytes: &mut &[u8]) -> Result<Self, String> {
                let number = u32::take(bytes)?;
                let complement = NonZeroU32::new(!number);
                complement.map(Self).ok_or_else(|| format!("{number} is no index"))
            }
        }
    };
}

index! {
    /// Row of a particle; valid until the next sort. In what the contact loop reads in every step rows stay plain numbers.
    Row
}
index! {
    /// Place of a body in [`Bodies::all`](super::Bodies::all); valid until a body leaves.
    BodyIndex
}
index! {
    /// Place of a pebble in [`Bodies::pebbles`](super::Bodies::pebbles); valid until a body leaves.
    PebbleIndex
}

macro_rules! number {
    ($(#[$text:meta])* $name:ident($number:ty)) => {
        $(#[$text])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
        #[repr(transparent)]
        pub struct $name($number);

        impl $name {
            /// The one with this number, from 0.
            #[inline]
            #[must_use]
            pub const fn new(number: $number) -> Self {
                Self(number)
            }

            /// The id as a number, as files and columns hold it.
            #[inline]
            #[must_use]
            pub const fn number(self) -> $number {
                self.0
            }

            /// Its place in a list of all.
            #[inline]
            #[must_use]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }

        impl Plain for $name {
            fn put(&self, bytes: &mut Vec<u8>) {
                self.0.put(bytes);
            }

            fn take(bytes: &mut &[u8]) -> Result<Self, String> {
                <$number>::take(bytes).map(Self)
            }
        }
    };
}

number! {
    /// The number that users see of a particle or body and that files hold: assigned in the order of creation, and never reused.
    Id(u32)
}
number! {
    /// Place of a material in the scene.
    MaterialIndex(u32)
}
number! {
    /// Place of a wall in the scene.
    WallIndex(u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_indices_take_no_room_and_order_is_that_of_the_numbers() {
        assert_eq!(size_of::<Option<Row>>(), 4);
        assert_eq!(
            [0, 7, u32::MAX as usize - 1].map(|k| Row::new(k).index()),
            [0, 7, u32::MAX as usize - 1]
        );
        assert!(Row::new(3) < Row::new(4) && Some(Row::new(0)) > None);
        assert_eq!(format!("{:?}", BodyIndex::new(5)), "BodyIndex(5)");
    }

    #[test]
    #[should_panic(expected = "beyond")]
    fn there_is_no_last_index() {
        let _ = Row::new(u32::MAX as usize);
    }
}
