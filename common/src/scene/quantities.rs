//! Numbers with units in a scene: which key is of which dimension, and `"5 mm"` becomes 0.005 before anything is read.
//!
//! Everything behind this sees SI only: the reader, the plan, what checkpoints keep of the scene.

use super::error::SceneError;
use super::key_path;
use super::keys::{Kind, TableKeys};
use super::laws::{LawKeys, LawPart};
use super::source::SourceSpan;
use super::spelling;
use super::tree::{Entry, Node, Table, Value};
use crate::units::{Dimension, Quantity};

/// Source of the dimensions of the numbers in a value.
#[derive(Clone)]
enum Scope {
    /// Kind of value in the table of keys.
    Value(&'static Kind),
    /// The keys of a table.
    Table(&'static TableKeys),
    /// The keys of a contact law.
    Law(LawPart),
    /// Numbers of one of these units.
    Units(Vec<&'static str>),
    /// A quantity that is not known.
    Any,
}

impl Scope {
    /// Scope of the value at a key of a table.
    fn at_key(&self, table: &Table, key: &str, laws: Option<&[&'static LawKeys]>) -> Option<Self> {
        let of_kind = |kind: &'static Kind| match kind {
            Kind::Law(part, _) => Self::Law(*part),
            kind => Self::Value(kind),
        };
        match self {
            Self::Table(keys) => keys.kind_in(table, key).map(of_kind),
            Self::Value(Kind::Named(keys)) => Some(Self::Table(keys)),
            Self::Value(kind) => kind.table()?.kind_in(table, key).map(of_kind),
            Self::Law(part) => {
                let Some(laws) = laws else {
                    return Some(Self::Any);
                };
                let of_part = || laws.iter().filter(|law| law.parts.contains(part));
                let own = match table.get("law").map(|entry| &entry.node.value) {
                    Some(Value::String(name)) => of_part().find(|law| law.name == *name),
                    _ => None,
                };
                if let Some(key) = own.and_then(|law| law.key(key)) {
                    return Some(Self::Units(vec![key.unit]));
                }
                // A table of [[contacts]] may change single keys without the name of the law.
                let keys = of_part().filter_map(|law| law.key(key));
                let mut units: Vec<&str> = keys.map(|key| key.unit).collect();
                units.sort_unstable();
                units.dedup();
                (!units.is_empty()).then_some(Self::Units(units))
            }
            Self::Units(_) | Self::Any => None,
        }
    }

    /// Scope of an item of a list.
    fn at_index(&self, index: usize) -> Option<Self> {
        let Self::Value(kind) = self else {
            return None;
        };
        Some(match kind.list()? {
            Kind::List(_, of) => Self::Value(of),
            Kind::Row(units) => Self::Units(vec![units.get(index)?]),
            kind => Self::Units(vec![kind.unit()?]),
        })
    }

    /// The dimensions that a number may have; `None` where no number stands.
    fn dimensions(&self) -> Option<Vec<Dimension>> {
        let units = match self {
            Self::Value(Kind::OneOf(all)) => {
                let numbers = all.iter().filter(|kind| matches!(kind, Kind::Number(..)));
                numbers.filter_map(Kind::unit).collect()
            }
            Self::Value(Kind::Number(unit, _)) => vec![*unit],
            Self::Units(units) => units.clone(),
            Self::Any => return Some(Vec::new()),
            Self::Value(_) | Self::Table(_) | Self::Law(_) => return None,
        };
        let dimensions: Vec<Dimension> = units
            .iter()
            .filter_map(|unit| match unit.is_empty() {
                true => Some(Dimension::NUMBER),
                false => Dimension::of_unit(unit),
            })
            .collect();
        (!dimensions.is_empty()).then_some(dimensions)
    }

    /// The unit of the numbers of a value; empty where they have several or none, or it is not known.
    fn unit(&self) -> String {
        let unit = match self {
            Self::Value(kind) => kind.unit().unwrap_or_default(),
            Self::Units(units) if units.len() == 1 => units[0],
            Self::Units(_) | Self::Table(_) | Self::Law(_) | Self::Any => "",
        };
        Dimension::of_unit(unit).map_or_else(String::new, Dimension::symbol)
    }
}

/// A value as TOML writes it, numbers as short as they can be.
fn as_toml(node: &Node) -> String {
    match &node.value {
        Value::String(text) => toml::Value::from(text.as_str()).to_string(),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => format!("{number:?}"),
        Value::Boolean(value) => value.to_string(),
        Value::Datetime | Value::LeftOut => String::new(),
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(as_toml).collect();
            format!("[{}]", items.join(", "))
        }
        Value::Table(table) => {
            let entries = table.entries.iter();
            let entries: Vec<String> = entries
                .map(|entry| {
                    format!(
                        "{} = {}",
                        key_path::quoted(&entry.key),
                        as_toml(&entry.node)
                    )
                })
                .collect();
            format!("{{ {} }}", entries.join(", "))
        }
    }
}

/// A value of the command line as a scene has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SetValue {
    /// `KEY=VALUE` as it was typed.
    pub argument: String,
    /// The unit of its numbers: that of SI, `deg` for keys in degrees; empty where they have none or it is not known.
    pub unit: String,
    /// The value in that unit, as TOML.
    pub value: String,
}

/// Puts SI numbers in the places of texts with units; what is wrong with them goes to `errors`. `keys`: those of the document. `laws`: as
/// for the reader. `given`: what the command line sets, each with its path. Returns these values.
pub(super) fn settle(
    document: &mut Node,
    keys: &'static TableKeys,
    laws: Option<&[&'static LawKeys]>,
    given: &[(&str, String)],
    errors: &mut Vec<SceneError>,
) -> Vec<SetValue> {
    let mut walk = Walk {
        laws,
        errors,
        given,
        set: Vec::new(),
    };
    walk.node(document, "", Some(Scope::Table(keys)));
    walk.set
}

/// Joins the errors of the reader (`read`) with those of units (`wrong`), the latter first: an error of the reader at the place
/// of one of units adds nothing.
pub(super) fn with_units(read: &mut Vec<SceneError>, wrong: Vec<SceneError>) {
    read.retain(|error| {
        !wrong
            .iter()
            .any(|unit| unit.place.key() == error.place.key())
    });
    read.extend(wrong);
}

struct Walk<'a> {
    laws: Option<&'a [&'static LawKeys]>,
    errors: &'a mut Vec<SceneError>,
    given: &'a [(&'a str, String)],
    set: Vec<SetValue>,
}

