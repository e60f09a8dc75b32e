//! A law that is chosen at run time: of any part of a contact.

/// A law that may be one of those of `Any`.
pub trait OneOf<Any>: Copy {
    /// The law, if it is this one.
    fn of(any: Any) -> Option<Self>;
}

/// The history of an [`any_law`], which is that of one law or not yet any.
pub(super) trait Holds<Law, L> {
    /// Memory of the law.
    type Own;

    /// That of this law; a new one, if this is of no law.
    fn own(&self) -> Self::Own;

    /// Of what the law remembers.
    fn hold(own: Self::Own) -> Self;
}

/// The enum of the laws of one part (`None` for the law without effect, where there is one), and the enum of their histories: a
/// contact has space for the largest of them, and uses that of its own law.
macro_rules! any_law {
    ($part:ident: $any:ident remembers $history:ident { $([None = $none:ident])? $($variant:ident($law:ident)),* }) => {
        #[doc = concat!("One of the laws that are a [`", stringify!($part), "`].")]
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[allow(missing_docs)]
        pub enum $any {
            $(#[doc = concat!("[`", stringify!($none), "`]")] None,)?
            $($variant($law),)*
        }

        impl $any {
            /// How many laws it is one of.
            pub const COUNT: usize = [$(stringify!($none),)? $(stringify!($variant)),*].len();
        }

        #[doc = concat!("What the law of an [`", stringify!($any), "`] remembers.")]
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        #[allow(missing_docs)]
        pub enum $history<L: $crate::lanes::Real = f64> {
            /// The law has not been evaluated yet.
            #[default]
            Empty,
            $($variant(<$law as $part>::History<L>),)*
        }

        $(impl $crate::contact::OneOf<$any> for $none {
            fn of(any: $any) -> Option<Self> {
                (any == $any::None).then_some($none)
            }
        })?

        $(impl $crate::contact::OneOf<$any> for $law {
            fn of(any: $any) -> Option<Self> {
                match any {
                    $any::$variant(law) => Some(law),
                    _ => None,
                }
            }
        })*

        $(impl<L: $crate::lanes::Real> $crate::contact::any::Holds<$law, L> for $history<L> {
            type Own = <$law as $part>::History<L>;

            #[inline(always)]
            fn own(&self) -> Self::Own {
                match self {
                    Self::$variant(own) => *own,
                    _ => Default::default(),
                }
            }

            #[inline(always)]
            fn hold(own: Self::Own) -> Self {
                Self::$variant(own)
            }
        })*

        impl $crate::contact::OneOf<$any> for $any {
            fn of(any: $any) -> Option<Self> {
                Some(any)
            }
        }

        impl<L: $crate::lanes::Real> $crate::contact::History<L> for $history<L> {
            type One = $history;
            /// The number of the law, and space for the longest history.
            const LENGTH: usize = {
                let mut longest = 0;
                $(
                    let length = <<$law as $part>::History<L> as $crate::contact::History<L>>::LENGTH;
                    if length > longest {
                        longest = length;
                    }
                )*
                1 + longest
            };

            fn columns() -> Vec<$crate::contact::HistoryNumber> {
                let length = <Self as $crate::contact::History<L>>::LENGTH;
                let mut columns = vec![("1", "number in the history of the law"); length];
                columns[0] = ("1", "law");
                columns
            }

            fn swapped(self) -> Self {
                match self {
                    Self::Empty => Self::Empty,
                    $(Self::$variant(history) => Self::$variant($crate::contact::History::<L>::swapped(history)),)*
                }
            }

            fn write(&self, numbers: &mut Vec<L>) {
                let end = numbers.len() + <Self as $crate::contact::History<L>>::LENGTH;
                match self {
                    Self::Empty => {}
                    $(Self::$variant(history) => {
                        numbers.push(L::splat(f64::from(Number::$variant as u8)));
                        $crate::contact::History::<L>::write(history, numbers);
                    })*
                }
                numbers.resize(end, L::ZERO);
            }

            fn show(&self, numbers: &mut Vec<L>) {
                match self {
                    Self::Empty => {}
                    $(Self::$variant(history) => $crate::contact::History::<L>::show(history, numbers),)*
                }
            }

            fn read(numbers: &[L]) -> Self {
                $(if numbers[0] == L::splat(f64::from(Number::$variant as u8)) {
                    return Self::$variant($crate::contact::History::<L>::read(&numbers[1..]));
                })*
                Self::Empty
            }

            #[inline(always)]
            fn gather(one: impl Fn(usize) -> $history) -> Self {
                $(if (0..L::LANES).any(|k| matches!(one(k), $history::$variant(_))) {
                    let own = |k| $crate::contact::any::Holds::<$law, f64>::own(&one(k));
                    return Self::$variant($crate::contact::History::<L>::gather(own));
                })*
                Self::Empty
            }

            #[inline(always)]
            fn lane(&self, k: usize) -> $history {
                match self {
                    Self::Empty => $history::Empty,
                    $(Self::$variant(history) => $history::$variant($crate::contact::History::<L>::lane(history, k)),)*
                }
            }
        }

        /// In saved histories; 0 stands for none.
        enum Number {
            #[allow(dead_code)]
            Empty,
            $($variant,)*
        }
    };
}
pub(super) use any_law;

#[cfg(test)]
mod tests {
    use crate::contact::tangential::{AnyTangentialHistory, StoredForce};
    use crate::contact::{History, TangentialSpring};
    use crate::lanes::Vector;

    #[test]
    fn saved_histories_come_back_with_their_law() {
        let spring = TangentialSpring(Vector::new(1.0, -2.0, 3.0));
        let stored = StoredForce {
            force: Vector::new(4.0, 5.0, -6.0),
            contact_radius: 7.0,
        };
        for history in [
            AnyTangentialHistory::Empty,
            AnyTangentialHistory::Linear(spring),
            AnyTangentialHistory::Mindlin(spring),
            AnyTangentialHistory::MindlinRescaled(stored),
        ] {
            let mut numbers = Vec::new();
            history.write(&mut numbers);
            assert_eq!(numbers.len(), <AnyTangentialHistory as History>::LENGTH);
            assert_eq!(<AnyTangentialHistory as History>::read(&numbers), history);
            assert_eq!(history.swapped().swapped(), history);
        }
    }
}
