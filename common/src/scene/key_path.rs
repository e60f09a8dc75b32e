//! Key paths as users write and read them: `materials.glass.density`, `walls.pipe.axis`,
//! `particles[3].radius`.

/// A step of a path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Step {
    Key(String),
    Index(usize),
}

/// A key, quoted where it is no bare key of TOML.
pub(super) fn quoted(key: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !key.is_empty() && key.chars().all(is_bare) {
        key.to_owned()
    } else {
        format!("{key:?}")
    }
}

/// The path of a key inside the table at `path`.
pub(super) fn child(path: &str, key: &str) -> String {
    if path.is_empty() {
        quoted(key)
    } else {
        format!("{path}.{}", quoted(key))
    }
}

/// The path of an item of the list at `path`: by its name where it has one.
pub(super) fn item(path: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) => child(path, name),
        None => format!("{path}[{index}]"),
    }
}

/// The steps of a path as typed, and the number of bytes up to the `=` that ends it.
///
/// # Errors
/// Says in words what is wrong with the path.
pub(super) fn parse(text: &str) -> Result<(Vec<Step>, usize), String> {
    let mut steps = Vec::new();
    let mut characters = text.char_indices().peekable();
    let mut wants_key = true;
    loop {
        let Some(&(at, c)) = characters.peek() else {
            return Err("there is no `=` in it".to_owned());
        };
        match c {
            '=' if wants_key => return Err("a key is missing before the `=`".to_owned()),
            '=' => return Ok((steps, at)),
            ' ' => {
                characters.next();
            }
            '.' if wants_key => return Err("a key is missing between two dots".to_owned()),
            '.' => {
                characters.next();
                wants_key = true;
            }
            '[' if wants_key => return Err("a key is missing before the `[`".to_owned()),
            '[' => {
                characters.next();
                let digits: String = std::iter::from_fn(|| {
                    characters
                        .next_if(|(_, c)| c.is_ascii_digit())
                        .map(|(_, c)| c)
                })
                .collect();
                let closed = characters.next_if(|&(_, c)| c == ']').is_some();
                match digits.parse() {
                    Ok(index) if closed => steps.push(Step::Index(index)),
                    _ => return Err("an index is written [0], [1], ...".to_owned()),
                }
            }
            _ if !wants_key => return Err(format!("a dot is missing before `{c}`")),
            '"' | '\'' => {
                characters.next();
                let mut key = String::new();
                loop {
                    match characters.next() {
                        None => return Err("a quoted key does not end".to_owned()),
                        Some((_, end)) if end == c => break,
                        Some((_, '\\')) if c == '"' => {
                            key.extend(characters.next().map(|(_, escaped)| escaped));
                        }
                        Some((_, other)) => key.push(other),
                    }
                }
                steps.push(Step::Key(key));
                wants_key = false;
            }
            _ => {
                let key: String = std::iter::from_fn(|| {
                    characters
                        .next_if(|(_, c)| !".=[\"' ".contains(*c))
                        .map(|(_, c)| c)
                })
                .collect();
                if key.is_empty() {
                    return Err(format!("`{c}` cannot stand in a key"));
                }
                steps.push(Step::Key(key));
                wants_key = false;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(name: &str) -> Step {
        Step::Key(name.to_owned())
    }

    #[test]
    fn paths_parse() {
        assert_eq!(parse("time.end=1"), Ok((vec![key("time"), key("end")], 8)));
        assert_eq!(
            parse("walls[2].\"a b\" = 1"),
            Ok((vec![key("walls"), Step::Index(2), key("a b")], 15))
        );
        for bad in [
            "", "a", "=1", "a..b=1", "a[x]=1", "a[1=1", "\"a=1", "a b=1", ".a=1",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn written_paths_read_back() {
        let path = item(&child("", "regions"), 0, Some("upper \"half\""));
        let (steps, _) = parse(&format!("{path}=1")).expect("a written path is a path");
        assert_eq!(steps, vec![key("regions"), key("upper \"half\"")]);
    }
}
