//! A contact with one feature of a wall: geometry, law and reports.

use glam::DVec3;

use super::contact_point::mobility;
use super::pass::{ContactSite, Pass};
use super::sheets::{AtSheet, Joined};
use super::slot_events::SlotEvent;
use super::slots::{TOUCHING, WITH_HISTORY, WallSlot, with_history};
use super::walls::WallSide;
use crate::contact::{
    Action, AdhesionLaw, Contact, Histories, NormalLaw, PairLaw, RollingLaw, TangentialLaw,
};
use crate::forces::{FeatureLoad, FeatureLoads, Impact, Observation, Partner, Rub};
use crate::lanes::Vector;
use crate::state::{Load, Particle};
use crate::surface::SurfaceLoad;
use crate::walls::Touch;

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// The contact of a particle with one feature of a wall, which may be the shape of a sheet: geometry, law, load and reports.
    #[inline(always)]
    pub(super) fn touch_wall(
        &self,
        a: &Particle,
        at: &WallTouch<'_>,
        slot: &mut WallSlot<Histories<N, T, R, A>>,
        load: &mut Load,
        reports: WallReports<'_, '_, Histories<N, T, R, A>>,
    ) {
        let (context, side, sheet) = (self.context, at.side, at.sheet);
        let reach = a.radius + side.wall.half_thickness();
        let geometric = reach - at.touch.distance;
        let mut overlap = geometric;
        if let Some(offsets) = context.offsets {
            let (row, wall) = (side.near.row, side.near.wall.number());
            let offset = offsets.at_wall(row, u32::from(wall));
            overlap -= offset;
            // A glued pair that overlaps no more than when it was glued.
            if !A::ACTIVE && offset > 0.0 && overlap <= 0.0 {
                slot.clear();
                return;
            }
        }
        let pair = a.material.index() * self.materials + side.wall.material.index();
        let law = &self.laws[pair];
        let overlaps = !A::ACTIVE || overlap > 0.0;
        let has_no_memory = law.adhesion.forms_on_contact() && slot.state & WITH_HISTORY == 0;
        if !overlaps && has_no_memory && !self.films_meet(a, at, overlap) {
            return;
        }
        let meeting = self.meet_wall(a, at, [geometric, overlap]);
        let contact = &meeting.contact;
        let touches = overlaps || A::JOINS && law.touches(contact, &slot.history);
        let (before, touched) = (slot.history, slot.state & TOUCHING != 0);
        let mut action = if touches {
            law.act(contact, context.spring_time, &mut slot.history)
        } else {
            law.act_apart(contact, context.spring_time, &mut slot.history)
        };
        let mut joined = None;
        if let Some(sheet) = sheet
            && let Some(saddle) = &sheet.saddle
        {
            let (left, of_saddle) = Self::join(law, contact, (saddle, reach), &action);
            (action, joined) = (left, Some(of_saddle));
        }
        slot.state = if A::ACTIVE {
            with_history(touches, &slot.history.3)
        } else {
            TOUCHING
        };
        let (force, couple) = (DVec3::from(action.force), DVec3::from(action.couple));
        if A::HAS_EVENTS && law.adhesion.event(contact, &slot.history.3) {
            reports.events.push(SlotEvent::Wall {
                near: at.near,
                feature: at.touch.feature,
            });
        }
        let tangential = DVec3::from(action.shear(A::SHEARS));
        load.add(force, couple + meeting.arm.cross(tangential));
        if context.wall_loads {
            let about = side.centre + meeting.arm - side.state.reference;
            let on_wall = &mut reports.wall_loads[side.near.wall.index()];
            on_wall.add(-force, -about.cross(force) - couple);
        }
        let mut acted = WallAction {
            pair,
            action,
            force,
            couple,
            tangential,
            joined,
            before,
            touched,
            touches,
        };
        if let Some(reported) = reports.surface {
            if let (Some(sheet), Some(loads)) = (sheet, &mut reported.sheets) {
                loads.push(sheet.load(force, couple));
                if let (Some(joined), Some(saddle)) = (&acted.joined, &sheet.saddle) {
                    load.add(joined.pull, DVec3::ZERO);
                    loads.push(sheet.load_at(saddle, side.centre, joined.pull));
                    // The observed force of the contact is all that it exerts on the particle.
                    acted.action.force += Vector::from(joined.pull);
                }
            } else {
                self.report_wall(a, at, &meeting, &acted, slot, reported);
            }
        }
        if context.watch.is_some() {
            self.see_wall(a, at, &meeting, acted, slot.history, reports.observation);
        }
    }

    /// Whether the films of a particle and a wall that do not touch meet and hold enough for a bridge.
    #[inline(always)]
    fn films_meet(&self, a: &Particle, at: &WallTouch<'_>, overlap: f64) -> bool {
        let (context, side) = (self.context, at.side);
        let films = self.films.filter(|_| A::HAS_EVENTS);
        let on_wall = || {
            let films = context.wall_films?;
            let place = films.place(side.near.wall.index(), at.touch.feature, context.walls)?;
            Some([films.thickness(place), films.within_reach(place, a.radius)])
        };
        let pair = a.material.index() * self.materials + side.wall.material.index();
        let least = self.laws[pair].adhesion.least_films();
        films.is_some_and(|films| {
            let [thickness, volume] = films[side.near.row as usize];
            if thickness >= -overlap && volume >= least {
                return true;
            }
            let [on_wall, reach] = on_wall().unwrap_or_default();
            thickness + on_wall >= -overlap && volume + reach >= least
        })
    }

    /// Geometry of a contact with a wall, and the motion of both at it. Overlaps (m): that of the shapes, which sets the lever, and that which counts.
    #[inline(always)]
    fn meet_wall(
        &self,
        a: &Particle,
        at: &WallTouch<'_>,
        [geometric, overlap]: [f64; 2],
    ) -> WallMeeting {
        let WallTouch {
            side, sheet, touch, ..
        } = *at;
        let (context, state) = (self.context, side.state);
        let normal = state.out_of_wall(touch.normal);
        // First, while there is little that the call could push out of registers.
        let effective_mass = match self.bodies {
            None => 1.0 / a.inverse_mass,
            Some(bodies) => 1.0 / mobility(bodies, side.near.row as usize, a, normal),
        };
        // A sheet answers with its own mass, and is touched where it is: the lever of the particle and the shares of the vertices mean the
        // same point.
        let (effective_mass, lever) = match sheet {
            None => (effective_mass, a.radius - 0.5 * geometric),
            Some(sheet) => (
                1.0 / (1.0 / effective_mass + sheet.inverse_mass),
                touch.distance,
            ),
        };
        let arm = normal * -lever;
        // The place of the centre at the time of these velocities: on a wall that turns they differ from place to place.
        let earlier = side.centre - a.velocity * context.velocity_lag;
        let own = side.own_velocity(touch.feature);
        let velocity_at = |arm: DVec3| {
            let velocity = a.velocity + a.angular_velocity.cross(arm);
            let velocity = if state.moves {
                velocity - state.velocity.at(earlier + arm)
            } else if let Some(sheet) = sheet {
                velocity - sheet.velocity
            } else {
                velocity
            };
            own.map_or(velocity, |own| velocity - own)
        };
        let velocity = velocity_at(arm);
        let mut spin = a.angular_velocity;
        let mut spin_of_sheet = DVec3::ZERO;
        if let Some(sheet) = sheet
            && (T::ACTIVE || R::ACTIVE || A::TWISTS)
        {
            spin_of_sheet = sheet.spin();
            spin -= spin_of_sheet;
        }
        if state.moves {
            spin -= state.velocity.angular_velocity;
        }
        let normal_velocity = velocity.dot(normal);
        let (mut sliding_normal, mut sliding) = (normal, velocity - normal * normal_velocity);
        let mut sliding_distance = touch.distance;
        let lag = context.sliding_lag();
        if lag > 0.0 && PairLaw::<N, T, R, A>::TURNS {
            // Normal and lever arm at that time.
            let mut way = a.velocity;
            let mut turn = DVec3::ZERO;
            if state.moves {
                way -= state.velocity.at(earlier);
                turn = state.velocity.angular_velocity.cross(normal);
            }
            if let Some(sheet) = sheet {
                way -= sheet.velocity;
                turn = sheet.turn(normal, spin_of_sheet);
            }
            if let Some(own) = own {
                way -= own;
            }
            if touch.turning.rates != [0.0; 2] {
                let way = state.turn_into_wall(way);
                turn += state.out_of_wall(touch.turning.of(touch.normal, way));
            }
            if turn != DVec3::ZERO {
                sliding_normal = (normal - turn * lag).normalize();
            }
            sliding_distance -= way.dot(normal) * lag;
            let sliding_lever = match sheet {
                None => 0.5 * (a.radius + sliding_distance),
                Some(_) => sliding_distance,
            };
            let at_foot = velocity_at(sliding_normal * -sliding_lever);
            sliding = at_foot - sliding_normal * at_foot.dot(sliding_normal);
            sliding -= normal * sliding.dot(normal);
        }
        let contact = Contact {
            normal: normal.into(),
            distance: touch.distance,
            overlap,
            effective_radius: if context.wall_curvature {
                curved_radius(a.radius, touch.curvature)
            } else {
                a.radius
            },
            effective_mass,
            normal_velocity,
            tangential_velocity: sliding.into(),
            sliding_normal: sliding_normal.into(),
            sliding_distance,
            centre_velocity: Vector::ZERO,
            spin: spin.into(),
        };
        WallMeeting {
            contact,
            lever,
            arm,
            earlier,
            own,
            sliding,
        }
    }

    /// Reports the load of a contact on the features of a mesh, and its sliding.
    #[inline(always)]
    fn report_wall(
        &self,
        a: &Particle,
        at: &WallTouch<'_>,
        meeting: &WallMeeting,
        acted: &WallAction<Histories<N, T, R, A>>,
        slot: &mut WallSlot<Histories<N, T, R, A>>,
        reported: &mut Reported<'_>,
    ) {
        let (side, touch) = (at.side, at.touch);
        let (state, dt) = (side.state, self.context.spring_time);
        let WallMeeting {
            contact, sliding, ..
        } = meeting;
        let (law, action) = (&self.laws[acted.pair], &acted.action);
        let now = (acted.touches).then(|| law.friction_now(contact, action, &slot.history));
        // A new contact begins without force. Of one that goes on from another run the forces before are not known.
        let last = match slot.friction {
            None if acted.touched => now,
            last => Some(last.unwrap_or_default()),
        };
        let (mut lost, mut mean_load) = (0.0, 0.0);
        // At the start no time has passed.
        if let Some(last) = last.filter(|_| dt > 0.0) {
            let next = now.unwrap_or_default();
            mean_load = last.mean_load(&next);
            lost = last.loss_until(&next, *sliding, dt);
        }
        slot.friction = now;
        if let Some(loads) = &mut reported.loads {
            let on_wall = FeatureLoad {
                force: state.turn_into_wall(-acted.force),
                shear: state.turn_into_wall(-acted.tangential),
                normal: action.normal.total(),
                slip: lost,
            };
            loads.add((side.near.wall.number(), touch.feature), &on_wall);
        }
        if let Some(rubs) = reported.rubs.as_mut().filter(|_| acted.touches) {
            let mut centre_velocity = a.velocity;
            if state.moves {
                centre_velocity -= state.velocity.at(meeting.earlier + meeting.arm);
            }
            if let Some(own) = meeting.own {
                centre_velocity -= own;
            }
            // A driven particle does not come to rest at the wall: it is no projectile.
            let arrives = !acted.touched && a.inverse_mass > 0.0;
            let impact = arrives.then(|| Impact {
                mass: a.inverse_mass.recip(),
                diameter: 2.0 * a.radius,
                speed: centre_velocity.length(),
                approach: -centre_velocity.dot(contact.normal.into()),
            });
            rubs.push(Rub {
                wall: side.near.wall.number(),
                feature: touch.feature,
                foot: state.into_wall(side.centre) - touch.normal * touch.distance,
                normal: touch.normal,
                load: mean_load,
                way: sliding.length() * dt,
                slip: law.slip(contact, action, &acted.before, &slot.history, dt),
                work: lost,
                impact,
            });
        }
    }

    /// Adds a contact with a wall to the observation, also to the load on the wall.
    #[inline(always)]
    fn see_wall(
        &self,
        a: &Particle,
        at: &WallTouch<'_>,
        meeting: &WallMeeting,
        acted: WallAction<Histories<N, T, R, A>>,
        after: Histories<N, T, R, A>,
        observation: &mut Observation,
    ) {
        let (side, state) = (at.side, at.side.state);
        let (contact, action) = (&meeting.contact, &acted.action);
        let (force, couple) = (acted.force, acted.couple);
        observation.wall_contacts += u64::from(acted.touches);
        let site = ContactSite {
            pair: acted.pair,
            row: side.near.row as usize,
            partner: Partner::Wall {
                wall: side.near.wall,
                image: side.near.image,
            },
            b: None,
            sheet: at.sheet.map(AtSheet::place),
            joined: acted.joined,
            feature: at.touch.feature,
            lever: meeting.lever,
            depth: contact.overlap / a.radius,
            touches: acted.touches,
        };
        self.see(observation, a, site, contact, action, [acted.before, after]);
        let point = side.centre + meeting.arm;
        let (wall_load, power) = &mut observation.walls[side.near.wall.index()];
        let about = point - state.reference;
        wall_load.add(-force, -about.cross(force) - couple);
        *power += force.dot(state.velocity.at(point)) + couple.dot(state.velocity.angular_velocity);
        if let Some(own) = meeting.own {
            *power += force.dot(own);
        }
        if acted.touches {
            // A neck has no secant stiffness; Hertz' contact of its radius bounds the slope.
            let contact = self.laws[acted.pair].adhesion.as_hertz(contact);
            observation.wall_stiffness[side.near.wall.index()].add_contact(
                contact.effective_mass,
                (action.normal.elastic, contact.overlap),
                (action.normal.viscous, contact.normal_velocity),
            );
        }
    }
}

