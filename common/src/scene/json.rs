//! Documents in JSON (RFC 8259) as the tree: what Python's `json.dumps` writes is read as the same scene in TOML would be.

use std::collections::HashSet;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use jsonc_parser::ast::{ObjectProp, Value as Json};
use jsonc_parser::common::Ranged;
use jsonc_parser::errors::ParseError;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};

use super::error::{SceneError, SceneErrors};
use super::source::{Source, SourceSpan};
use super::tree::{Entry, Node, Table, Value};

/// Lists and objects inside each other, as many as TOML may have.
const MOST_DEEP: usize = 80;

/// JSON as it is standardised: without comments, trailing commas, `NaN` and the like.
const STRICT: ParseOptions = ParseOptions {
    allow_comments: false,
    allow_loose_object_property_names: false,
    allow_trailing_commas: false,
    allow_missing_commas: false,
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// Whether a text is to be read as JSON: its name ends in `.json`, or it begins with a brace, as no TOML document does.
#[must_use]
pub fn is_json(name: &str, text: &str) -> bool {
    let ending = Path::new(name).extension();
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case("json"))
        || without_mark(text).trim_start().starts_with('{')
}

/// The text without a mark of byte order, which JSON does not allow and some editors write.
fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// Parses a document. Of syntax errors the first is reported, of values that no scene has all.
pub(super) fn parse_document(source: &Arc<Source>, text: &str) -> Result<Node, SceneErrors> {
    let json = without_mark(text);
    let mut reader = Reader {
        source,
        skipped: text.len() - json.len(),
        depth: 0,
        errors: Vec::new(),
    };
    let parsed = parse_to_ast(json, &CollectOptions::default(), &STRICT)
        .map_err(|error| reader.syntax_error(&error, json))?;
    let node = match &parsed.value {
        Some(value @ Json::Object(_)) => Node {
            span: 0..0,
            ..reader.node(value, "")
        },
        Some(other) => {
            let error = reader.at(other.range(), "").error("this is no JSON object");
            return Err(error
                .with_help("a scene is an object: { \"time\": ... }")
                .into());
        }
        None => {
            let place = SourceSpan::new(source, 0..0, "");
            return Err(place.error("the file is empty").into());
        }
    };
    match reader.errors.is_empty() {
        true => Ok(node),
        false => {
            reader.errors.sort_by_key(|error| error.place.order());
            Err(SceneErrors(reader.errors))
        }
    }
}

/// A document as text in JSON. Dates, which no key takes, are null.
pub(super) fn write_document(node: &Node, out: &mut String) {
    match &node.value {
        Value::String(text) => push_string(text, out),
        Value::Integer(number) => *out += &number.to_string(),
        // JSON has no infinity: a number beyond the largest is read as one.
        Value::Float(number) if number.is_infinite() => {
            *out += if *number > 0.0 { "1e999" } else { "-1e999" }
        }
        Value::Float(number) => *out += &format!("{number:?}"),
        Value::Boolean(value) => *out += if *value { "true" } else { "false" },
        Value::Datetime | Value::LeftOut => *out += "null",
        Value::Array(items) => {
            out.push('[');
            for (place, item) in items.iter().enumerate() {
                out.push_str(if place > 0 { ", " } else { "" });
                write_document(item, out);
            }
            out.push(']');
        }
        Value::Table(table) => {
            out.push('{');
            for (place, entry) in table.entries.iter().enumerate() {
                out.push_str(if place > 0 { ", " } else { "" });
                push_string(&entry.key, out);
                out.push_str(": ");
                write_document(&entry.node, out);
            }
            out.push('}');
        }
    }
}

/// Appends a string of JSON.
fn push_string(text: &str, out: &mut String) {
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => *out += "\\\"",
            '\\' => *out += "\\\\",
            c if c < ' ' => *out += &format!("\\u{:04x}", u32::from(c)),
            c => out.push(c),
        }
    }
    out.push('"');
}

struct Reader<'a> {
    source: &'a Arc<Source>,
    /// Bytes in front of the JSON.
    skipped: usize,
    depth: usize,
    errors: Vec<SceneError>,
}

