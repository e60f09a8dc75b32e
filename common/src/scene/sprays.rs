//! `[[sprays]]`: nozzles whose droplets wet the particles.

use glam::DVec3;

use super::item::Item;
use super::psd::{self, Psd};
use super::source::{Located, Place};
use super::walls::interval;

/// A nozzle.
#[derive(Debug, Clone, PartialEq)]
pub struct Spray {
    /// Unique among sprays; random choices follow from it and the seed.
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: Place,
    /// The orifice, m.
    pub position: Located<DVec3>,
    /// Mean direction of the droplets, length 1.
    pub axis: Located<DVec3>,
    /// How directions spread about the axis.
    pub pattern: SprayPattern,
    /// m3/s
    pub flow_rate: Located<f64>,
    /// Speed of the droplets, m/s.
    pub speed: Located<f64>,
    /// Sizes of the droplets.
    pub droplets: Located<Psd>,
    /// kg/m3
    pub liquid_density: Located<f64>,
    /// Start, s; default 0.
    pub from: Located<f64>,
    /// End, s; none: never.
    pub until: Option<Located<f64>>,
}

/// How directions spread.
#[derive(Debug, Clone, PartialEq)]
pub enum SprayPattern {
    /// A fan.
    FlatFan {
        /// Direction in which the fan is wide, length 1, not along the axis.
        wide_axis: Located<DVec3>,
        /// Half angles in the wide and the narrow direction, degrees, in [0, 90).
        half_angles_degrees: Located<[f64; 2]>,
    },
}

/// Reads an entry of `[[sprays]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Spray> {
    let fields = item.table()?;
    let name = fields.need("name").and_then(|item| item.name());
    let position = fields.need("position").and_then(|item| item.vector());
    let axis = fields.need("axis").and_then(|item| item.direction());
    let pattern = fields
        .need("pattern")
        .and_then(|item| read_pattern(&item, axis.as_ref()));
    let flow_rate = fields
        .need("flow_rate")
        .and_then(|item| item.non_negative());
    let speed = fields.need("speed").and_then(|item| item.non_negative());
    let droplets = fields.need("droplets").and_then(|item| psd::read(&item));
    let liquid_density = fields
        .need("liquid_density")
        .and_then(|item| item.positive());
    let (from, until) = interval(&fields);
    fields.finish();
    Some(Spray {
        name: name?,
        place: item.place.clone(),
        position: position?,
        axis: axis?,
        pattern: pattern?,
        flow_rate: flow_rate?,
        speed: speed?,
        droplets: droplets?,
        liquid_density: liquid_density?,
        from: from?,
        until,
    })
}

fn read_pattern(item: &Item<'_>, axis: Option<&Located<DVec3>>) -> Option<SprayPattern> {
    let fields = item.table()?;
    fields
        .need("kind")?
        .word("spray pattern", &[("flat-fan", ())])?;
    let wide_axis = fields.need("wide_axis").and_then(|item| {
        let wide = item.direction()?;
        // Parallel to round-off: the fan would have no plane.
        if axis.is_some_and(|axis| axis.cross(*wide).length() < 1e-9) {
            item.report("must not be parallel to the axis of the spray");
            return None;
        }
        Some(wide)
    });
    let half_angles = fields.need("half_angles_degrees").and_then(|item| {
        let angles = item.numbers::<2>()?;
        if angles.iter().any(|angle| !(0.0..90.0).contains(angle)) {
            item.report(format!("must lie in [0, 90), got {}", item.place.text()));
            return None;
        }
        Some(angles)
    });
    fields.finish();
    Some(SprayPattern::FlatFan {
        wide_axis: wide_axis?,
        half_angles_degrees: half_angles?,
    })
}
