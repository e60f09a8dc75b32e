//! `[[insertions]]`: particles that come during the run.

use std::path::PathBuf;

use glam::DVec3;

use super::cursor::Fields;
use super::item::Item;
use super::psd::{self, Psd};
use super::region::{self, Region};
use super::source::{Located, Place};
use super::walls::interval;
use super::{ClumpIndex, MaterialIndex};

/// A source of particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Insertion {
    /// Unique among insertions; random choices follow from it and the seed.
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: Place,
    /// Where particles appear; they lie wholly inside.
    pub region: Located<Region>,
    /// What appears; at least one.
    pub mixture: Vec<Component>,
    /// What the shares of the mixture are shares of; default mass.
    pub share_by: Quantity,
    /// How sizes follow the distributions; default random.
    pub method: Located<Method>,
    /// When it is done; none: only `until` ends it (a rate is then given).
    pub total: Option<Located<Total>>,
    /// How fast; none: as fast as they fit.
    pub rate: Option<Located<Rate>>,
    /// Mean velocity, m/s; default 0.
    pub velocity_mean: Located<DVec3>,
    /// Uniform deviation of each component, +-, m/s; default 0.
    pub velocity_spread: Located<DVec3>,
    /// Start, s; default 0.
    pub from: Located<f64>,
    /// End, s; none: never.
    pub until: Option<Located<f64>>,
    /// Consecutive failed placements per step before it waits for the next step; default 1000.
    pub attempts: Located<u64>,
}

/// One ingredient of a mixture.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Where the entry stands.
    pub place: Place,
    /// What it is made of.
    pub body: Body,
    /// Its sizes; a clump's size is the diameter of a sphere of equal volume. None: a clump comes in its own size.
    pub psd: Option<Located<Psd>>,
    /// Its share, scaled such that all shares of the mixture sum to 1.
    pub share: f64,
    /// Its share as it is written.
    pub stated_share: f64,
    /// Volume of the liquid film on each grain, m^3; that of a clump is spread over its pebbles. Default 0, in a mixture that of the
    /// insertion.
    pub film_volume: Located<f64>,
}

/// What an inserted body is.
#[derive(Debug, Clone, PartialEq)]
pub enum Body {
    /// Spheres of a material.
    Sphere(Located<MaterialIndex>),
    /// Copies of a clump.
    Clump(Located<ClumpIndex>),
}

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Particles.
    Number,
    /// kg
    Mass,
    /// m3
    Volume,
}

/// How sizes follow a distribution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// Class by class.
    Quota,
    /// Drawn independently.
    Random,
}

/// When an insertion is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Total {
    /// After so many particles.
    Number(u64),
    /// After so much mass, kg.
    Mass(f64),
    /// After so much volume of particles, m3.
    Volume(f64),
    /// When nothing fits any more.
    Full,
}

/// How fast particles come.
#[derive(Debug, Clone, PartialEq)]
pub enum Rate {
    /// Particles per second.
    Number(f64),
    /// kg/s
    Mass(f64),
    /// m3/s
    Volume(f64),
    /// A table `t,cumulative`, resolved against the folder of the scene.
    Table(PathBuf),
}

const QUANTITIES: [(&str, Quantity); 3] = [
    ("number", Quantity::Number),
    ("mass", Quantity::Mass),
    ("volume", Quantity::Volume),
];

/// Reads an entry of `[[insertions]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Insertion> {
    let fields = item.table()?;
    let name = fields.name_or_number();
    let region = fields.need("region").and_then(|item| region::read(&item));
    let mixture = read_mixture(&fields);
    let share_by = fields
        .get("share_by")
        .and_then(|item| item.word("quantity", &QUANTITIES))
        .unwrap_or(Quantity::Mass);
    let method = match fields.get("method") {
        Some(item) => {
            let words = [("quota", Method::Quota), ("random", Method::Random)];
            item.word("method", &words).map(|value| Located {
                value,
                place: item.place.clone(),
            })
        }
        None => Some(fields.default("method", Method::Random)),
    };
    let total = if fields.has("rate") {
        fields.get("total")
    } else {
        fields.need("total")
    };
    let total = total.map(|item| read_total(&item));
    let rate = fields.get("rate").and_then(|item| read_rate(&item));
    let velocity = fields.get("velocity").and_then(|item| item.table());
    let (velocity_mean, velocity_spread) = match velocity {
        Some(velocity) => {
            let mean = match velocity.get("mean") {
                Some(item) => item.vector(),
                None => Some(velocity.default("mean", DVec3::ZERO)),
            };
            let spread = match velocity.get("spread") {
                Some(item) => read_spread(&item),
                None => Some(velocity.default("spread", DVec3::ZERO)),
            };
            velocity.finish();
            (mean, spread)
        }
        None => (
            Some(fields.default("velocity", DVec3::ZERO)),
            Some(fields.default("velocity", DVec3::ZERO)),
        ),
    };
    let (from, until) = interval(&fields);
    let attempts = match fields.get("attempts") {
        Some(item) => item.whole(1),
        None => Some(fields.default("attempts", 1000)),
    };
    fields.finish();
    Some(Insertion {
        name: name?,
        place: item.place.clone(),
        region: region?,
        mixture: mixture?,
        share_by,
        method: method?,
        total: match total {
            Some(total) => Some(total?),
            None => None,
        },
        rate,
        velocity_mean: velocity_mean?,
        velocity_spread: velocity_spread?,
        from: from?,
        until,
        attempts: attempts?,
    })
}

