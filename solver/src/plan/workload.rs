//! The number of grains of a run over time, as far as its plan determines it, and the remaining work.
//!
//! A run's work is counted in particle-steps, the sum of the grains over all steps. Grains that leave are not foreseen, and
//! neither is when an insertion whose region is full finds space again: it is given as a range, from never to at once.

use super::Plan;
use crate::boundaries::plan::insertions::{expected_inserted, grains_per_unit};
use mercury_engine::boundaries::Rate;

/// The grains that a run is planned to have over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Workload {
    /// s
    time_step: f64,
    steps: u64,
    /// Grains of the start.
    at_start: f64,
    /// In the order of the plan.
    sources: Vec<Source>,
}

/// Particles that an insertion brings over time.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    /// s
    from: f64,
    /// s
    until: f64,
    /// The most that it brings.
    most: f64,
    /// Grains per unit of what the rate counts, and the rate; without one all come at once.
    rate: Option<(f64, Rate)>,
}

impl Source {
    /// Grains that have come by a time (s) if all find a place.
    fn brought(&self, time: f64) -> f64 {
        match &self.rate {
            _ if time < self.from => 0.0,
            None => self.most,
            Some((per_unit, rate)) => {
                let (_, allowed) = rate.allowed(self.from, time.min(self.until));
                (per_unit * allowed).min(self.most)
            }
        }
    }

    /// The integral of what comes after `begin` (s) up to `end`, s.
    fn grown(&self, begin: f64, end: f64) -> f64 {
        let before = self.brought(begin);
        // Between these times what the rate allows is a straight line.
        let mut corners = vec![begin, end, self.from, self.until];
        if let Some((_, Rate::Table { amounts, .. })) = &self.rate {
            corners.extend(amounts.rows().iter().map(|row| row.0));
        }
        corners.retain(|time| (begin..=end).contains(time));
        corners.sort_by(f64::total_cmp);
        let pieces = corners.windows(2).map(|piece| {
            let (a, b) = (piece[0], piece[1]);
            self.grown_in(a, b) - before * (b - a)
        });
        pieces.sum::<f64>().max(0.0)
    }

    /// The integral of what has come over a time in which it is a straight line that may end at the most, s.
    fn grown_in(&self, a: f64, b: f64) -> f64 {
        let free = Self {
            most: f64::INFINITY,
            ..self.clone()
        };
        let middle = self.brought(0.5 * (a + b));
        if self.rate.is_none() || b <= a {
            return middle * (b - a).max(0.0);
        }
        // Looked at inside, where jumps of a table at the ends do not matter.
        let [early, late] = [0.25, 0.75].map(|part| free.brought(a + part * (b - a)));
        let slope = (late - early) / (0.5 * (b - a));
        let at_begin = early - slope * 0.25 * (b - a);
        let reached = match slope > 0.0 {
            true => (a + (self.most - at_begin) / slope).clamp(a, b),
            false if at_begin <= self.most => b,
            false => a,
        };
        let before = reached - a;
        (at_begin + 0.5 * slope * before) * before + self.most.min(f64::MAX) * (b - reached)
    }
}

/// Where a run is.
#[derive(Debug, Clone, Copy)]
pub struct Here<'a> {
    /// Steps made.
    pub step: u64,
    /// Grains that are there.
    pub grains: f64,
    /// Number of particles that each insertion has brought, and whether it is finished.
    pub brought: &'a [(u64, bool)],
}

/// The remaining work of a run, lower and upper bound. Equal where the plan determines it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ahead {
    /// Particle-steps.
    pub particle_steps: [f64; 2],
    /// Grains at the end.
    pub grains: [f64; 2],
}

impl Ahead {
    /// Particle-steps in the middle between the least and the most.
    #[must_use]
    pub fn middle(&self) -> f64 {
        0.5 * (self.particle_steps[0] + self.particle_steps[1])
    }
}

/// An insertion that has placed less than this share of its present target waits for space: rates count whole grains.
const LATE: f64 = 0.99;

impl Workload {
    /// Workload of a plan.
    #[must_use]
    pub fn of(plan: &Plan) -> Self {
        let physics = plan.physics();
        let sources = physics.insertions.iter().map(|insertion| Source {
            from: insertion.from,
            until: insertion.until,
            most: expected_inserted(insertion, plan),
            rate: (insertion.rate.as_ref()).map(|rate| {
                (
                    grains_per_unit(insertion, rate.quantity(), physics),
                    rate.clone(),
                )
            }),
        });
        Self {
            time_step: physics.time_step,
            steps: physics.steps,
            at_start: (physics.particles.len() + physics.bodies.len()) as f64,
            sources: sources.collect(),
        }
    }

    /// Grains that are planned at a time (s), if none leaves.
    #[must_use]
    pub fn grains(&self, time: f64) -> f64 {
        let brought = self.sources.iter().map(|source| source.brought(time));
        self.at_start + brought.sum::<f64>()
    }

