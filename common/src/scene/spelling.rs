//! The nearest spelling of a word that is not known.

use strsim::osa_distance;

/// Words of the field and of other programs, in small letters without spaces and dashes, and ours for the same thing: the first that
/// is a candidate.
#[rustfmt::skip]
const SYNONYMS: &[(&[&str], &[&str])] = &[
    (&["hertzmindlin", "mindlinhertz", "hertzmindlinnoslip", "hm", "hertzian"], &["hertz", "mindlin"]),
    (&["hooke", "hookean", "springdashpot", "linearspringdashpot", "linearspring", "lsd", "cundallstrack"], &["linear"]),
    (&["mindlinderesiewicz", "mindlindeseriewicz"], &["mindlin"]),
    (&["coulomb", "friction", "history"], &["linear", "mindlin"]),
    (&["elastoplastic", "hysteretic", "waltonbraun", "thornton", "thorntonning", "luding", "lineartohysteretic"], &["plastic"]),
    (&["epsd", "epsd2", "irs", "cdt", "rollingfriction", "rollingresistance"], &["luding"]),
    (&["vibration", "vibrate", "vibrating", "shake", "shaking", "sine", "sinusoidal", "harmonic", "wiggle", "oscillate"], &["oscillation"]),
    (&["rotate", "rotating", "spin", "turn"], &["rotation"]),
    (&["translate", "move", "linearmotion"], &["translation"]),
    (&["forcecontrol", "controlled", "pressure", "load"], &["servo"]),
    (&["stl", "obj", "triangles", "trimesh", "cad", "geometry"], &["mesh"]),
    (&["cube", "cuboid", "block"], &["box"]),
    (&["floor", "infiniteplane"], &["plane"]),
    (&["drum", "pipe", "tube"], &["cylinder"]),
    (&["hopper", "funnel", "frustum"], &["cone"]),
    (&["ball"], &["sphere"]),
    (&["gaussian", "gauss"], &["normal"]),
    (&["mono", "constant", "singlesize"], &["monodisperse"]),
    (&["weibull", "rrsb", "rosinrammlersperlingbennett"], &["rosin-rammler"]),
    (&["gatesgaudinschuhmann", "schuhmann"], &["ggs"]),
    (&["sieve", "sieves", "custom"], &["file", "classes"]),
    (&["porosity", "voidage", "voidfraction", "packingfraction", "packingdensity", "solidsfraction", "solidvolumefraction"], &["solid_fraction", "volume_fraction"]),
    (&["youngmodulus", "elasticmodulus"], &["youngs_modulus"]),
    (&["poisson", "poissonsratio", "nu"], &["poisson_ratio"]),
    (&["cor", "coefficientofrestitution", "restitutioncoefficient"], &["restitution"]),
    (&["mu", "cof", "coefficientoffriction", "frictioncoefficient"], &["friction"]),
    (&["rho"], &["density"]),
    (&["kn", "springconstant"], &["stiffness"]),
    (&["omega", "rotationspeed", "angularvelocity"], &["angular_velocity"]),
    (&["dt", "timestep"], &["step"]),
    (&["duration", "endtime", "tend", "runtime"], &["end"]),
    (&["centre", "center"], &["origin", "position"]),
];

/// The candidate that is meant by `word`: a synonym, or the nearest one if it is near enough to be a slip of the keyboard, with an
/// edit distance (insert, delete, replace, swap of neighbours) of at most a third of the longer word (at least 1).
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let length = word.chars().count();
    if let Some(synonym) = synonym(word, &candidates) {
        return Some(synonym);
    }
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

/// The candidate that is another word for `word`.
fn synonym<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    // Longer than any of the list; there may be a megabyte of garbage.
    if word.len() > 40 {
        return None;
    }
    let is_letter = |c: &char| !" -_".contains(*c);
    let plain: String = word
        .chars()
        .filter(is_letter)
        .flat_map(char::to_lowercase)
        .collect();
    let (_, ours) = SYNONYMS
        .iter()
        .find(|(words, _)| words.contains(&plain.as_str()))?;
    let mut ours = ours.iter();
    ours.find_map(|ours| {
        candidates
            .iter()
            .find(|candidate| *candidate == ours)
            .copied()
    })
}

/// `a`, `b` and `c`, for lists in messages.
pub fn listed<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    words.into_iter().collect::<Vec<_>>().join(", ")
}

/// The text without spaces around it, if it begins with a number whose decimals stand behind a comma: `0,5`, `-1,5e3`, `0,5 mm`.
pub(super) fn decimal_comma(text: &str) -> Option<&str> {
    let text = text.trim();
    let (whole, rest) = text
        .strip_prefix(['-', '+'])
        .unwrap_or(text)
        .split_once(',')?;
    let is_number = !whole.is_empty() && whole.bytes().all(|b| b.is_ascii_digit());
    let behind = rest.trim_start_matches(|c: char| c.is_ascii_digit());
    (is_number && behind.len() < rest.len() && !behind.starts_with([',', '.'])).then_some(text)
}

/// Message for a number with a comma, and help with the number to write.
pub(super) fn with_comma(text: &str) -> (String, String) {
    let point = text.replacen(',', ".", 1);
    (
        format!("`{text}` has a comma"),
        format!("decimals stand behind a point: {point}"),
    )
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
    fn words_of_other_programs_lead_to_ours() {
        for (word, candidates, ours) in [
            (
                "Hertz-Mindlin",
                &["linear", "hertz", "plastic"][..],
                "hertz",
            ),
            ("hertz_mindlin", &["linear", "mindlin"], "mindlin"),
            ("Hooke", &["linear", "hertz", "plastic"], "linear"),
            (
                "vibration",
                &["translation", "rotation", "oscillation"],
                "oscillation",
            ),
            ("porosity", &["mass", "solid_fraction"], "solid_fraction"),
            ("STL", &["box", "plane", "mesh"], "mesh"),
        ] {
            assert_eq!(
                nearest(word, candidates.iter().copied()),
                Some(ours),
                "{word}"
            );
        }
        // Nothing is meant that does not exist here.
        assert_eq!(nearest("vibration", ["x", "y"]), None);
        // Each entry leads to words that the format has, or that results and fields have.
        for (words, ours) in SYNONYMS {
            for word in *words {
                assert_eq!(nearest(word, ours.iter().copied()), Some(ours[0]), "{word}");
            }
        }
    }

    #[test]
    fn decimals_behind_a_comma_are_seen() {
        for (text, found) in [
            ("0,5", true),
            (" -1,5e3 ", true),
            ("0,5 mm", true),
            ("1,2,3", false),
            ("1,000.5", false),
            ("1, 2", false),
            (",5", false),
            ("a,5", false),
            ("0.5", false),
        ] {
            assert_eq!(decimal_comma(text).is_some(), found, "{text}");
        }
    }
}
