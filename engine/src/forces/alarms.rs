//! Contacts beyond a limit: the worst of each kind, by name.

use glam::DVec3;

use crate::state::{Id, WallIndex};

/// Fault of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AlarmKind {
    /// It overlaps too much.
    Overlap,
    /// The centre of the particle has gone through the wall.
    Through,
    /// A wall that acts on one side is touched from behind.
    Behind,
}

/// Event beyond a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// A particle.
    Particle(Id),
    /// A vertex of a sheet, by the number of the sheet and its own.
    Vertex {
        /// Of the sheet.
        surface: u16,
        /// In the order of its file.
        vertex: u32,
    },
}

/// The partner of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Other {
    /// A particle.
    Particle(Id),
    /// A wall.
    Wall(WallIndex),
}

/// A contact beyond a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alarm {
    /// The particle, or the vertex, which is a sphere of half the thickness of its sheet.
    pub of: Subject,
    /// Partner that it touches.
    pub other: Other,
    /// Its centre, m.
    pub position: DVec3,
    /// The smaller radius, m.
    pub radius: f64,
    /// Overlap, m.
    pub overlap: f64,
    /// How fast the two approach each other, m/s.
    pub speed: f64,
}

impl Alarm {
    /// The overlap over the smaller radius.
    #[must_use]
    pub fn part(&self) -> f64 {
        self.overlap / self.radius
    }
}

/// The worst of each kind in one evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Alarms([Option<Alarm>; 3]);

impl Alarms {
    /// All kinds.
    pub const KINDS: [AlarmKind; 3] = [AlarmKind::Overlap, AlarmKind::Through, AlarmKind::Behind];

    /// Adds a contact; of two equally bad ones the first stays.
    #[cold]
    pub fn note(&mut self, kind: AlarmKind, alarm: Alarm) {
        let worst = &mut self.0[kind as usize];
        if worst.is_none_or(|worst| alarm.part() > worst.part()) {
            *worst = Some(alarm);
        }
    }

    /// The worst contact of a kind.
    #[must_use]
    pub fn worst(&self, kind: AlarmKind) -> Option<Alarm> {
        self.0[kind as usize]
    }

    /// Moves the contacts of another part into this one.
    pub fn take_from(&mut self, other: &mut Self) {
        for kind in Self::KINDS {
            if let Some(alarm) = other.0[kind as usize].take() {
                self.note(kind, alarm);
            }
        }
    }
}
