//! The sheet's side of a contact: a wall whose surface moves as its vertices do.

use glam::DVec3;

use super::pass::Pass;
use super::slots::{JOINED, TOUCHING, WallSlot};
use super::walls::WallSide;
use crate::contact::{
    Action, AdhesionLaw, Contact, Histories, NormalForce, NormalLaw, PairLaw, RollingLaw,
    TangentialLaw,
};
use crate::forces::SpringEnergy;
use crate::surface::{Surface, SurfaceLoad, SurfacePoint};
use crate::walls::{Feature, Mesh, Saddle, Shape, Touch};

/// A point of a sheet that is touched.
pub(super) struct AtSheet<'a> {
    surface: &'a Surface,
    mesh: &'a Mesh,
    number: u16,
    feature: Feature,
    place: SurfacePoint,
    /// Velocity of the point, m/s.
    pub(super) velocity: DVec3,
    /// Over the mass with which it answers a force, 1/kg.
    pub(super) inverse_mass: f64,
    /// Where the contact joins a nearer one of the same particle.
    pub(super) saddle: Option<Saddle>,
}

impl<'a> AtSheet<'a> {
    /// Where `touch` is, if the wall is the shape of a sheet.
    #[inline]
    pub(super) fn of(
        side: &WallSide<'a>,
        surfaces: &'a [Surface],
        saddles: &[Saddle],
        touch: &Touch,
    ) -> Option<Self> {
        let number = side.wall.surface()?;
        let Shape::Mesh(mesh) = side.wall.shape() else {
            return None;
        };
        let surface = &surfaces[usize::from(number)];
        let foot = side.centre - touch.normal * touch.distance;
        let place = surface.place(mesh, touch.feature, foot);
        Some(Self {
            surface,
            mesh,
            number,
            feature: mesh.feature_of(touch.feature),
            place,
            velocity: surface.velocity_at(&place),
            inverse_mass: surface.inverse_mass_at(&place),
            saddle: saddles
                .iter()
                .find(|saddle| saddle.of == touch.feature)
                .copied(),
        })
    }

    /// Angular velocity of the triangle there, rad/s.
    pub(super) fn spin(&self) -> DVec3 {
        self.surface.spin(self.place.triangle)
    }

    /// By how much a normal of it turns as the sheet moves, 1/s, apart from what the way of the particle against the point does; `spin`:
    /// [`AtSheet::spin`].
    pub(super) fn turn(&self, normal: DVec3, spin: DVec3) -> DVec3 {
        match self.feature {
            // The rotation that fits velocities best turns the plane of a triangle as they do.
            Feature::Face(_) => spin.cross(normal),
            // The normal stays at a right angle to the edge.
            Feature::Edge(ends) => {
                let [start, end] = ends.map(|corner| self.surface.vertex_at(corner));
                let [from, to] = [start, end].map(|k| self.surface.positions[k]);
                let [first, last] = [start, end].map(|k| self.surface.velocities[k]);
                let along = to - from;
                along * (-(last - first).dot(normal) / along.length_squared())
            }
            Feature::Corner(_) => DVec3::ZERO,
        }
    }

    /// Load on the sheet where the particle gets this force (N) and this couple (N m).
    pub(super) fn load(&self, force: DVec3, couple: DVec3) -> SurfaceLoad {
        SurfaceLoad {
            surface: self.number,
            triangle: self.place.triangle,
            shares: self.surface.shares(&self.place, -force, -couple),
        }
    }

    /// Load on the sheet at a saddle where the particle, its centre at `centre` (m), gets this force (N).
    pub(super) fn load_at(&self, saddle: &Saddle, centre: DVec3, force: DVec3) -> SurfaceLoad {
        let foot = centre - saddle.normal * saddle.distance;
        let place = self.surface.place(self.mesh, saddle.feature, foot);
        SurfaceLoad {
            surface: self.number,
            triangle: place.triangle,
            shares: self.surface.shares(&place, -force, DVec3::ZERO),
        }
    }

