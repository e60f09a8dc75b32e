//! `KEY=A,B,C`: the values that a key takes.

/// A key and its values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sweep {
    /// The path of the key, as `--set` takes it.
    pub key: String,
    /// The values, as TOML.
    pub values: Vec<String>,
}

/// More values than are useful for one key.
const MOST_VALUES: usize = 10_000;

impl Sweep {
    /// Reads `KEY=A,B,C`. A value may be a range, `A..B/N`: N values evenly spaced from A to B. Commas in brackets, braces and
    /// quotes belong to a value.
    ///
    /// # Errors
    /// The text is not of the form `KEY=A,B,C`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let equals = outside(text, '=').next();
        let equals = equals.ok_or("there is no `=` in it: expected KEY=A,B,C")?;
        let key = text[..equals].trim();
        if key.is_empty() {
            return Err("a key is missing before the `=`".to_owned());
        }
        let list = &text[equals + 1..];
        let mut values = Vec::new();
        let mut begin = 0;
        for end in outside(list, ',').chain([list.len()]) {
            let value = list[begin..end].trim();
            if value.is_empty() {
                return Err(match list.trim() {
                    "" => "values are missing behind the `=`".to_owned(),
                    _ => "a value is missing between two commas".to_owned(),
                });
            }
            values.extend(range(value)?.unwrap_or_else(|| vec![value.to_owned()]));
            begin = end + 1;
        }
        Ok(Self {
            key: key.to_owned(),
            values,
        })
    }
}

/// The places of a letter outside of quotes and brackets, in bytes.
fn outside(text: &str, wanted: char) -> impl Iterator<Item = usize> + '_ {
    let (mut quote, mut depth) = (None, 0usize);
    text.char_indices().filter_map(move |(at, c)| {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            // An index belongs to the key.
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            _ if c == wanted && depth == 0 => return Some(at),
            _ => {}
        }
        None
    })
}

/// The values of `A..B/N`, if it is one.
fn range(text: &str) -> Result<Option<Vec<String>>, String> {
    let Some((low, rest)) = text.split_once("..") else {
        return Ok(None);
    };
    let wrong =
        || format!("`{text}` is no range: expected A..B/N, N values from A to B, as in 0..0.5/6");
    let Ok(low) = low.trim().parse::<f64>() else {
        // Text with two dots in it.
        return if text.starts_with(['"', '\'', '[', '{']) {
            Ok(None)
        } else {
            Err(wrong())
        };
    };
    let (high, count) = rest.split_once('/').ok_or_else(wrong)?;
    let high: f64 = high.trim().parse().map_err(|_| wrong())?;
    let count: usize = count.trim().parse().map_err(|_| wrong())?;
    if count > MOST_VALUES {
        return Err(format!(
            "`{text}` has {count} values, more than {MOST_VALUES}"
        ));
    }
    if !(low.is_finite() && high.is_finite()) || low == high || !(2..=MOST_VALUES).contains(&count)
    {
        return Err(wrong());
    }
    let at = |k: usize| {
        let share = k as f64 / (count - 1) as f64;
        // Round numbers stay round: 0.1 and not 0.1 + 1e-17.
        mercury_common::readable::rounded(low * (1.0 - share) + high * share, 12)
    };
    Ok(Some((0..count).map(|k| format!("{}", at(k))).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Result<Vec<String>, String> {
        Sweep::parse(text).map(|sweep| sweep.values)
    }

    #[test]
    fn lists_and_ranges() {
        assert_eq!(values("a=1,2.5, x").unwrap(), ["1", "2.5", "x"]);
        assert_eq!(
            values("a=0..0.5/6").unwrap(),
            ["0", "0.1", "0.2", "0.3", "0.4", "0.5"]
        );
        assert_eq!(values("a=1,3..5/3").unwrap(), ["1", "3", "4", "5"]);
        assert_eq!(
            values("gravity=[0,0,-1],[0, 0, -2]").unwrap(),
            ["[0,0,-1]", "[0, 0, -2]"]
        );
        assert_eq!(values("title=\"a,b=c\",'d'").unwrap(), ["\"a,b=c\"", "'d'"]);
        let sweep = Sweep::parse("walls[0].\"a=b\".x = 1e-3").unwrap();
        assert_eq!(
            (sweep.key.as_str(), sweep.values.len()),
            ("walls[0].\"a=b\".x", 1)
        );
    }

    #[test]
    fn slips_are_reported() {
        for (text, part) in [
            ("a", "no `=`"),
            ("=1", "a key is missing"),
            ("a=", "values are missing"),
            ("a=1,,2", "between two commas"),
            ("a=1,", "between two commas"),
            ("a=0..1", "is no range"),
            ("a=0..1/1", "is no range"),
            ("a=0..1/x", "is no range"),
            ("a=1..1/3", "is no range"),
            ("a=0..inf/3", "is no range"),
            ("a=0..1/99999999", "more than 10000"),
        ] {
            let error = values(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