impl Walk<'_> {
    fn node(&mut self, node: &mut Node, path: &str, scope: Option<Scope>) {
        let name = |node: &Node| node.name().map(str::to_owned);
        match &mut node.value {
            Value::Table(table) => {
                let at = |entry: &Entry| scope.as_ref()?.at_key(table, &entry.key, self.laws);
                let scopes: Vec<Option<Scope>> = table.entries.iter().map(at).collect();
                for (entry, scope) in table.entries.iter_mut().zip(scopes) {
                    self.node(&mut entry.node, &key_path::child(path, &entry.key), scope);
                }
            }
            Value::Array(items) => {
                for (index, item) in items.iter_mut().enumerate() {
                    let scope = scope.as_ref().and_then(|scope| scope.at_index(index));
                    let path = key_path::item(path, index, name(item).as_deref());
                    self.node(item, &path, scope);
                }
            }
            Value::String(text) => {
                let dimensions = scope.as_ref().and_then(Scope::dimensions);
                let settled = dimensions
                    .filter(|_| is_quantity(text))
                    .map(|dimensions| si(text, &dimensions));
                match settled {
                    None => {}
                    Some(Ok(number)) => node.value = Value::Float(number),
                    Some(Err((message, help))) => {
                        let place = SourceSpan::new(&node.source, node.span.clone(), path);
                        let error = place.error(message);
                        self.errors.push(match help {
                            Some(help) => error.with_help(help),
                            None => error,
                        });
                    }
                }
            }
            _ => {}
        }
        // Of several for one key the last holds.
        if let Some((argument, _)) = self.given.iter().rfind(|(_, given)| given == path) {
            self.set.push(SetValue {
                argument: (*argument).to_owned(),
                unit: scope.as_ref().map_or_else(String::new, Scope::unit),
                value: as_toml(node),
            });
        }
    }
}