/// A particle within reach of one feature of a wall.
pub(super) struct WallTouch<'a> {
    pub(super) side: &'a WallSide<'a>,
    /// The sheet at this place, if the wall is one.
    pub(super) sheet: Option<&'a AtSheet<'a>>,
    pub(super) touch: &'a Touch,
    /// Number of the entry among those of the block that are near walls.
    pub(super) near: u32,
}

/// Receivers of what a contact with a wall does.
pub(super) struct WallReports<'a, 'b, H> {
    pub(super) observation: &'a mut Observation,
    /// Those of its surface, if it has any.
    pub(super) surface: Option<&'a mut Reported<'b>>,
    pub(super) events: &'a mut Vec<SlotEvent<H>>,
    /// Sums of the loads on each wall; empty unless they are wanted.
    pub(super) wall_loads: &'a mut [Load],
}

/// Geometry of a contact with a wall.
struct WallMeeting {
    contact: Contact,
    /// Distance from the centre to the point of contact, m.
    lever: f64,
    /// From the centre to the point of contact, m.
    arm: DVec3,
    /// Place of the centre at the time of the velocities, m.
    earlier: DVec3,
    /// Velocity of the surface in the wall's frame, m/s; `None`: at rest.
    own: Option<DVec3>,
    /// Velocity along the wall, m/s.
    sliding: DVec3,
}