fn read_spread(item: &Item<'_>) -> Option<Located<DVec3>> {
    let spread = item.vector()?;
    if spread.min_element() < 0.0 {
        item.report(format!(
            "must be >= 0 in each component, got {}",
            item.place.text()
        ));
        return None;
    }
    Some(spread)
}

fn read_mixture(fields: &Fields<'_>) -> Option<Vec<Component>> {
    if !fields.exactly_one(&["material", "clump", "mixture"], true) {
        for key in ["material", "clump", "mixture", "psd", "film_volume"] {
            fields.get(key);
        }
        return None;
    }
    for key in ["material", "clump"] {
        fields.get(key);
    }
    let film_volume = read_film(fields, || fields.default("film_volume", 0.0));
    let Some(item) = fields.get("mixture") else {
        let body = read_body(fields);
        let psd = read_sizes(fields);
        let place = fields.place().clone();
        return Some(vec![Component {
            place,
            body: body?,
            psd: psd?,
            share: 1.0,
            stated_share: 1.0,
            film_volume: film_volume?,
        }]);
    };
    let of_all = film_volume.clone();
    // Where it is wrong, entries are read all the same, so that all mistakes are named at once.
    let of_all = of_all.unwrap_or_else(|| fields.default("film_volume", 0.0));
    let items = item.list()?;
    if items.is_empty() {
        item.report("must list at least one component");
        return None;
    }
    let read: Vec<Option<Component>> = (items.iter())
        .map(|item| read_component(item, &of_all))
        .collect();
    let mut components: Vec<Component> = read.into_iter().collect::<Option<_>>()?;
    film_volume?;
    let sum: f64 = components.iter().map(|component| component.share).sum();
    if sum <= 0.0 || !sum.is_finite() {
        item.report(format!("the shares must have a sum > 0, it is {sum}"));
        return None;
    }
    for component in &mut components {
        component.share /= sum;
    }
    Some(components)
}

fn read_component(item: &Item<'_>, film_volume: &Located<f64>) -> Option<Component> {
    let fields = item.table()?;
    let has_body = fields.exactly_one(&["material", "clump"], true);
    for key in ["material", "clump"] {
        fields.get(key);
    }
    let body = if has_body { read_body(&fields) } else { None };
    let psd = read_sizes(&fields);
    let share = fields.need("share").and_then(|item| item.non_negative());
    let film_volume = read_film(&fields, || film_volume.clone());
    fields.finish();
    let share = share?.value;
    Some(Component {
        place: item.place.clone(),
        body: body?,
        psd: psd?,
        share,
        stated_share: share,
        film_volume: film_volume?,
    })
}

fn read_film(fields: &Fields<'_>, default: impl FnOnce() -> Located<f64>) -> Option<Located<f64>> {
    match fields.get("film_volume") {
        Some(item) => item.non_negative(),
        None => Some(default()),
    }
}

fn read_body(fields: &Fields<'_>) -> Option<Body> {
    if fields.has("clump") {
        fields.need("clump")?.clump().map(Body::Clump)
    } else {
        fields.need("material")?.material().map(Body::Sphere)
    }
}

/// The sizes of a component, which only a clump may leave out; none if they are wrong.
fn read_sizes(fields: &Fields<'_>) -> Option<Option<Located<Psd>>> {
    if fields.has("clump") && !fields.has("psd") {
        return Some(None);
    }
    let psd = fields.need("psd").and_then(|item| psd::read(&item));
    psd.map(Some)
}

fn read_total(item: &Item<'_>) -> Option<Located<Total>> {
    let fields = item.table()?;
    let keys = ["number", "mass", "volume", "full"];
    let is_one = fields.exactly_one(&keys, true);
    let number = fields.get("number").and_then(|item| item.whole(1));
    let mass = fields.get("mass").and_then(|item| item.positive());
    let volume = fields.get("volume").and_then(|item| item.positive());
    let full = fields.get("full").and_then(|item| {
        let full = item.boolean()?;
        if !full {
            item.report("can only be true; for another end give number, mass or volume");
        }
        full.then_some(Total::Full)
    });
    fields.finish();
    if !is_one {
        return None;
    }
    let total = number
        .map(|number| Total::Number(number.value))
        .or(mass.map(|mass| Total::Mass(mass.value)))
        .or(volume.map(|volume| Total::Volume(volume.value)))
        .or(full)?;
    Some(Located {
        value: total,
        place: item.place.clone(),
    })
}

fn read_rate(item: &Item<'_>) -> Option<Located<Rate>> {
    let fields = item.table()?;
    let is_one = fields.exactly_one(&["number", "mass", "volume", "table"], true);
    let positive = |key| {
        fields
            .get(key)
            .and_then(|item| item.positive())
            .map(|rate| rate.value)
    };
    let rate = positive("number")
        .map(Rate::Number)
        .into_iter()
        .chain(positive("mass").map(Rate::Mass))
        .chain(positive("volume").map(Rate::Volume))
        .chain(
            fields
                .get("table")
                .and_then(|item| item.file())
                .map(|file| Rate::Table(file.value)),
        )
        .next();
    fields.finish();
    if !is_one {
        return None;
    }
    Some(Located {
        value: rate?,
        place: item.place.clone(),
    })
}
