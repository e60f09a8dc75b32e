//! The nearest spelling of a word that is not known.

use strsim::osa_distance;

/// The candidate nearest to `word`, if it is near enough to be a slip of the keyboard: an edit distance (insert, delete,
/// replace, swap of neighbours) of at most a third of the longer word (at least 1).
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = word.chars().count();
    candidates
        .into_iter()
        .filter_map(|candidate| {
            let longest = length.max(candidate.chars().count());
            // Words whose lengths differ by more than the limit cannot be near: no table is filled
            // for a megabyte of garbage.
            let limit = (longest / 3).max(1);
            if longest - length.min(candidate.chars().count()) > limit {
                return None;
            }
            let distance = osa_distance(&word.to_lowercase(), &candidate.to_lowercase());
            (distance <= limit && distance < longest).then_some((distance, candidate))
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// `a`, `b` and `c`, for lists in messages.
pub fn listed<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    words.into_iter().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_of_the_keyboard_are_found() {
        let keys = ["friction", "static_friction", "stiffness", "law"];
        assert_eq!(nearest("frictoin", keys), Some("friction"));
        assert_eq!(nearest("Friction", keys), Some("friction"));
        assert_eq!(nearest("stifness", keys), Some("stiffness"));
        assert_eq!(nearest("lwa", keys), Some("law"));
        assert_eq!(nearest("colour", keys), None);
        assert_eq!(nearest("", keys), None);
    }
}
