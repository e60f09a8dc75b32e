//! Values of the document, read by the table of keys.

use std::path::PathBuf;

use glam::DVec3;

use super::item::Item;
use super::keys::{Kind, Word};
use super::laws::Range;
use super::source::{Located, SourceSpan};
use super::{ClumpIndex, MaterialIndex};

/// Type that is read from a value of the scene.
pub(super) trait FromItem: Sized {
    /// Reads a value; reports what is wrong.
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self>;
}

/// Type that is read from a key of the scene.
pub(super) trait FromKey: FromItem {
    /// Placeholder for a value that is wrong or missing, until all mistakes are collected. No scene has it: a scene with mistakes
    /// is refused. Numbers are not a number, so that no rule between two keys reports them.
    fn placeholder(place: &SourceSpan) -> Self;

    /// The value of a key that is left out and has no default.
    fn absent() -> Option<Self> {
        None
    }
}

impl<T: FromItem> FromItem for Located<T> {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        Some(item.located(T::from_item(item, kind)?))
    }
}

impl<T: FromKey> FromKey for Located<T> {
    fn placeholder(place: &SourceSpan) -> Self {
        Self {
            value: T::placeholder(place),
            place: place.clone(),
        }
    }
}

impl<T: FromItem> FromItem for Option<T> {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        Some(Some(T::from_item(item, kind)?))
    }
}

impl<T: FromItem> FromKey for Option<T> {
    fn placeholder(_: &SourceSpan) -> Self {
        None
    }

    fn absent() -> Option<Self> {
        Some(None)
    }
}

impl<T: FromItem> FromItem for Vec<T> {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let items = item.list()?;
        let Kind::List(what, of) = kind.pick(item.node) else {
            return None;
        };
        if items.is_empty() && !what.is_empty() {
            item.report(format!("must list at least one {what}"));
            return None;
        }
        let read: Vec<Option<T>> = items.iter().map(|item| T::from_item(item, of)).collect();
        read.into_iter().collect()
    }
}

impl<T: FromItem> FromKey for Vec<T> {
    fn placeholder(_: &SourceSpan) -> Self {
        Vec::new()
    }
}

impl<T: Word> FromItem for T {
    fn from_item(item: &Item<'_>, _: &'static Kind) -> Option<Self> {
        item.word(T::WHAT, T::WORDS)
    }
}

impl<T: Word> FromKey for T {
    fn placeholder(_: &SourceSpan) -> Self {
        T::WORDS[0].1
    }
}

/// The range of the numbers of a kind.
fn range(item: &Item<'_>, kind: &'static Kind) -> Range {
    match kind.pick(item.node) {
        Kind::Number(_, range) | Kind::Numbers(_, _, range) => *range,
        _ => Range::Any,
    }
}

impl FromItem for f64 {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        Some(item.number_in(range(item, kind))?.value)
    }
}

impl FromKey for f64 {
    fn placeholder(_: &SourceSpan) -> Self {
        f64::NAN
    }
}

impl FromItem for u64 {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let (low, high) = match kind {
            Kind::Whole(low, high) => (*low, *high),
            _ => (0, u64::MAX),
        };
        let number = item.whole(low)?.value;
        if number > high {
            item.report(format!("must be <= {high}, got {number}"));
            return None;
        }
        Some(number)
    }
}

impl FromKey for u64 {
    fn placeholder(_: &SourceSpan) -> Self {
        0
    }
}

impl FromItem for bool {
    fn from_item(item: &Item<'_>, _: &'static Kind) -> Option<Self> {
        item.boolean()
    }
}

impl FromKey for bool {
    fn placeholder(_: &SourceSpan) -> Self {
        false
    }
}

impl<const N: usize> FromItem for [f64; N] {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let numbers = item.numbers::<N>()?.value;
        let range = range(item, kind);
        if !numbers.iter().all(|number| range.holds(*number)) {
            let (rule, got) = (range.rule(), item.place.text());
            item.report(format!("must {rule} in each component, got {got}"));
            return None;
        }
        if matches!(kind.pick(item.node), Kind::Interval(_)) && numbers[0] >= numbers[1] {
            let got = item.place.text();
            item.report(format!("must be [low, high] with low < high, got {got}"));
            return None;
        }
        Some(numbers)
    }
}

impl<const N: usize> FromKey for [f64; N] {
    fn placeholder(_: &SourceSpan) -> Self {
        [f64::NAN; N]
    }
}

impl FromItem for DVec3 {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        match kind {
            Kind::Direction => Some(item.direction()?.value),
            _ => <[f64; 3]>::from_item(item, kind).map(DVec3::from_array),
        }
    }
}

impl FromKey for DVec3 {
    fn placeholder(_: &SourceSpan) -> Self {
        DVec3::NAN
    }
}

impl FromItem for String {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let text = match kind {
            Kind::Name => item.name(),
            Kind::Line => item.line(),
            _ => item.text(),
        };
        Some(text?.value)
    }
}

impl FromKey for String {
    fn placeholder(_: &SourceSpan) -> Self {
        String::new()
    }
}

impl FromItem for PathBuf {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let path = match kind {
            Kind::Folder => item.folder(),
            Kind::File(help) if !help.is_empty() => item.file_or(help),
            _ => item.file(),
        };
        Some(path?.value)
    }
}

impl FromKey for PathBuf {
    fn placeholder(_: &SourceSpan) -> Self {
        PathBuf::new()
    }
}

impl FromItem for MaterialIndex {
    fn from_item(item: &Item<'_>, _: &'static Kind) -> Option<Self> {
        Some(item.material()?.value)
    }
}

impl FromKey for MaterialIndex {
    fn placeholder(_: &SourceSpan) -> Self {
        MaterialIndex(0)
    }
}

impl FromItem for ClumpIndex {
    fn from_item(item: &Item<'_>, _: &'static Kind) -> Option<Self> {
        Some(item.clump()?.value)
    }
}

impl FromKey for ClumpIndex {
    fn placeholder(_: &SourceSpan) -> Self {
        ClumpIndex(0)
    }
}

/// Three numbers, or `"free"` in the place of any.
impl FromItem for [Option<f64>; 3] {
    fn from_item(item: &Item<'_>, _: &'static Kind) -> Option<Self> {
        let items = item.list()?;
        if items.len() != 3 {
            let got = items.len();
            item.report(format!("expected 3 numbers or \"free\", got {got}"));
            return None;
        }
        let mut components = [None; 3];
        for (component, item) in components.iter_mut().zip(items) {
            match item.is_text() {
                true => item.keyword("free")?,
                false => *component = Some(item.number()?.value),
            }
        }
        Some(components)
    }
}

impl FromKey for [Option<f64>; 3] {
    fn placeholder(_: &SourceSpan) -> Self {
        [None; 3]
    }
}

/// Anything, for items that the caller reads.
pub(super) struct Untyped;

impl FromItem for Untyped {
    fn from_item(_: &Item<'_>, _: &'static Kind) -> Option<Self> {
        Some(Self)
    }
}
