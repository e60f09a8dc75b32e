//! `<prefix>.track.csv`: the motion of named particles and bodies, and of grains that insertions bring.

use glam::{DQuat, DVec3};
use mercury_common::run_tables::{TRACK, TableSpec};

use super::table_file::{Rows, RunTable};
use super::{Due, FrameCopy};
use crate::plan::Plan;
use mercury_engine::state::Load;
use mercury_engine::step::Engine;
use mercury_engine::tracks::Tracked;

/// A tracked particle or body at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Of which track, counted from 1.
    pub track: u32,
    /// Id; of a body that of its first pebble.
    pub id: u32,
    /// Centre, m, along periodic axes as in a domain that goes on for ever.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Angular velocity, rad/s.
    pub angular_velocity: DVec3,
    /// Orientation.
    pub orientation: DQuat,
    /// Force (N) and torque about the centre (N m) of all contacts.
    pub load: Load,
}

/// All tracked particles and bodies, by track and id.
pub(super) fn track_points(engine: &Engine) -> Vec<TrackPoint> {
    let particles = &engine.particles;
    let point = |tracked: Tracked| {
        let (row, track, position) = (tracked.row, tracked.track, tracked.position);
        let id = particles.ids[row].number();
        let body = particles.bodies.as_ref();
        let body = body.and_then(|bodies| Some(&bodies.all[bodies.body_of_row(row)?.index()]));
        let (velocity, angular_velocity, orientation, load) = match body {
            Some(body) => (
                body.velocity,
                body.angular_velocity,
                body.orientation,
                body.load,
            ),
            None => {
                let record = &particles.records[row];
                let all = particles.orientations.as_ref();
                let orientation = all.map_or(DQuat::IDENTITY, |all| all[row]);
                let load = particles.loads[row];
                (record.velocity, record.angular_velocity, orientation, load)
            }
        };
        TrackPoint {
            track,
            id,
            position,
            velocity,
            angular_velocity,
            orientation,
            load,
        }
    };
    let mut points: Vec<TrackPoint> = engine.tracked().into_iter().map(point).collect();
    points.sort_unstable_by_key(|point| (point.track, point.id));
    points
}

/// A row for each tracked particle or body and each interval of tracks. A particle that was deleted has no more rows.
pub(super) struct TrackFile {
    names: Vec<String>,
}

impl RunTable for TrackFile {
    const SPEC: &'static TableSpec = &TRACK;

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().has_tracks()
    }

    fn new(plan: &Plan) -> Self {
        Self {
            names: plan.outputs().files().track_names(),
        }
    }

    fn is_due(due: Due) -> bool {
        due.tracks
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        for point in &state.tracks {
            let name = self.names.get(point.track as usize - 1);
            let q = point.orientation;
            rows.number(state.time);
            rows.text(name.map_or("", String::as_str));
            rows.whole(i64::from(point.id));
            rows.numbers(point.position.to_array());
            rows.numbers(point.velocity.to_array());
            rows.numbers([q.w, q.x, q.y, q.z]);
            rows.numbers(point.angular_velocity.to_array());
            rows.numbers(point.load.force.to_array());
            rows.numbers(point.load.torque.to_array()).end();
        }
    }
}