impl Reader<'_> {
    fn span(&self, range: jsonc_parser::common::Range) -> Range<usize> {
        range.start + self.skipped..range.end + self.skipped
    }

    fn at(&self, range: jsonc_parser::common::Range, key: &str) -> SourceSpan {
        SourceSpan::new(self.source, self.span(range), key)
    }

    fn syntax_error(&self, error: &ParseError, text: &str) -> SceneError {
        let range = error.range();
        let place = self.at(range, "");
        let found = text.get(range.start..range.end).unwrap_or_default();
        let rest = text.get(range.start..).unwrap_or_default();
        let word: String = (rest.chars().skip_while(|c| *c == '-'))
            .take_while(|c| c.is_alphanumeric())
            .collect();
        let words = error.kind().to_string();
        let mut letters = words.chars();
        let first = letters.next().map(|c| c.to_ascii_lowercase());
        let words: String = first.into_iter().chain(letters).collect();
        let error = place.error(format!("not valid JSON: {words}"));
        match word.as_str() {
            "NaN" | "Infinity" => error.with_help("JSON has no NaN and no infinity"),
            "None" => error.with_help("leave the key out where there is no value"),
            "True" => error.with_help("it is written `true`"),
            "False" => error.with_help("it is written `false`"),
            _ if found.starts_with('\'') => error.with_help("text goes in double quotes"),
            _ => error,
        }
    }

    fn node(&mut self, value: &Json<'_>, path: &str) -> Node {
        self.depth += 1;
        let node = Node {
            value: self.value(value, path),
            source: Arc::clone(self.source),
            span: self.span(value.range()),
        };
        self.depth -= 1;
        node
    }

    fn value(&mut self, value: &Json<'_>, path: &str) -> Value {
        if self.depth > MOST_DEEP {
            let message = format!("lists and objects are more than {MOST_DEEP} deep");
            self.errors
                .push(self.at(value.range(), path).error(message));
            return Value::Boolean(false);
        }
        match value {
            Json::StringLit(text) => Value::String(text.value.clone().into_owned()),
            Json::NumberLit(number) => self::number(number.value),
            Json::BooleanLit(boolean) => Value::Boolean(boolean.value),
            Json::NullKeyword(null) => {
                let error = self.at(null.range, path).error("is null");
                let help = "leave the key out where there is no value";
                self.errors.push(error.with_help(help));
                Value::Boolean(false)
            }
            Json::Array(array) => {
                let items = array.elements.iter().enumerate();
                let items = items.map(|(index, item)| self.node(item, &format!("{path}[{index}]")));
                Value::Array(items.collect())
            }
            Json::Object(object) => {
                let mut known = HashSet::new();
                let mut entries = Vec::with_capacity(object.properties.len());
                for property in &object.properties {
                    let key = property.name.as_str();
                    let path = super::key_path::child(path, key);
                    if !known.insert(key) {
                        let place = self.at(property.name.range(), &path);
                        self.errors.push(place.error("is given twice"));
                    }
                    entries.push(self.entry(property, &path));
                }
                Value::Table(Table { entries })
            }
        }
    }

    fn entry(&mut self, property: &ObjectProp<'_>, path: &str) -> Entry {
        Entry {
            key: property.name.as_str().to_owned(),
            source: Arc::clone(self.source),
            span: self.span(property.name.range()),
            node: self.node(&property.value, path),
        }
    }
}