/// Action of a wall on a particle; `H`: histories.
struct WallAction<H> {
    /// Index of the law.
    pair: usize,
    action: Action,
    /// Force of the law on the particle, without the pull at a saddle, N.
    force: DVec3,
    /// N m
    couple: DVec3,
    /// N
    tangential: DVec3,
    joined: Option<Joined>,
    /// Histories before.
    before: H,
    /// Whether they touched before.
    touched: bool,
    /// Whether they overlap; else adhesion acts across a gap.
    touches: bool,
}

/// The loads and the sliding that contacts with a mesh report.
pub(super) struct Reported<'a> {
    /// Loads on its features, if they are summed up.
    pub(super) loads: Option<&'a mut FeatureLoads>,
    /// Its contacts, if it wears.
    pub(super) rubs: Option<&'a mut Vec<Rub>>,
    /// Their loads on it, if it is a sheet.
    pub(super) sheets: Option<&'a mut Vec<SurfaceLoad>>,
}

/// R* at a wall with the given principal curvatures (1/m, positive if convex towards the particle): the geometric mean of the
/// effective radii in the two principal planes, which Hertz' theory gives for nearly circular contacts (Johnson 1985, eq. 4.28).
fn curved_radius(radius: f64, curvature: [f64; 2]) -> f64 {
    // A concave wall of nearly the particle's own radius would conform to it; the radius is bounded at ten times.
    let in_plane = |kappa: f64| 1.0 / (1.0 / radius + kappa).max(0.1 / radius);
    (in_plane(curvature[0]) * in_plane(curvature[1])).sqrt()
}
