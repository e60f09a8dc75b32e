//! The time behind which a scene schedules nothing any more.

use mercury_common::scene::{Quantity, Total};
use mercury_engine::boundaries::{InsertionPlan, Rate};
use mercury_engine::membrane::MembranePlan;
use mercury_engine::spray::SprayPlan;

use super::Plan;

/// The last event of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Settled {
    /// When, s; 0 where nothing is scheduled behind the start.
    pub time: f64,
    /// The event.
    pub event: String,
}

impl Plan {
    /// The time behind which the scene schedules nothing: no insertion ends, no wall or hold appears, vanishes or changes how it moves, no nozzle opens or closes. What goes on
    /// until the end of the run, such as a drum that turns or a flow without a total, is no event. An insertion whose end is not known before the run (as fast as particles fit) ends, as far
    /// as this says, when it begins; the start-up that rows show covers the rest.
    #[must_use]
    pub fn settled(&self) -> Settled {
        let physics = self.physics();
        let mut last = Settled {
            time: 0.0,
            event: "the start".to_owned(),
        };
        let mut add = |time: f64, event: &dyn Fn() -> String| {
            if time.is_finite() && time > last.time {
                last = Settled {
                    time,
                    event: event(),
                };
            }
        };
        if let Some(event) = physics.last_event() {
            let wall = &event.wall;
            add(event.time, &|| format!("the last change of wall `{wall}`"));
        }
        for insertion in &physics.insertions {
            let name = &insertion.name;
            add(end_of(insertion), &|| {
                format!("the end of insertion `{name}`")
            });
        }
        for nozzle in physics
            .plans
            .all::<SprayPlan>()
            .iter()
            .flat_map(|sprays| &sprays.nozzles)
        {
            let name = &nozzle.name;
            add(nozzle.from, &|| format!("the start of spray `{name}`"));
            add(nozzle.until, &|| format!("the end of spray `{name}`"));
        }
        for hold in physics
            .plans
            .all::<MembranePlan>()
            .iter()
            .flat_map(|sheet| &sheet.holds)
        {
            let name = &hold.name;
            add(hold.from, &|| format!("the start of hold `{name}`"));
            add(hold.until, &|| format!("the end of hold `{name}`"));
        }
        last
    }
}

/// When an insertion ends, as far as its plan says so, or else when it begins, s.
fn end_of(insertion: &InsertionPlan) -> f64 {
    let by_rate = match (&insertion.rate, insertion.total) {
        (
            Some(Rate::Steady {
                quantity,
                per_second,
            }),
            Some(total),
        ) => amount_of(total, *quantity).map(|amount| insertion.from + amount / per_second),
        (Some(Rate::Table { quantity, amounts }), Some(total)) => amount_of(total, *quantity)
            .and_then(|amount| {
                let mut pairs = amounts.rows().windows(2);
                let reached = pairs.find(|pair| pair[1].1 >= amount)?;
                let [(t0, a0), (t1, a1)] = [reached[0], reached[1]];
                Some(t0 + (t1 - t0) * (amount - a0) / (a1 - a0))
            }),
        _ => None,
    };
    if let Some(end) = by_rate {
        return end.min(insertion.until);
    }
    if insertion.until.is_finite() {
        return insertion.until;
    }
    match &insertion.rate {
        Some(Rate::Table { amounts, .. }) => amounts.ends()[1],
        _ => insertion.from,
    }
}

/// The amount of a total, if it is of the quantity.
fn amount_of(total: Total, quantity: Quantity) -> Option<f64> {
    match (total, quantity) {
        (Total::Number(number), Quantity::Number) => Some(number as f64),
        (Total::Mass(mass), Quantity::Mass) => Some(mass),
        (Total::Volume(volume), Quantity::Volume) => Some(volume),
        _ => None,
    }
}
