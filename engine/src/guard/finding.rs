//! Findings of the guard: what was beyond a limit, when, and as numbers of a checkpoint.

use glam::DVec3;

use crate::forces::{Alarm, AlarmKind, Alarms, Other, Subject};
use crate::state::{Id, WallIndex};

/// Kind of an event beyond a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FindingKind {
    Contact(AlarmKind, Alarm),
    Way {
        id: Id,
        position: DVec3,
        /// Way in a step over the radius.
        part: f64,
        /// m/s
        speed: f64,
    },
    /// A vertex of a sheet is outside of the domain.
    Left {
        of: Subject,
        position: DVec3,
        /// How far, m.
        way: f64,
    },
}

/// When and what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Finding {
    pub(super) step: u64,
    pub(super) time: f64,
    pub(super) what: FindingKind,
}

/// How often something happened, and the worst of it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Count {
    pub(super) steps: u64,
    pub(super) worst: Option<Finding>,
}

impl Finding {
    /// How bad it is.
    pub(super) fn part(&self) -> f64 {
        match self.what {
            FindingKind::Contact(_, alarm) => alarm.part(),
            FindingKind::Way { part, .. } => part,
            FindingKind::Left { way, .. } => way,
        }
    }

    pub(super) fn index(&self) -> usize {
        match self.what {
            FindingKind::Contact(kind, _) => kind as usize,
            FindingKind::Way { .. } => 3,
            FindingKind::Left { .. } => 4,
        }
    }
}

impl Finding {
    /// All of it but the kind; whole numbers are exact.
    pub(super) fn numbers(&self) -> Vec<f64> {
        let (of, position, others) = match self.what {
            FindingKind::Contact(_, alarm) => {
                let other = match alarm.other {
                    Other::Particle(id) => [0.0, f64::from(id.number())],
                    Other::Wall(wall) => [1.0, f64::from(wall.number())],
                };
                let [is_wall, index] = other;
                let others = [is_wall, index, alarm.radius, alarm.overlap, alarm.speed];
                (alarm.of, alarm.position, others)
            }
            FindingKind::Way {
                id,
                position,
                part,
                speed,
            } => (
                Subject::Particle(id),
                position,
                [0.0, 0.0, 1.0, part, speed],
            ),
            FindingKind::Left { of, position, way } => (of, position, [0.0, 0.0, 1.0, way, 0.0]),
        };
        let [sheet, number] = match of {
            Subject::Particle(id) => [-1.0, f64::from(id.number())],
            Subject::Vertex { surface, vertex } => [f64::from(surface), f64::from(vertex)],
        };
        let mut numbers = vec![self.step as f64, self.time, sheet, number];
        numbers.extend(position.to_array());
        numbers.extend(others);
        numbers
    }

    pub(super) fn from_numbers(kind: usize, numbers: &[f64]) -> Option<Self> {
        let &[
            step,
            time,
            sheet,
            number,
            x,
            y,
            z,
            is_wall,
            index,
            radius,
            overlap,
            speed,
        ] = numbers
        else {
            return None;
        };
        let (id, position) = (Id::new(number as u32), DVec3::new(x, y, z));
        let of = if sheet < 0.0 {
            Subject::Particle(id)
        } else {
            Subject::Vertex {
                surface: sheet as u16,
                vertex: number as u32,
            }
        };
        let other = if is_wall == 1.0 {
            Other::Wall(WallIndex::new(index as u16))
        } else {
            Other::Particle(Id::new(index as u32))
        };
        let what = match Alarms::KINDS.get(kind) {
            Some(&kind) => {
                let alarm = Alarm {
                    of,
                    other,
                    position,
                    radius,
                    overlap,
                    speed,
                };
                FindingKind::Contact(kind, alarm)
            }
            None if kind == Alarms::KINDS.len() => FindingKind::Way {
                id,
                position,
                part: overlap,
                speed,
            },
            None => FindingKind::Left {
                of,
                position,
                way: overlap,
            },
        };
        Some(Self {
            step: step as u64,
            time,
            what,
        })
    }
}