    /// The number of the sheet, and the point.
    pub(super) fn place(&self) -> (u16, SurfacePoint) {
        (self.number, self.place)
    }
}

/// Rest of a contact that joins a nearer one of the same particle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Joined {
    /// By which part it counts.
    part: f64,
    /// Energy that the normal spring would store at the saddle, J; `None` if the part holds of the normal force too.
    less: Option<f64>,
    /// Force on the particle at the saddle, N.
    pub(super) pull: DVec3,
}

impl Joined {
    /// Elastic energy of the joined contact, from that which it would store alone, J.
    pub(super) fn stored(&self, alone: f64, by_friction: f64) -> f64 {
        match self.less {
            Some(less) => alone - (1.0 - self.part) * by_friction - less,
            None => alone * self.part,
        }
    }

    /// Elastic energies of the joined contact, spring by spring, J.
    pub(super) fn springs(&self, alone: &SpringEnergy) -> SpringEnergy {
        let mut stored = *alone;
        match self.less {
            Some(less) => stored.normal -= less,
            None => stored.normal *= self.part,
        }
        stored.plastic *= self.part;
        stored.tangential *= self.part;
        stored.rolling *= self.part;
        stored
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// Rest of the `action` of a contact that joins a nearer one at a saddle: of elastic normal forces all of it, less the force
    /// at the saddle; of others a part. `reach`: radius of the particle and half the thickness of the sheet, m.
    #[inline(never)]
    pub(super) fn join(
        law: &PairLaw<N, T, R, A>,
        contact: &Contact,
        (saddle, reach): (&Saddle, f64),
        action: &Action,
    ) -> (Action, Joined) {
        let part = saddle.part;
        let mut left = *action;
        left.couple = action.couple * part;
        left.tangential = action.tangential * part;
        left.normal.viscous = action.normal.viscous * part;
        if A::ACTIVE || !law.normal.is_elastic() {
            left.force = action.force * part;
            left.normal.elastic = action.normal.elastic * part;
            left.adhesion.normal = NormalForce {
                elastic: action.adhesion.normal.elastic * part,
                viscous: action.adhesion.normal.viscous * part,
            };
            left.adhesion.tangential = action.adhesion.tangential * part;
            let joined = Joined {
                part,
                less: None,
                pull: DVec3::ZERO,
            };
            return (left, joined);
        }
        let at_saddle = Contact {
            normal: saddle.normal.into(),
            distance: saddle.distance,
            overlap: reach - saddle.distance,
            normal_velocity: 0.0,
            ..*contact
        };
        let elastic = law
            .normal
            .force(&at_saddle, &mut Default::default())
            .elastic;
        left.force = contact.normal * left.normal.total() + left.tangential;
        let joined = Joined {
            part,
            less: Some(law.normal.energy(&at_saddle, &Default::default())),
            pull: saddle.normal * -elastic,
        };
        (left, joined)
    }

    /// Exchanges memories with the roles of contacts: where two change their order, the one that joins the other now takes the
    /// memory that the other had while it was the joining one.
    pub(super) fn change_roles(slots: &mut [WallSlot<Histories<N, T, R, A>>], saddles: &[Saddle]) {
        for saddle in saddles {
            let place = |feature| slots.iter().position(|slot| slot.feature == feature);
            let (Some(younger), Some(elder)) = (place(saddle.of), place(saddle.joins)) else {
                continue;
            };
            let [was_younger, was_elder] = [elder, younger].map(|place| slots[place].state);
            if was_younger & JOINED != 0 && was_elder & TOUCHING != 0 && was_elder & JOINED == 0 {
                let history = slots[elder].history;
                slots[elder].history = slots[younger].history;
                slots[younger].history = history;
                slots[elder].state &= !JOINED;
            }
        }
    }
}
