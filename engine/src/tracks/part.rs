//! Tracks in a step: grains that come get their track, and periods are counted.

use glam::DVec3;

use super::{PERIODS, TRACK, Tracked, Tracking};
use crate::physics::Setup;
use crate::state::{PEBBLE, Particles};
use crate::step::{Arrival, Core, Exchanged, Part, RunError, SizeEstimate};

/// The part that follows particles: by columns of theirs.
pub(crate) struct Tracks {
    tracking: Tracking,
    /// Whether a domain with images counts periods.
    has_periods: bool,
}

impl Part for Tracks {
    fn name(&self) -> &str {
        "tracks"
    }

    fn of(core: &mut Core) -> Option<Self> {
        let tracking = &core.watched().tracking;
        (!tracking.is_empty()).then(|| Self {
            tracking: tracking.clone(),
            has_periods: core.cell().has_images(),
        })
    }

    fn bytes(setup: &Setup, crowd: &SizeEstimate) -> f64 {
        let columns = match setup.physics.cell.has_images() {
            _ if setup.watched.tracking.is_empty() => 0,
            true => 1 + PERIODS.len(),
            false => 1,
        };
        crowd.rows * (columns * size_of::<f64>()) as f64
    }

    fn columns(&self) -> Vec<(&'static str, f64)> {
        let periods = self.has_periods.then_some(PERIODS);
        let names = [TRACK].into_iter().chain(periods.into_iter().flatten());
        names.map(|name| (name, 0.0)).collect()
    }

    /// Gives the particles of the start their tracks.
    fn start(&mut self, core: &mut Core) {
        begin(&self.tracking, &mut core.particles);
    }

    fn works_on_ranks(&self) -> bool {
        true
    }

    fn after_exchange(&mut self, core: &mut Core, exchanged: &Exchanged) {
        let tracking = &self.tracking;
        for arrival in &exchanged.arrivals {
            if let Some(track) = tracking.track_of(arrival.insertion) {
                mark(&mut core.particles, arrival, track, tracking.every);
            }
        }
    }

    fn before_list(&mut self, core: &mut Core) -> Result<(), RunError> {
        core.count_periods();
        Ok(())
    }
}

fn begin(tracking: &Tracking, particles: &mut Particles) {
    let ids: Vec<u32> = particles.ids.iter().map(|id| id.number()).collect();
    let Some(tracks) = particles.columns.get_mut(TRACK) else {
        return;
    };
    for (number, id) in tracking.particles.iter().enumerate() {
        if let Some(row) = ids.iter().position(|known| known == id) {
            tracks[row] = (number + 1) as f64;
        }
    }
}

/// Marks each `every`-th of the grains that an insertion has just brought with a track.
fn mark(particles: &mut Particles, arrival: &Arrival, track: u32, every: u64) {
    let mut grain = arrival.before;
    let mut body = None;
    let mut marked = Vec::new();
    for row in arrival.rows.clone() {
        if particles.records[row].flags & PEBBLE != 0 {
            let of_row = particles.bodies.as_ref().and_then(|b| b.body_of_row(row));
            if of_row == body {
                continue;
            }
            body = of_row;
        }
        if grain.is_multiple_of(every) {
            marked.push(row);
        }
        grain += 1;
    }
    if let Some(tracks) = particles.columns.get_mut(TRACK) {
        for row in marked {
            tracks[row] = f64::from(track);
        }
    }
}

impl Core {
    /// All that are tracked and still there, in the order of the rows.
    pub fn tracked(&self) -> Vec<Tracked> {
        let particles = &self.particles;
        let Some(tracks) = particles.columns.get(TRACK) else {
            return Vec::new();
        };
        let periods = PERIODS.map(|name| particles.columns.get(name));
        let rows = tracks.iter().enumerate().filter(|(_, track)| **track > 0.0);
        let tracked = rows.map(|(row, track)| {
            let periods = periods.map(|column| column.map_or(0.0, |column| column[row]));
            // An axis that is not periodic may have any size.
            let way = DVec3::from_array(std::array::from_fn(|axis| match periods[axis] {
                0.0 => 0.0,
                count => count * self.cell().size()[axis],
            }));
            Tracked {
                row,
                track: *track as u32,
                position: centre(particles, row) + way,
            }
        });
        tracked.collect()
    }

    /// Before particles are put back into the domain: counts the periods.
    fn count_periods(&mut self) {
        let cell = *self.cell();
        if !cell.has_images() || self.particles.columns.get(TRACK).is_none() {
            return;
        }
        for Tracked { row, .. } in self.tracked() {
            let place = centre(&self.particles, row);
            let way = place - cell.wrap(place);
            for (axis, name) in PERIODS.into_iter().enumerate() {
                if cell.is_periodic(axis)
                    && let Some(periods) = self.particles.columns.get_mut(name)
                {
                    periods[row] += cell.whole_periods(axis, way[axis]);
                }
            }
        }
    }
}

/// The centre of a particle, or of the body of a pebble, m.
fn centre(particles: &Particles, row: usize) -> DVec3 {
    let bodies = particles.bodies.as_ref();
    match bodies.and_then(|bodies| Some(&bodies.all[bodies.body_of_row(row)?.index()])) {
        Some(body) => body.position,
        None => particles.records[row].position,
    }
}
