//! The JSON schema of a scene (draft 2020-12), from the tables of keys: for completion and checks in editors.
//!
//! It checks less than the reader: rules between two keys, names and files are not in it.

use mercury_common::scene::keys::{
    Absent, Choice, Kind, SceneKey, TableKeys, Variant, Variants, readable,
};
use mercury_common::scene::{KeyDefault, LawKeys, LawPart, Range, SCENE};
use serde_json::{Map, Value, json};

use mercury_engine::contact::law_keys;

/// The schema of a scene.
#[must_use]
pub fn schema() -> Value {
    let mut schema = Schema::default();
    let mut root = schema.table(&SCENE, "scene");
    for part in LawPart::ALL {
        for whole in [true, false] {
            schema
                .definitions
                .insert(law_name(part, whole), law(part, whole));
        }
    }
    root["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    root["title"] = json!("A scene of mercury-solve");
    root["$defs"] = Value::Object(schema.definitions);
    root
}

/// The tables below the scene, each defined once.
#[derive(Default)]
struct Schema {
    definitions: Map<String, Value>,
    /// Tables that have a definition, with its name.
    known: Vec<(&'static TableKeys, String)>,
}

impl Schema {
    /// A reference to a table, named by the keys that lead to it when it is met first.
    fn reference(&mut self, keys: &'static TableKeys, path: &str) -> Value {
        let known = self
            .known
            .iter()
            .find(|(other, _)| std::ptr::eq(*other, keys));
        let name = known.map_or(path.to_owned(), |(_, name)| name.clone());
        if known.is_none() {
            self.known.push((keys, name.clone()));
            let table = self.table(keys, path);
            self.definitions.insert(name.clone(), table);
        }
        json!({ "$ref": format!("#/$defs/{name}") })
    }

    fn table(&mut self, keys: &'static TableKeys, path: &str) -> Value {
        let variants: Vec<&'static Variant> = keys.variants().collect();
        let mut table = match variants.as_slice() {
            [] => self.object(keys, None, path),
            [_, ..] => {
                let objects: Vec<Value> = variants
                    .into_iter()
                    .map(|variant| self.object(keys, Some(variant), path))
                    .collect();
                json!({ "type": "object", "oneOf": objects })
            }
        };
        if !keys.choices.is_empty() {
            table["allOf"] = keys.choices.iter().map(choice).collect();
        }
        table
    }

    /// The table with the keys of a variant.
    fn object(
        &mut self,
        keys: &'static TableKeys,
        variant: Option<&'static Variant>,
        path: &str,
    ) -> Value {
        let mut properties = Map::new();
        let mut required = Vec::new();
        for key in keys.of(variant) {
            properties.insert(key.name.to_owned(), self.key(key, path));
            // Another key decides whether the one that stands for a variant is needed.
            if matches!(key.absent, Absent::Needed) {
                required.push(key.name);
            }
        }
        let mut title = None;
        if let Some(variant) = variant {
            title = Some(variant.text);
            if let Variants::Word { key, absent, .. } = keys.variants
                && !absent.is_some_and(|absent| std::ptr::eq(absent, variant))
            {
                let word = json!({ "const": variant.name, "description": variant.text });
                properties.insert(key.to_owned(), word);
                required.push(key);
            }
        }
        let mut object = json!({
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": false,
        });
        if let Some(title) = title {
            object["title"] = json!(readable(title));
        }
        object
    }

    fn key(&mut self, key: &'static SceneKey, path: &str) -> Value {
        let path = match path {
            "scene" => key.name.to_owned(),
            _ => format!("{path}.{}", key.name),
        };
        let mut value = self.kind(&key.kind, &path);
        let unit = key.kind.unit().filter(|unit| !unit.is_empty());
        let unit = unit.map(|unit| format!("in {unit}"));
        let default = match key.absent.text() {
            text if text.is_empty() => None,
            text => Some(format!("default: {}", readable(&text))),
        };
        let text = Some(readable(key.text)).filter(|text| !text.is_empty());
        let parts: Vec<String> = [text, unit, default].into_iter().flatten().collect();
        if !parts.is_empty() {
            value["description"] = json!(parts.join("; "));
        }
        value
    }

    fn kind(&mut self, kind: &'static Kind, path: &str) -> Value {
        match kind {
            Kind::Number(unit, range) => number(unit, *range),
            Kind::Whole(low, high) => {
                let mut whole = json!({ "type": "integer", "minimum": low });
                // Up to the largest whole number of TOML there is no bound to speak of.
                if *high <= i64::MAX as u64 {
                    whole["maximum"] = json!(high);
                }
                whole
            }
            Kind::Flag => json!({ "type": "boolean" }),
            Kind::Word(..) => json!({ "enum": kind.words() }),
            Kind::Keyword(word) => json!({ "const": word }),
            Kind::Diameters => json!({ "type": "string", "pattern": "^[0-9.eE+-]+ *d$" }),
            Kind::Numbers(unit, count, range) => list(number(unit, *range), *count),
            Kind::Row(units) => {
                let items: Vec<Value> = units.iter().map(|unit| number(unit, Range::Any)).collect();
                json!({ "type": "array", "prefixItems": items, "items": false, "minItems": items.len() })
            }
            Kind::Components(unit) => {
                let free = json!({ "const": "free" });
                list(json!({ "anyOf": [number(unit, Range::Any), free] }), 3)
            }
            Kind::Interval(unit) => list(number(unit, Range::Any), 2),
            Kind::Direction => list(number("", Range::Any), 3),
            Kind::Line | Kind::Text => json!({ "type": "string" }),
            Kind::Name | Kind::File(_) | Kind::Folder | Kind::Material | Kind::Clump => {
                json!({ "type": "string", "minLength": 1 })
            }
            Kind::List(what, of) => {
                let least = usize::from(!what.is_empty());
                json!({ "type": "array", "items": self.kind(of, path), "minItems": least })
            }
            Kind::Table(keys) => self.reference(keys, path),
            Kind::Named(keys) => {
                let table = self.reference(keys, path);
                json!({ "type": "object", "additionalProperties": table })
            }
            Kind::Texts => {
                json!({ "type": "object", "additionalProperties": { "type": "string" } })
            }
            Kind::Law(part, whole) => {
                json!({ "$ref": format!("#/$defs/{}", law_name(*part, *whole)) })
            }
            Kind::OneOf(all) => {
                let all: Vec<Value> = all.iter().map(|kind| self.kind(kind, path)).collect();
                json!({ "anyOf": all })
            }
        }
    }
}

/// List of so many of an item.
fn list(item: Value, count: usize) -> Value {
    json!({ "type": "array", "items": item, "minItems": count, "maxItems": count })
}

/// A number of a range; where it has a unit, a text with another one may stand, too, and else a text in per cent.
fn number(unit: &str, range: Range) -> Value {
    let mut number = match unit {
        "" => json!({ "type": ["number", "string"], "pattern": "^[ \\t]*[-+]?[0-9.eE+-]+ *%$" }),
        _ => json!({ "type": ["number", "string"], "pattern": "^[ \\t]*[-+]?[0-9.]" }),
    };
    let bounds: &[(&str, f64)] = match range {
        Range::Any => &[],
        Range::Positive | Range::NotBelow(_) => &[("exclusiveMinimum", 0.0)],
        Range::NonNegative => &[("minimum", 0.0)],
        Range::Fraction => &[("minimum", 0.0), ("maximum", 1.0)],
        Range::PoissonRatio => &[("exclusiveMinimum", -1.0), ("maximum", 0.5)],
        Range::Between(low, high) => &[("minimum", low), ("maximum", high)],
        Range::Above(low, high) => &[("exclusiveMinimum", low), ("maximum", high)],
        Range::Below(low, high) => &[("minimum", low), ("exclusiveMaximum", high)],
        Range::Inside(low, high) => &[("exclusiveMinimum", low), ("exclusiveMaximum", high)],
        Range::Over(low) => &[("exclusiveMinimum", low)],
        Range::Words(words) => return json!({ "enum": words }),
    };
    for (bound, value) in bounds {
        number[*bound] = json!(value);
    }
    number
}

/// At most one of the keys, or exactly one.
fn choice(choice: &Choice) -> Value {
    let mut ways: Vec<Value> = choice
        .keys
        .iter()
        .map(|key| json!({ "required": [key] }))
        .collect();
    if !choice.needed {
        let none = json!({ "not": { "anyOf": ways.clone() } });
        ways.push(none);
    }
    json!({ "oneOf": ways })
}

fn law_name(part: LawPart, whole: bool) -> String {
    let part = part.word();
    match whole {
        true => format!("law.{part}"),
        false => format!("contacts.{part}"),
    }
}

/// A table that names a law of a part; or, not `whole`, one that replaces some keys of it.
fn law(part: LawPart, whole: bool) -> Value {
    let laws = law_keys()
        .into_iter()
        .filter(|law| law.parts.contains(&part));
    let objects: Vec<Value> = laws.map(|law| law_table(law, whole)).collect();
    // Without its name, keys may be those of several laws.
    let how = if whole { "oneOf" } else { "anyOf" };
    json!({ "type": "object", how: objects })
}

fn law_table(law: &'static LawKeys, whole: bool) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    let name = json!({ "const": law.name, "description": law.text });
    properties.insert("law".to_owned(), name);
    if whole {
        required.push("law");
    }
    for key in law.keys {
        let mut value = number(key.unit, key.range);
        let default = match key.default {
            KeyDefault::Needed => String::new(),
            KeyDefault::Number(number) => format!("; default: {number}"),
            KeyDefault::Open(then) => format!("; default: {then}"),
            KeyDefault::Word(word, meaning) => {
                if !matches!(key.range, Range::Words(_)) {
                    value = json!({ "anyOf": [value, { "const": word }] });
                }
                format!("; default: {word} {meaning}").trim_end().to_owned()
            }
        };
        let unit = match key.unit {
            "" => String::new(),
            unit => format!("; in {unit}"),
        };
        value["description"] = json!(readable(&format!("{}{unit}{default}", key.text)));
        properties.insert(key.name.to_owned(), value);
        if whole && key.default == KeyDefault::Needed && !law.is_choice(key.name) {
            required.push(key.name);
        }
    }
    let mut table = json!({
        "type": "object",
        "title": law.text,
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    });
    if whole && !law.choices.is_empty() {
        let of_choice = |ways: &&[&[&str]]| {
            let ways: Vec<Value> = ways.iter().map(|way| json!({ "required": way })).collect();
            json!({ "anyOf": ways })
        };
        table["allOf"] = law.choices.iter().map(of_choice).collect();
    }
    table
}
