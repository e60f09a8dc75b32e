//! Reads the tables that name a contact law, by the laws' own tables of keys.

use super::cursor::Fields;
use super::item::Item;
use super::laws::{Given, Key, KeyDefault, Law, LawKeys, LawPart, LawValues, Range};
use super::source::Located;
use super::spelling::nearest;
use super::tree::Value;

/// The laws of a part that the reader was given, by name; `None` if it was given no laws at all.
pub(super) fn known(
    fields: &Fields<'_>,
    part: LawPart,
) -> Option<Vec<(&'static str, &'static LawKeys)>> {
    let laws = fields.context.laws.as_ref()?;
    let of_part = laws.iter().filter(|law| law.parts.contains(&part));
    Some(of_part.map(|law| (law.name, *law)).collect())
}

/// The law that an item names.
pub(super) fn named(
    item: &Item<'_>,
    part: LawPart,
    known: &[(&str, &'static LawKeys)],
) -> Option<&'static LawKeys> {
    item.word(&format!("{} law", part.word()), known)
}

/// The law of a material.
pub(super) fn read(item: &Item<'_>, part: LawPart) -> Option<Law> {
    let fields = item.table()?;
    let law = fields.need("law")?;
    let place = item.place.clone();
    let Some(known) = known(&fields, part) else {
        let name = law.text()?;
        let values = unjudged(&fields);
        return Some(Law {
            name,
            values,
            place,
        });
    };
    let keys = named(&law, part, &known)?;
    let values = values(&fields, keys, true);
    fields.finish();
    Some(Law {
        name: law.text()?,
        values,
        place,
    })
}

/// All numbers and words of a table, for programs without laws.
pub(super) fn unjudged(fields: &Fields<'_>) -> LawValues {
    let mut values = LawValues::default();
    for (key, item) in fields.entries() {
        let value = match &item.node.value {
            Value::Float(number) => Given::Number(*number),
            Value::Integer(number) => Given::Number(*number as f64),
            Value::String(word) => Given::Word(word.clone()),
            _ => continue,
        };
        let place = item.place;
        values.push(&key, Located { value, place });
    }
    values
}

/// The values of a law; `whole`: with everything that it needs.
pub(super) fn values(fields: &Fields<'_>, keys: &LawKeys, whole: bool) -> LawValues {
    let mut values = LawValues::default();
    // All keys are read before a missing one is reported: a misspelt key is then known as such.
    for key in keys.keys {
        match fields.get(key.name) {
            Some(item) => {
                if let Some(value) = read_value(&item, key) {
                    values.push(key.name, value);
                }
            }
            None => {
                if let (true, KeyDefault::Number(number)) = (whole, key.default) {
                    let default = fields.default(key.name, Given::Number(number));
                    values.push(key.name, default);
                }
            }
        }
    }
    for key in keys.keys {
        if whole && key.default == KeyDefault::Needed && !keys.is_choice(key.name) {
            fields.need(key.name);
        }
        if let (Range::NotBelow(other), true) = (key.range, whole) {
            check_order(fields, &values, key.name, other);
        }
    }
    choose(fields, keys, whole);
    values
}

fn read_value(item: &Item<'_>, key: &Key) -> Option<Located<Given>> {
    let word = |word: &str| Located {
        value: Given::Word(word.to_owned()),
        place: item.place.clone(),
    };
    if let Range::Words(words) = key.range {
        let words: Vec<(&str, &str)> = words.iter().map(|word| (*word, *word)).collect();
        return item.word(&key.name.replace('_', " "), &words).map(word);
    }
    if let (KeyDefault::Word(default, _), true) = (key.default, item.is_text()) {
        return item.keyword(default).map(|()| word(default));
    }
    let number = item.number_in(key.range);
    number.map(|number| number.map(Given::Number))
}

/// Reports a number that lies below that of another key.
fn check_order(fields: &Fields<'_>, values: &LawValues, key: &str, other: &str) {
    let (Some(upper), Some(lower)) = (values.get(key), values.get(other)) else {
        return;
    };
    if let (Given::Number(high), Given::Number(low)) = (&upper.value, &lower.value)
        && high < low
    {
        fields.context.report(upper.error(format!(
            "must be >= {other} = {}, got {}",
            lower.place.text(),
            upper.place.text()
        )));
    }
}

/// Reports keys that exclude each other, and of each choice those that are missing to the way that was taken; none is missing
/// where only some keys are replaced, unless they have no meaning without the others.
fn choose(fields: &Fields<'_>, keys: &LawKeys, whole: bool) {
    // Keys that the ways taken so far need, and the key that each of these ways is known by.
    let mut needed: Vec<(&str, &str)> = Vec::new();
    for (index, ways) in keys.choices.iter().enumerate() {
        let demanded = |way: &&[&str]| {
            let by = |key: &str| needed.iter().find(|(name, _)| *name == key);
            by(way[0]).map(|(_, by)| *by)
        };
        let by_demand = ways.iter().position(|way| demanded(way).is_some());
        let taken = by_demand
            .or_else(|| ways.iter().rposition(|way| fields.has(way[0])))
            .or_else(|| {
                ways.iter().rposition(|way| {
                    way.iter()
                        .any(|key| is_own(keys, index, key) && fields.has(key))
                })
            });
        let Some(taken) = taken else {
            if whole {
                miss(fields, ways);
            }
            continue;
        };
        let way = ways[taken];
        let by = demanded(&way).unwrap_or(way[0]);
        for other in ways.iter().filter(|other| other[0] != way[0]) {
            for key in *other {
                // A key that also stands in another choice is excluded by its own.
                if !way.contains(key) && (*key == other[0] || is_own(keys, index, key)) {
                    fields.excluded(key, by);
                }
            }
        }
        if whole || taken > 0 {
            for &key in way {
                if by_demand.is_none() {
                    fields.need(key);
                }
            }
            needed.extend(way[1..].iter().map(|key| (*key, way[0])));
        }
    }
}

/// Whether a key stands in no other choice than this one.
fn is_own(keys: &LawKeys, index: usize, key: &str) -> bool {
    let mut others = keys.choices.iter().enumerate();
    !others.any(|(other, ways)| other != index && ways.iter().any(|way| way.contains(&key)))
}

/// Reports that no way was taken. A misspelt key is reported once, as unknown.
fn miss(fields: &Fields<'_>, ways: &[&[&str]]) {
    let all = || ways.iter().copied().flatten().copied();
    if fields.unasked().any(|key| nearest(key, all()).is_some()) {
        return;
    }
    let has_lists = ways.iter().any(|way| way.len() > 1);
    let ways: Vec<String> = ways
        .iter()
        .map(|way| {
            let keys: Vec<String> = way.iter().map(|key| format!("`{key}`")).collect();
            match keys.split_last() {
                Some((last, first)) if !first.is_empty() => {
                    format!("{} and {last}", first.join(", "))
                }
                _ => keys.concat(),
            }
        })
        .collect();
    let between = if has_lists { ", or " } else { " or " };
    let message = format!("needs {}", ways.join(between));
    fields.context.report(fields.place().error(message));
}
