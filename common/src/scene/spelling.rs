//! The nearest spelling of a word that is not known.

/// The candidate nearest to `word`, if it is near enough to be a slip of the keyboard: an edit
/// distance of at most a third of the longer word (at least 1).
pub(super) fn nearest<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
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
            let distance = edit_distance(&word.to_lowercase(), &candidate.to_lowercase());
            (distance <= limit && distance < longest).then_some((distance, candidate))
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// Edits (insert, delete, replace, swap of neighbours) that turn `a` into `b`: the restricted
/// Damerau-Levenshtein distance (Damerau 1964, doi:10.1145/363958.363994).
fn edit_distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().collect();
    let b: Vec<char> = b.chars().collect();
    let mut before_last: Vec<usize> = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let replace = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = replace.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before_last[j - 2] + 1);
            }
        }
        before_last = last;
        last = row;
    }
    last[b.len()]
}

/// `a`, `b` and `c`, for lists in messages.
pub(super) fn listed<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
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

    #[test]
    fn distances_are_those_of_the_definition() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("ab", "ba"), 1);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("grün", "grun"), 1);
    }
}