/// A whole number; as a float where it has a point or an exponent, or is beyond 64 bits.
fn number(text: &str) -> Value {
    match text.parse() {
        Ok(whole) => Value::Integer(whole),
        Err(_) => Value::Float(text.parse().unwrap_or(f64::NAN)),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use crate::scene::{Files, Scene, SceneErrors, parse_clump, parse_psd, parse_scene};

    const SCENE: &str = r#"{
  "title": "two µm \"balls\"",
  "gravity": [0, 0, "-981 cm/s2"],
  "time": {"end": 1.5, "step": 1e-3},
  "domain": {"min": [0, 0, 0], "max": [1, 1.0, 1e0]},
  "output": {"interval": 0.1, "data": false},
  "materials": {"glass": {"density": 2500, "normal": {"law": "linear", "stiffness": 1000.0, "dissipation": 0}}},
  "particles": [{"name": "a", "material": "glass", "radius": 0.1, "position": [0.5, 0.5, 0.5]}]
}
"#;

    const SAME: &str = r#"
title = "two µm \"balls\""
gravity = [0, 0, -9.81]
[time]
end = 1.5
step = 0.001
[domain]
min = [0, 0, 0]
max = [1, 1, 1]
[output]
interval = 0.1
data = false
[materials.glass]
density = 2500
normal = { law = "linear", stiffness = 1e3, dissipation = 0 }
[[particles]]
name = "a"
material = "glass"
radius = 0.1
position = [0.5, 0.5, 0.5]
"#;

    fn read(name: &str, text: &str, overrides: &[&str]) -> Result<Scene, SceneErrors> {
        let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
        parse_scene(Path::new(name), text, &overrides, Files::Unchecked)
    }

    #[test]
    fn json_and_toml_state_the_same_scene() {
        let entries = |text: &str, overrides: &[&str]| {
            let scene = read("a.json", text, overrides).unwrap_or_else(|errors| panic!("{errors}"));
            scene.statement.entries().unwrap()
        };
        let toml = read("a.toml", SAME, &["time.end=2 s"]).unwrap();
        let toml = toml.statement.entries().unwrap();
        assert_eq!(entries(SCENE, &["time.end=2 s"]), toml);
        // By its first letter, too, whatever the name, and behind a mark of byte order.
        let marked = format!("\u{feff}{SCENE}");
        let scene = read("a.toml", &marked, &["time.end=2 s"]).unwrap();
        assert_eq!(scene.statement.entries().unwrap(), toml);
        assert_eq!(scene.title, "two µm \"balls\"");
    }

    #[test]
    fn mistakes_have_their_place() {
        let mut wrong = String::new();
        for (from, to, message) in [
            (
                "\"radius\": 0.1",
                "\"radius\": -0.1",
                "a.json:8:62: particles.a.radius: must be > 0, got -0.1\n      \"particles\": [",
            ),
            (
                "\"radius\": 0.1",
                "\"radios\": 0.1",
                "a.json:8:52: particles.a.radios: is not a known key\n",
            ),
            (
                "\"end\": 1.5",
                "\"end\": null",
                "a.json:4:19: time.end: is null\n      \"time\": {\"end\": null, \"step\": 1e-3},\n                      ^^^^\nhelp: leave the key out",
            ),
            (
                "\"end\": 1.5",
                "\"end\": 1.5, \"end\": 2",
                "a.json:4:24: time.end: is given twice\n",
            ),
            (
                "\"end\": 1.5",
                "\"end\": NaN",
                "a.json:4:19: not valid JSON: unexpected token\n      \"time\": {\"end\": NaN, \"step\": 1e-3},\n                      ^^^\nhelp: JSON has no NaN and no infinity",
            ),
            (
                "\"end\": 1.5",
                "\"end\": -Infinity",
                "a.json:4:19: not valid JSON: infinity and NaN are not allowed\n",
            ),
            (
                "\"end\": 1.5",
                "'end': 1.5",
                "a.json:4:12: not valid JSON: single-quoted strings are not allowed\n",
            ),
            (
                "\"end\": 1.5,",
                "\"end\": 1.5",
                "a.json:4:22: not valid JSON: expected comma\n",
            ),
            (
                "1e-3},",
                "1e-3,},",
                "a.json:4:36: not valid JSON: trailing commas are not allowed\n",
            ),
            (
                "\"data\": false",
                "\"data\": False",
                "help: it is written `false`",
            ),
            (
                "\"data\": false",
                "\"data\": 0.1e400",
                "a.json:6:39: output.data: expected true or false, got a number\n",
            ),
            ("{\"min\": [0, 0, 0]", "[", "not valid JSON"),
        ] {
            let errors = read("a.json", &SCENE.replacen(from, to, 1), &[])
                .unwrap_err()
                .to_string();
            if !errors.contains(message) {
                wrong += &format!("{errors}\nlacks {message}\n\n");
            }
        }
        assert!(wrong.is_empty(), "{wrong}");
        for (text, message) in [
            ("", "a.json: the file is empty"),
            ("[1]", "a.json:1:1: this is no JSON object\n"),
            (
                "{} {}",
                "a.json:1:4: not valid JSON: text cannot contain more than one JSON value\n",
            ),
            ("{", "a.json:1:1: not valid JSON: unterminated object\n"),
            ("time = 1", "a.json:1:1: not valid JSON: unexpected word\n"),
        ] {
            let errors = read("a.json", text, &[]).unwrap_err().to_string();
            assert!(errors.starts_with(message), "{errors}\nis not {message}");
        }
        let deep = format!("{{\"a\": {}1{}}}", "[".repeat(200), "]".repeat(200));
        let errors = read("a.json", &deep, &[]).unwrap_err().to_string();
        assert!(errors.contains("more than 80 deep"), "{errors}");
        let deeper = "{\"a\": ".repeat(100_000);
        assert!(read("a.json", &deeper, &[]).is_err());
    }

    #[test]
    fn laws_and_clumps_may_be_json_too() {
        let law = r#"{"kind": "lognormal", "median_diameter": "1 mm", "sigma": 0.3, "weighting": "volume"}"#;
        assert!(parse_psd("law.toml", law, None).is_ok());
        let errors = parse_clump(Path::new("a.clump.toml"), "{\"name\": 1}").unwrap_err();
        assert!(
            errors.to_string().starts_with("a.clump.toml:1:"),
            "{errors}"
        );
    }

    proptest! {
        #[test]
        fn no_text_makes_a_panic(text in "[{}\\[\\]\":,a-c0-9.eE+ \n-]{0,60}") {
            let _ = read("a.json", &text, &[]);
        }

        /// A number is the one that its digits are, as it is in TOML.
        #[test]
        fn numbers_are_read_to_the_bit(value in prop::num::f64::NORMAL) {
            let text = SCENE.replace("-981 cm/s2", "x").replace("\"x\"", &format!("{value:e}"));
            let scene = read("a.json", &text, &[]).unwrap();
            prop_assert_eq!(scene.gravity.z.to_bits(), value.to_bits());
        }
    }
}