/// Whether a text is to be a number with a unit: `"auto"` is none, nor is `"1.5d"`, a width in diameters.
fn is_quantity(text: &str) -> bool {
    let text = text.trim();
    let number = text.trim_end_matches('d').trim_end();
    let is_in_diameters = number.len() < text.len() && number.parse::<f64>().is_ok();
    Quantity::is_begun_by(text) && text.parse::<f64>().is_err() && !is_in_diameters
}

/// The number in SI, or a message with its help. `dimensions`: what it may be of; none: anything.
fn si(text: &str, dimensions: &[Dimension]) -> Result<f64, (String, Option<String>)> {
    if let Some(comma) = spelling::decimal_comma(text) {
        let (message, help) = spelling::with_comma(comma);
        return Err((message, Some(help)));
    }
    let first = dimensions.first().copied();
    let help = first.map(|dimension| match dimension {
        Dimension::NUMBER => "write it as a number, or in per cent: \"40 %\"".to_owned(),
        _ => format!(
            "units of {} are {}, and whatever they are made of",
            dimension.words(),
            dimension.units()
        ),
    });
    let quantity = Quantity::parse(text).map_err(|why| {
        let message = if why.starts_with("there is")
            || why.starts_with("nothing")
            || why.starts_with("the unit")
            || why.starts_with('"')
        {
            format!("{text:?}: {why}")
        } else {
            format!("{text:?} {why}")
        };
        (message, help.clone())
    })?;
    let Some(first) = first else {
        return Ok(quantity.si());
    };
    let others = dimensions[1..].iter();
    let read = others.fold(quantity.value(first), |read, other| {
        read.or_else(|_| quantity.value(*other))
    });
    read.map_err(|found| {
        let wanted = first.words();
        (format!("expected {wanted}, got {text:?}, {found}"), help)
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::laws::{Key, LawKeys, LawPart, Range};
    use super::super::source::Source;
    use super::super::{Files, MotionKind, Scene, SceneErrors, Shape, parse_scene};
    use super::*;

    const SCENE: &str = r#"
gravity = [0, 0, "-981 cm/s2"]
time = { end = "1500 ms", step = "10 us" }
domain = { min = [0, 0, 0], max = ["10 cm", "100 mm", 0.2] }
output = { interval = "1 min" }
[materials.glass]
density = "2.5 g/cm3"
[materials.glass.normal]
law = "linear"
stiffness = "2 N/mm"
[[walls]]
shape = "cylinder"
axis = [0, 0, 1]
origin = ["5 cm", 0.05, 0]
radius = "4 cm"
material = "glass"
motion = [
    { kind = "rotation", axis = [0, 0, 1], origin = [0, 0, 0], angular_velocity = "20 rpm", from = "1 ms" },
    { kind = "oscillation", amplitude = [0, 0, "1 mm"], frequency = "3 kHz", phase_degrees = "90 deg" },
    { kind = "servo", axis = [0, 0, 1], force = [["10 ms", "2 kN"], [2, 5]], max_speed = "1 mm/s" },
]
"#;

    fn read(text: &str, overrides: &[&str]) -> Result<Scene, SceneErrors> {
        let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
        parse_scene(Path::new("a.toml"), text, &overrides, Files::Unchecked)
    }

    #[test]
    fn what_is_read_is_si() {
        let scene = read(SCENE, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(scene.gravity.z, -9.81);
        assert_eq!(*scene.time.end, 1.5);
        assert_eq!(*scene.domain.max, glam::dvec3(0.1, 0.1, 0.2));
        assert_eq!(*scene.output.interval, 60.0);
        assert_eq!(*scene.materials[0].density, 2500.0);
        let Shape::Cylinder { radius, origin, .. } = &scene.walls[0].shape else {
            panic!("a cylinder");
        };
        assert_eq!((**radius, origin.x), (0.04, 0.05));
        let MotionKind::Rotation {
            angular_velocity, ..
        } = &scene.walls[0].motion[0].kind
        else {
            panic!("a rotation");
        };
        assert_eq!(**angular_velocity, 20.0 * 2.0 / 60.0 * std::f64::consts::PI);
        let kinds = format!("{:?}", scene.walls[0].motion);
        assert!(kinds.contains("[[0.01, 2000.0], [2.0, 5.0]]"), "{kinds}");
        // Checkpoints keep SI values of the scene, and the keys of laws are SI as well.
        let entries = scene.statement.entries().unwrap();
        assert_eq!(entries["materials.glass.normal.stiffness"], "2000");
        assert_eq!(entries["time.end"], "1.5");
    }

    #[test]
    fn numbers_without_unit_may_be_in_per_cent() {
        let text = SCENE.replace(
            "stiffness = \"2 N/mm\"",
            "stiffness = 1\nrestitution = \"35 %\"",
        );
        let scene = read(&text, &["guard.way=70%"]).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(*scene.guard.way, 0.7);
        // Without the tables of laws nothing is known of their units, and any is taken.
        let entries = scene.statement.entries().unwrap();
        assert_eq!(entries["materials.glass.normal.restitution"], "0.35");
        let errors = read(SCENE, &["guard.way=7 mm"]).unwrap_err().to_string();
        let message = "guard.way: expected a number without unit, got \"7 mm\", a length";
        assert!(errors.contains(message), "{errors}");
        assert!(
            errors.contains("help: write it as a number, or in per cent: \"40 %\""),
            "{errors}"
        );
        // A length in per cent is none.
        let errors = read(SCENE, &["walls.0.radius=7 %"])
            .unwrap_err()
            .to_string();
        assert!(
            errors.contains("expected a length, got \"7 %\", a number without unit"),
            "{errors}"
        );
    }

    /// In quotes, and from the command line, where no quotes are needed.
    #[test]
    fn decimal_commas_are_named() {
        for (text, argument) in [
            (SCENE.replacen("\"4 cm\"", "\"0,5\"", 1), None),
            (SCENE.replacen("\"4 cm\"", "\"0,5 mm\"", 1), None),
            (SCENE.to_owned(), Some("walls.0.radius=0,5")),
            (SCENE.to_owned(), Some("walls.0.radius=0,5 mm")),
            (SCENE.to_owned(), Some("guard.way=0,5")),
        ] {
            let arguments: Vec<&str> = argument.into_iter().collect();
            let errors = read(&text, &arguments).unwrap_err();
            assert_eq!(errors.0.len(), 1, "{errors}");
            let errors = errors.to_string();
            assert!(errors.contains("` has a comma"), "{errors}");
            assert!(
                errors.contains("help: decimals stand behind a point: 0.5"),
                "{errors}"
            );
        }
    }

    #[test]
    fn the_command_line_takes_units_too() {
        let scene = read(SCENE, &["time.end=3 min", "walls[0].radius=\"2 cm\""]).unwrap();
        assert_eq!(*scene.time.end, 180.0);
    }

    #[test]
    fn what_the_command_line_sets_has_its_unit() {
        let arguments = [
            "walls.0.radius=2 cm",
            "walls.wall-1.motion.0.angular_velocity=10 rpm",
            "walls.0.motion.1.phase_degrees=0.5 rev",
            "gravity=[0, \"1 cm/s2\", -1]",
            "materials.glass.normal.stiffness=3",
            "seed=7",
            "title=5 m",
        ];
        let text = SCENE.replace("shape =", "name = \"wall-1\"\nshape =");
        let scene = read(&text, &arguments).unwrap_or_else(|errors| panic!("{errors}"));
        let mut found: Vec<(&str, &str, &str)> = (scene.set.iter())
            .map(|set| (set.argument.as_str(), set.value.as_str(), set.unit.as_str()))
            .collect();
        let speed = format!("{:?}", 10.0 * 2.0 / 60.0 * std::f64::consts::PI);
        let mut expected = [
            (arguments[0], "0.02", "m"),
            (arguments[1], speed.as_str(), "rad/s"),
            (arguments[2], "180.0", "deg"),
            (arguments[3], "[0, 0.01, -1]", "m/s2"),
            // Without the tables of laws nothing is known of their units.
            (arguments[4], "3", ""),
            (arguments[5], "7", ""),
            (arguments[6], "\"5 m\"", ""),
        ];
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected);
    }

    /// Two laws of a part may have a key of one name in different units.
    #[test]
    fn a_key_of_a_law_has_the_unit_of_that_law() {
        const ONE: [Key; 1] = [Key::new("dissipation", "kg/s", Range::NonNegative, "")];
        const OTHER: [Key; 1] = [Key::new("dissipation", "Pa s", Range::NonNegative, "")];
        const fn law(name: &'static str, keys: &'static [Key]) -> LawKeys {
            LawKeys {
                parts: &[LawPart::Normal],
                name,
                keys,
                ..LawKeys::NONE
            }
        }
        static LAWS: [LawKeys; 2] = [law("one", &ONE), law("other", &OTHER)];
        let [one, other] = LAWS.each_ref();
        let found = |name: &str| {
            let text = format!("law = \"{name}\"\ndissipation = 1");
            let source = Source::file("laws.toml".to_owned(), &text, &Files::Unchecked);
            let document = super::super::tree::parse_document(&source, &text).unwrap();
            let Value::Table(table) = &document.value else {
                panic!("a table");
            };
            let scope = Scope::Law(LawPart::Normal);
            let laws = [one, other];
            let of = scope.at_key(table, "dissipation", Some(&laws));
            of.unwrap().dimensions().unwrap()
        };
        let dimension = |unit| Dimension::of_unit(unit).unwrap();
        assert_eq!(found("one"), [dimension("kg/s")]);
        assert_eq!(found("other"), [dimension("Pa s")]);
        // Where the law is not named it may be either.
        assert_eq!(found("neither"), ["Pa s", "kg/s"].map(dimension));
    }

    /// Units and numbers state the same scene.
    #[test]
    fn a_scene_in_other_units_is_the_same_scene() {
        let si = SCENE
            .replace("\"10 cm\", \"100 mm\"", "0.1, 0.1")
            .replace("\"1500 ms\"", "1.5")
            .replace("\"2.5 g/cm3\"", "2500");
        let entries = |text: &str| read(text, &[]).unwrap().statement.entries().unwrap();
        assert_eq!(entries(SCENE), entries(&si));
    }

    #[test]
    fn what_is_of_something_else_is_refused_by_name() {
        for (from, to, message) in [
            (
                "\"4 cm\"",
                "\"5 kg\"",
                "a.toml:15:10: walls.wall-1.radius: expected a length, got \"5 kg\", a mass\n",
            ),
            (
                "\"4 cm\"",
                "\"5 parsec\"",
                "walls[0].radius: \"5 parsec\": there is no unit \"parsec\"\n",
            ),
            (
                "\"20 rpm\"",
                "\"20 Hz\"",
                "motion[0].angular_velocity: expected an angular velocity, got \"20 Hz\", a frequency\n",
            ),
            (
                "\"2 kN\"",
                "\"2 kPa\"",
                "force[0][1]: expected a force, got \"2 kPa\", a pressure\n",
            ),
            (
                "\"10 ms\"",
                "\"10 mm\"",
                "force[0][0]: expected a time, got \"10 mm\", a length\n",
            ),
            (
                "\"1500 ms\"",
                "\"1500\"",
                "time.end: expected a number, got a string",
            ),
        ] {
            let errors = read(&SCENE.replacen(from, to, 1), &[])
                .unwrap_err()
                .to_string();
            let message = message.replace("a.toml:15:10: walls.wall-1", "walls[0]");
            assert!(errors.contains(&message), "{errors}\nlacks {message}");
            assert_eq!(errors.matches("a.toml:").count(), 1, "{errors}");
        }
        let errors = read(&SCENE.replacen("\"4 cm\"", "\"5 kg\"", 1), &[]).unwrap_err();
        let help = "units of a length are m, cm, mm, um, nm, km, and whatever they are made of";
        assert!(errors.to_string().contains(help), "{errors}");
    }
}