    /// The remaining work of the present run, if no more grains leave.
    #[must_use]
    pub fn ahead(&self, here: Here<'_>) -> Ahead {
        let steps = self.steps.saturating_sub(here.step) as f64;
        let (now, end) = (
            here.step as f64 * self.time_step,
            self.steps as f64 * self.time_step,
        );
        let mut ahead = Ahead {
            particle_steps: [here.grains * steps; 2],
            grains: [here.grains; 2],
        };
        for (source, &(came, is_finished)) in self.sources.iter().zip(here.brought) {
            if is_finished {
                continue;
            }
            let came = came as f64;
            let planned = source.brought(now);
            let grown = source.grown(now, end) / self.time_step;
            let late = (planned - came).max(0.0);
            let is_late = came < LATE * planned - 1.0;
            ahead.particle_steps[1] += grown + late * steps;
            ahead.grains[1] += source.brought(end) - planned + late;
            if !is_late {
                ahead.particle_steps[0] += grown;
                ahead.grains[0] += source.brought(end) - planned;
            }
        }
        ahead
    }
}

#[cfg(test)]
mod tests {
    use mercury_common::curve::Curve;

    use super::*;
    use mercury_engine::boundaries::Quantity;

    fn steady(per_second: f64, until: f64, most: f64) -> Source {
        let rate = Rate::Steady {
            quantity: Quantity::Number,
            per_second,
        };
        Source {
            from: 1.0,
            until,
            most,
            rate: Some((1.0, rate)),
        }
    }

    /// 10 s in steps of 0.01 s, from 50 grains on.
    fn workload(source: Source) -> Workload {
        Workload {
            time_step: 0.01,
            steps: 1000,
            at_start: 50.0,
            sources: vec![source],
        }
    }

    fn close(found: f64, expected: f64) {
        assert!(
            (found - expected).abs() <= 1e-9 * expected.abs().max(1.0),
            "{found} instead of {expected}"
        );
    }

    #[test]
    fn work_that_does_not_change_is_grains_times_steps() {
        let mut constant = workload(steady(1.0, 2.0, 1.0));
        constant.sources.clear();
        let here = Here {
            step: 400,
            grains: 50.0,
            brought: &[],
        };
        let ahead = constant.ahead(here);
        assert_eq!(ahead.particle_steps, [50.0 * 600.0; 2]);
        assert_eq!(ahead.grains, [50.0; 2]);
    }

    #[test]
    fn what_comes_at_a_rate_is_a_triangle_and_what_stays_a_rectangle() {
        // 100 per second from 1 s on: 400 are there at 5 s, when the total is reached; the triangle 400 * 4 s / 2 and the rectangle 400 * 5 s.
        let by_total = workload(steady(100.0, f64::INFINITY, 400.0));
        // An insertion with the same course, limited by its end.
        let by_time = workload(steady(100.0, 5.0, 1e6));
        for load in [by_total, by_time] {
            let here = Here {
                step: 0,
                grains: 50.0,
                brought: &[(0, false)],
            };
            let ahead = load.ahead(here);
            for work in ahead.particle_steps {
                close(
                    work,
                    50.0 * 1000.0 + (0.5 * 400.0 * 4.0 + 400.0 * 5.0) / 0.01,
                );
            }
            assert_eq!(ahead.grains, [450.0; 2]);
            // From 3 s on: 200 are there, and as many come within 2 s.
            let here = Here {
                step: 300,
                grains: 250.0,
                brought: &[(200, false)],
            };
            let ahead = load.ahead(here);
            close(
                ahead.particle_steps[0],
                250.0 * 700.0 + (0.5 * 200.0 * 2.0 + 200.0 * 5.0) / 0.01,
            );
            close(load.grains(3.0), 250.0);
        }
    }

    #[test]
    fn tables_may_begin_with_an_amount() {
        // Nothing until 2 s, then 100 at once, and 50 more within 2 s.
        let mut source = steady(1.0, f64::INFINITY, 1e6);
        let rows = vec![(2.0, 100.0), (4.0, 150.0), (5.0, 150.0)];
        source.rate = Some((
            2.0, // grains per unit
            Rate::Table {
                quantity: Quantity::Mass,
                amounts: Curve::new(rows).unwrap(),
            },
        ));
        let load = workload(source);
        let here = Here {
            step: 0,
            grains: 50.0,
            brought: &[(0, false)],
        };
        let of_table = 2.0 * ((100.0 + 150.0) / 2.0 * 2.0 + 150.0 * 6.0);
        close(
            load.ahead(here).particle_steps[1],
            50.0 * 1000.0 + of_table / 0.01,
        );
    }

    #[test]
    fn what_waits_for_space_comes_never_or_at_once() {
        let mut source = steady(1.0, f64::INFINITY, 400.0);
        source.rate = None;
        let load = workload(source);
        let at = |step, grains, state| {
            load.ahead(Here {
                step,
                grains,
                brought: &[state],
            })
        };
        let waits = at(500, 150.0, (100, false));
        assert_eq!(waits.particle_steps, [150.0 * 500.0, 450.0 * 500.0]);
        assert_eq!(waits.grains, [150.0, 450.0]);
        close(waits.middle(), 300.0 * 500.0);
        // Particles that come later are known.
        let before = at(0, 50.0, (0, false));
        assert_eq!(before.particle_steps[0], before.particle_steps[1]);
        close(before.particle_steps[0], 50.0 * 1000.0 + 400.0 * 900.0);
        // One that is over brings nothing.
        let over = at(500, 150.0, (100, true));
        assert_eq!(over.particle_steps, [150.0 * 500.0; 2]);
    }
}
