//! Contacts with walls.

use std::ops::Range;

use glam::DVec3;

use super::block::Block;
use super::bonds::SlotEvent;
use super::contact_point::mobility;
use super::pass::{ContactSite, Pass, Rows};
use super::sheets::AtSheet;
use super::sides::{self, from_behind};
use super::slots::{BEHIND, FREE, JOINED, THROUGH, TOUCHING, WITH_HISTORY, WallSlot, with_history};
use crate::contact::{
    AdhesionLaw, Contact, Event, FrictionNow, Histories, History, NormalLaw, RollingLaw,
    TangentialLaw,
};
use crate::forces::{
    Alarms, FeatureLoad, FeatureLoads, Impact, NearWall, Observation, Partner, Rub,
};
use crate::lanes::Vector;
use crate::state::{Load, Particle};
use crate::surface::SurfaceLoad;
use crate::walls::{Mesh, NearMeshes, Scratch, Shape, Touch, Touches, WallNow, WallState};

/// Radii of a vertex to which walls that act on both sides hold it from behind: four times the thickness of its sheet.
const HELD: f64 = 8.0;

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    pub(super) fn walls(
        &self,
        block: &mut Block<Histories<N, T, R, A>>,
        rows: &Rows<'_>,
        loads: &mut [Load],
    ) {
        let context = self.context;
        let mut memory = (Touches::default(), Scratch::default());
        let mut first = 0;
        for index in 0..block.near_walls.len() {
            let near = &block.near_walls[index];
            let wall = &context.walls[near.wall.index()];
            let state = &wall.state;
            let row = near.row as usize - block.rows.start;
            let a = &rows.own[row];
            if wall.may_join() {
                let near_walls = &mut block.near_walls;
                let of_wall = images_of_wall(near_walls, index);
                let of_wall = &mut near_walls[of_wall];
                self.hand_over(a, wall, of_wall, first, &mut block.wall_slots);
            }
            let near = &mut block.near_walls[index];
            let centre = a.position + context.cell.any_shift(near.image);
            let side = WallSide {
                near: *near,
                wall,
                state,
                centre,
            };
            let load = &mut loads[row];
            let Shape::Plane(plane) = wall.shape() else {
                near.features = self.features(
                    a,
                    &side,
                    &mut block.wall_slots,
                    first,
                    (index, &mut block.near_meshes, &mut block.events),
                    &mut memory,
                    load,
                    &mut block.observation,
                    (
                        &mut block.feature_loads,
                        &mut block.rubs,
                        &mut block.surface_loads,
                    ),
                    &mut block.alarms,
                );
                first += near.features as usize;
                continue;
            };
            // A plane has one feature: most walls of most scenes need no search.
            let slot = &mut block.wall_slots[first];
            first += near.features as usize;
            let touch = if state.present {
                plane.touch(state.into_wall(centre), self.wall_reach(a, wall))
            } else {
                None
            };
            match touch {
                Some(touch) => {
                    slot.feature = touch.feature;
                    if self.is_alarming(a, wall, &touch, 0) {
                        self.alarm_wall(&mut block.alarms, a, (&side, None), &touch, 0);
                    }
                    let observation = &mut block.observation;
                    let events = (index as u32, &mut block.events);
                    let side = (&side, None);
                    self.touch_wall(a, side, &touch, slot, load, observation, None, events);
                }
                None => {
                    let event = SlotEvent::forgotten(near, slot);
                    block.events.extend(event);
                    slot.clear();
                }
            }
        }
    }

    /// The contacts of a particle with the features of a wall that is no plane; its slots begin at `first`. Returns their number
    /// then. Separate from the loop, which is faster without it.
    #[inline(never)]
    fn features(
        &self,
        a: &Particle,
        side: &WallSide<'_>,
        wall_slots: &mut Vec<WallSlot<Histories<N, T, R, A>>>,
        first: usize,
        (index, near_meshes, events): (usize, &mut NearMeshes, &mut Vec<SlotEvent>),
        (touches, scratch): &mut (Touches, Scratch),
        load: &mut Load,
        observation: &mut Observation,
        (feature_loads, rubs, surface_loads): (
            &mut FeatureLoads,
            &mut Vec<Rub>,
            &mut Vec<SurfaceLoad>,
        ),
        alarms: &mut Alarms,
    ) -> u32 {
        let (near, state) = (&side.near, side.state);
        let place = state.into_wall(side.centre);
        let contact_reach = self.wall_reach(a, side.wall);
        let holds = self.holds_from_behind(side.wall);
        let reach = if holds {
            contact_reach + held_depth(a.radius)
        } else {
            contact_reach
        };
        touches.clear();
        if state.present {
            match side.wall.shape() {
                Shape::Mesh(mesh) => {
                    near_meshes.touches(index, mesh, place, reach, scratch, touches);
                }
                shape => shape.touches(place, reach, touches),
            }
        }
        if side.wall.may_join() {
            let mut others = Touches::default();
            let by = (near.image, reach);
            (side.wall).keep_own(self.context.cell, a.position, by, touches, &mut others);
        }
        if A::ACTIVE {
            // A centre deeper than its radius is on the other side, however far adhesion reaches.
            let all = std::mem::take(touches);
            let outside = |touch: &&Touch| touch.distance > -a.radius;
            all.iter()
                .filter(outside)
                .for_each(|&touch| touches.push(touch));
        }
        let mut features = near.features;
        // On its way into a concave corner a particle may meet a face onto which its centre did not project when
        // the list was built.
        while (features as usize) < touches.len() {
            wall_slots.insert(first + features as usize, WallSlot::free());
            features += 1;
        }
        let slots = &mut wall_slots[first..first + features as usize];
        let mut released = Vec::new();
        let mut forget = |slot: &mut WallSlot<_>| {
            events.extend(SlotEvent::forgotten(near, slot));
            released.extend(Released::of(slot));
            slot.clear();
        };
        let saddles = scratch.saddles();
        let joins = !A::ACTIVE && !saddles.is_empty() && side.wall.surface().is_some();
        match side.wall.shape() {
            shape if holds => {
                // On its way through it comes from one side of a face to the other, which may be features of their own.
                let goes_on = |from: u32, touch: &Touch| {
                    touch.distance < contact_reach
                        || match shape {
                            Shape::Mesh(mesh) => mesh.continues(from, touch, place).is_some(),
                            _ => shape.adjacent(from, touch.feature),
                        }
                };
                assign(slots, touches, goes_on, &mut forget);
            }
            Shape::Mesh(mesh) => assign_on_mesh(slots, touches, mesh, || place, &mut forget),
            shape => {
                let goes_on = |from: u32, touch: &Touch| shape.adjacent(from, touch.feature);
                assign(slots, touches, goes_on, &mut forget);
            }
        }
        if joins {
            Self::change_roles(slots, saddles);
        }
        let is_mesh = matches!(side.wall.shape(), Shape::Mesh(_));
        let is_sheet = side.wall.surface().is_some();
        let is_summed = is_mesh && !is_sheet && self.context.feature_loads;
        let mut reported = (is_summed || side.wall.wears() || is_sheet).then(|| Reported {
            loads: is_summed.then_some(feature_loads),
            rubs: side.wall.wears().then_some(rubs),
            sheets: is_sheet.then_some(surface_loads),
        });
        for slot in slots {
            let touch = touches.iter().find(|touch| touch.feature == slot.feature);
            let sheet =
                touch.and_then(|touch| AtSheet::of(side, self.context.surfaces, saddles, touch));
            let sheet = sheet.as_ref();
            // What is held on both sides is not moved by a contact.
            let is_held = sheet.is_some_and(|sheet| sheet.inverse_mass + a.inverse_mass == 0.0);
            let seen = touch.filter(|_| !is_held).map(|touch| {
                let at = self.side_of(a, (side, sheet), touch, slot.state);
                (touch, at)
            });
            // What is held from behind is looked for from farther away.
            let acts = |(touch, at): &(&Touch, u32)| *at != 0 || touch.distance < contact_reach;
            match seen.filter(acts) {
                Some((touch, at)) => {
                    let (reported, wall, side) = (reported.as_mut(), side.wall, (side, sheet));
                    // A surface that acts on both sides shows any centre its own one.
                    let is_through = at == THROUGH && touch.distance > 0.0;
                    let turned = (at == BEHIND || is_through).then(|| from_behind(touch));
                    let acting = turned.as_ref().unwrap_or(touch);
                    let named = if is_through { acting } else { touch };
                    if self.is_alarming(a, wall, named, at) {
                        self.alarm_wall(alarms, a, side, named, at);
                    }
                    let events = (index as u32, &mut *events);
                    self.touch_wall(a, side, acting, slot, load, observation, reported, events);
                    slot.state |= at;
                    if joins && saddles.iter().any(|saddle| saddle.of == slot.feature) {
                        slot.state |= JOINED;
                    }
                }
                None => {
                    events.extend(SlotEvent::forgotten(near, slot));
                    released.extend(Released::of(slot));
                    slot.clear();
                }
            }
        }
        // What a wall that vanishes takes away is not dissipated.
        if let (Some(reported), Shape::Mesh(mesh), true) =
            (&mut reported, side.wall.shape(), state.present)
        {
            for ended in &released {
                self.report_release(a, side, (mesh, ended), reported);
            }
        }
        features
    }

    /// Reports the last step of a contact that has ended: from its last forces to none.
    fn report_release(
        &self,
        a: &Particle,
        side: &WallSide<'_>,
        (mesh, ended): (&Mesh, &Released),
        reported: &mut Reported<'_>,
    ) {
        let (state, dt) = (side.state, self.context.spring_time);
        let place = state.into_wall(side.centre);
        let foot = mesh.foot_on(ended.feature, place);
        let away = (place - foot).normalize_or_zero();
        let normal = if ended.is_behind { -away } else { away };
        let outward = state.out_of_wall(normal);
        let arm = outward * -a.radius;
        let mut velocity = a.velocity + a.angular_velocity.cross(arm);
        if state.moves {
            let earlier = side.centre - a.velocity * self.context.velocity_lag;
            velocity -= state.velocity.at(earlier + arm);
        }
        let sliding = velocity - outward * velocity.dot(outward);
        let none = FrictionNow::default();
        let lost = ended.last.loss_until(&none, sliding, dt);
        let wall = side.near.wall.number();
        if let Some(loads) = &mut reported.loads {
            let slipped = FeatureLoad {
                slip: lost,
                ..FeatureLoad::default()
            };
            loads.add((wall, ended.feature), &slipped);
        }
        if let Some(rubs) = &mut reported.rubs {
            let way = sliding.length() * dt;
            rubs.push(Rub {
                wall,
                feature: ended.feature,
                foot,
                normal,
                load: ended.last.mean_load(&none),
                way,
                slip: way,
                work: lost,
                impact: None,
            });
        }
    }

    /// On which side of the wall a touch acts, as bits of its slot.
    #[inline]
    fn side_of(
        &self,
        a: &Particle,
        (side, sheet): (&WallSide<'_>, Option<&AtSheet<'_>>),
        touch: &Touch,
        before: u32,
    ) -> u32 {
        let holds = self.holds_from_behind(side.wall);
        if touch.distance >= 0.0 && before & BEHIND == 0 && !holds {
            return 0;
        }
        let normal = side.state.out_of_wall(touch.normal);
        let at = side.centre - normal * touch.distance;
        let velocity = a.velocity - side.velocity(sheet, at);
        let last = touch.distance - velocity.dot(normal) * self.context.spring_time;
        if holds {
            // The normal points to where the centre is.
            let (was_through, has_crossed) = (before & THROUGH != 0, last < 0.0);
            return if was_through != has_crossed {
                THROUGH
            } else {
                0
            };
        }
        sides::side(before, [touch.distance, last])
    }

    /// Whether a wall that acts on both sides pushes back what has gone through it: vertices of sheets, which are small spheres with the
    /// mass of their surroundings, and may go deep.
    #[inline]
    fn holds_from_behind(&self, wall: &WallNow) -> bool {
        self.sheet.is_some() && !wall.shape().is_one_sided()
    }

    /// The largest distance (m) at which the centre of a particle interacts with a wall: its radius, half the thickness of a sheet, and
    /// the range of adhesion.
    #[inline(always)]
    pub(super) fn wall_reach(&self, a: &Particle, wall: &WallNow) -> f64 {
        let reach = a.radius + wall.half_thickness();
        if A::ACTIVE {
            let pair = a.material.index() * self.materials + wall.material.index();
            reach + self.laws[pair].adhesion.range()
        } else {
            reach
        }
    }

    /// The contact of a particle with one feature of a wall, which may be the shape of a sheet; its load and sliding are added to the report.
    #[inline(always)]
    fn touch_wall(
        &self,
        a: &Particle,
        (side, sheet): (&WallSide<'_>, Option<&AtSheet<'_>>),
        touch: &Touch,
        slot: &mut WallSlot<Histories<N, T, R, A>>,
        load: &mut Load,
        observation: &mut Observation,
        mut reported: Option<&mut Reported<'_>>,
        (at, events): (u32, &mut Vec<SlotEvent>),
    ) {
        let (context, state) = (self.context, side.state);
        let reach = a.radius + side.wall.half_thickness();
        let overlap = reach - touch.distance;
        let touches = !A::ACTIVE || overlap > 0.0;
        if !touches && A::FORMS_ON_CONTACT && slot.state & WITH_HISTORY == 0 {
            let films = context.films.filter(|_| A::HAS_EVENTS);
            let on_wall = || {
                let films = context.wall_films?;
                let place = films.place(side.near.wall.index(), touch.feature, context.walls)?;
                Some([films.thickness(place), films.within_reach(place, a.radius)])
            };
            let pair = a.material.index() * self.materials + side.wall.material.index();
            let least = self.laws[pair].adhesion.least_films();
            let meet = |films: &[[f64; 2]]| {
                let [thickness, volume] = films[side.near.row as usize];
                if thickness >= -overlap && volume >= least {
                    return true;
                }
                let [on_wall, reach] = on_wall().unwrap_or_default();
                thickness + on_wall >= -overlap && volume + reach >= least
            };
            if !films.is_some_and(meet) {
                return;
            }
        }
        let normal = state.out_of_wall(touch.normal);
        // First, while there is little that the call could push out of registers.
        let effective_mass = match self.bodies {
            None => 1.0 / a.inverse_mass,
            Some(bodies) => 1.0 / mobility(bodies, side.near.row as usize, a, normal),
        };
        // A sheet answers with its own mass, and is touched where it is: the lever of the particle and the shares of the vertices mean the
        // same point.
        let (effective_mass, lever) = match sheet {
            None => (effective_mass, a.radius - 0.5 * overlap),
            Some(sheet) => (
                1.0 / (1.0 / effective_mass + sheet.inverse_mass),
                touch.distance,
            ),
        };
        let arm = normal * -lever;
        // The place of the centre at the time of these velocities: on a wall that turns they differ from place to place.
        let earlier = side.centre - a.velocity * context.velocity_lag;
        let velocity_at = |arm: DVec3| {
            let velocity = a.velocity + a.angular_velocity.cross(arm);
            if state.moves {
                velocity - state.velocity.at(earlier + arm)
            } else if let Some(sheet) = sheet {
                velocity - sheet.velocity
            } else {
                velocity
            }
        };
        let velocity = velocity_at(arm);
        let mut spin = a.angular_velocity;
        let mut spin_of_sheet = DVec3::ZERO;
        if let Some(sheet) = sheet
            && (T::ACTIVE || R::ACTIVE)
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
        if lag > 0.0 && (T::ACTIVE || R::ACTIVE || A::SHEARS) {
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
        let pair = a.material.index() * self.materials + side.wall.material.index();
        let law = &self.laws[pair];
        let (before, touched) = (slot.history, slot.state & TOUCHING != 0);
        let dt = context.spring_time;
        let mut action = if touches {
            law.act(&contact, dt, &mut slot.history)
        } else {
            law.act_apart(&contact, dt, &mut slot.history)
        };
        let mut joined = None;
        if let Some(sheet) = sheet
            && let Some(saddle) = &sheet.saddle
        {
            let (left, of_saddle) = Self::join(law, &contact, (saddle, reach), &action);
            (action, joined) = (left, Some(of_saddle));
        }
        slot.state = if A::ACTIVE {
            with_history(touches, &slot.history.3)
        } else {
            TOUCHING
        };
        let (force, couple) = (DVec3::from(action.force), DVec3::from(action.couple));
        if A::HAS_EVENTS && law.adhesion.event(&contact, &slot.history.3) {
            events.push(SlotEvent::Wall {
                near: at,
                feature: touch.feature,
                event: Event::of(&slot.history.bridge()),
            });
        }
        let tangential = DVec3::from(action.shear(A::SHEARS));
        load.add(force, couple + arm.cross(tangential));
        if let (Some(reported), Some(sheet)) = (reported.as_deref_mut(), sheet)
            && let Some(loads) = &mut reported.sheets
        {
            loads.push(sheet.load(force, couple));
            if let (Some(joined), Some(saddle)) = (&joined, &sheet.saddle) {
                load.add(joined.pull, DVec3::ZERO);
                loads.push(sheet.load_at(saddle, side.centre, joined.pull));
                // What is seen of the contact is all that it does to the particle.
                action.force += Vector::from(joined.pull);
            }
        } else if let Some(reported) = reported {
            let now = touches.then(|| law.friction_now(&contact, &action, &slot.history));
            // A new contact begins without force. Of one that goes on from another run the forces before are not known.
            let last = match slot.friction {
                None if touched => now,
                last => Some(last.unwrap_or_default()),
            };
            let (mut lost, mut mean_load) = (0.0, 0.0);
            // At the start no time has passed.
            if let Some(last) = last.filter(|_| dt > 0.0) {
                let next = now.unwrap_or_default();
                mean_load = last.mean_load(&next);
                lost = last.loss_until(&next, sliding, dt);
            }
            slot.friction = now;
            if let Some(loads) = &mut reported.loads {
                let on_wall = FeatureLoad {
                    force: state.turn_into_wall(-force),
                    shear: state.turn_into_wall(-tangential),
                    normal: action.normal.total(),
                    slip: lost,
                };
                loads.add((side.near.wall.number(), touch.feature), &on_wall);
            }
            if let Some(rubs) = reported.rubs.as_mut().filter(|_| touches) {
                let centre_velocity = if state.moves {
                    a.velocity - state.velocity.at(earlier + arm)
                } else {
                    a.velocity
                };
                // A driven particle does not come to rest at the wall: it is no projectile.
                let arrives = !touched && a.inverse_mass > 0.0;
                let impact = arrives.then(|| Impact {
                    mass: a.inverse_mass.recip(),
                    diameter: 2.0 * a.radius,
                    speed: centre_velocity.length(),
                    approach: -centre_velocity.dot(normal),
                });
                rubs.push(Rub {
                    wall: side.near.wall.number(),
                    feature: touch.feature,
                    foot: state.into_wall(side.centre) - touch.normal * touch.distance,
                    normal: touch.normal,
                    load: mean_load,
                    way: sliding.length() * dt,
                    slip: law.slip(&contact, &action, &before, &slot.history, dt),
                    work: lost,
                    impact,
                });
            }
        }
        if context.watch.is_some() {
            observation.wall_contacts += u64::from(touches);
            let partner = Partner::Wall {
                wall: side.near.wall,
                image: side.near.image,
            };
            let depth = overlap / a.radius;
            let site = ContactSite {
                pair,
                row: side.near.row as usize,
                partner,
                b: None,
                sheet: sheet.map(AtSheet::place),
                joined,
                feature: touch.feature,
                lever,
                depth,
                touches,
            };
            self.see(
                observation,
                a,
                site,
                &contact,
                &action,
                [before, slot.history],
            );
            let point = side.centre + arm;
            let (wall_load, power) = &mut observation.walls[side.near.wall.index()];
            let about = point - state.reference;
            wall_load.add(-force, -about.cross(force) - couple);
            *power +=
                force.dot(state.velocity.at(point)) + couple.dot(state.velocity.angular_velocity);
            if touches {
                observation.wall_stiffness[side.near.wall.index()].add_contact(
                    contact.effective_mass,
                    (action.normal.elastic, overlap),
                    (action.normal.viscous, normal_velocity),
                );
            }
        }
    }
}

/// A contact with a mesh that has ended, and what friction did in it last.
struct Released {
    feature: u32,
    is_behind: bool,
    last: FrictionNow,
}

impl Released {
    fn of<H>(slot: &WallSlot<H>) -> Option<Self> {
        Some(Self {
            feature: slot.feature,
            is_behind: slot.state & BEHIND != 0,
            last: slot.friction?,
        })
    }
}

/// How deep behind a surface that acts on both sides the centre of a vertex of this radius (m) is still pushed back to where it came from, m.
pub(in crate::forces) fn held_depth(radius: f64) -> f64 {
    HELD * radius
}

/// The loads and the sliding that contacts with a mesh report.
struct Reported<'a> {
    /// Loads on its features, if they are summed up.
    loads: Option<&'a mut FeatureLoads>,
    /// Its contacts, if it wears.
    rubs: Option<&'a mut Vec<Rub>>,
    /// What they do to it, if it is a sheet.
    sheets: Option<&'a mut Vec<SurfaceLoad>>,
}

/// The wall's side of a contact.
pub(super) struct WallSide<'a> {
    pub(super) near: NearWall,
    pub(super) wall: &'a WallNow,
    pub(super) state: &'a WallState,
    /// Centre of the particle's image that is near, m.
    pub(super) centre: DVec3,
}

impl WallSide<'_> {
    /// Velocity of the wall at a place, m/s; of a `sheet` where it is touched.
    pub(super) fn velocity(&self, sheet: Option<&AtSheet<'_>>, at: DVec3) -> DVec3 {
        match sheet {
            None => self.state.velocity.at(at),
            Some(sheet) => sheet.velocity,
        }
    }
}

/// The entries of the same particle and wall, from the first of them; none for the others.
fn images_of_wall(near_walls: &[NearWall], index: usize) -> Range<usize> {
    let key = |near: &NearWall| (near.row, near.wall);
    let own = key(&near_walls[index]);
    if index > 0 && key(&near_walls[index - 1]) == own {
        return index..index;
    }
    let others = near_walls[index..].iter();
    index..index + others.take_while(|near| key(near) == own).count()
}

/// Gives every touched feature a slot. A feature that was touched before keeps its own; a new one takes the slot, and the
/// history, of a feature that is no longer touched and of which it `goes_on`, or else a free slot without history.
fn assign<H: History>(
    slots: &mut [WallSlot<H>],
    touches: &Touches,
    goes_on: impl Fn(u32, &Touch) -> bool,
    forget: &mut impl FnMut(&mut WallSlot<H>),
) {
    for touch in touches.iter() {
        if slots.iter().any(|slot| slot.feature == touch.feature) {
            continue;
        }
        let left = |slot: &WallSlot<H>| {
            slot.feature == FREE || !touches.iter().any(|touch| touch.feature == slot.feature)
        };
        let from = slots
            .iter()
            .position(|slot| slot.feature != FREE && left(slot) && goes_on(slot.feature, touch));
        match from.or_else(|| slots.iter().position(left)) {
            Some(index) => {
                if from.is_none() {
                    forget(&mut slots[index]);
                }
                slots[index].feature = touch.feature;
            }
            // There are at least as many slots as touches.
            None => debug_assert!(false, "no slot for a feature of a wall"),
        }
    }
}

/// The same on a mesh, where a contact may pass many triangles in a step: a new contact takes the slot of the one that is no
/// longer there and whose feature is nearest now.
fn assign_on_mesh<H: History>(
    slots: &mut [WallSlot<H>],
    touches: &Touches,
    mesh: &Mesh,
    centre: impl Fn() -> DVec3,
    forget: &mut impl FnMut(&mut WallSlot<H>),
) {
    for touch in touches.iter() {
        if slots.iter().any(|slot| slot.feature == touch.feature) {
            continue;
        }
        let left = |slot: &WallSlot<H>| {
            slot.feature == FREE || !touches.iter().any(|touch| touch.feature == slot.feature)
        };
        let mut from: Option<(f64, usize)> = None;
        for (index, slot) in slots.iter().enumerate() {
            if slot.feature != FREE
                && left(slot)
                && let Some(part) = mesh.continues(slot.feature, touch, centre())
                && from.is_none_or(|(least, _)| part < least)
            {
                from = Some((part, index));
            }
        }
        match from {
            Some((_, index)) => slots[index].feature = touch.feature,
            None => match slots.iter().position(left) {
                Some(index) => {
                    forget(&mut slots[index]);
                    slots[index].feature = touch.feature;
                }
                // There are at least as many slots as touches.
                None => debug_assert!(false, "no slot for a feature of a wall"),
            },
        }
    }
}

/// R* at a wall with the given principal curvatures (1/m, positive if convex towards the particle): the geometric mean of the
/// effective radii in the two principal planes, which Hertz' theory gives for nearly circular contacts (Johnson 1985, eq. 4.28).
fn curved_radius(radius: f64, curvature: [f64; 2]) -> f64 {
    // A concave wall of nearly the particle's own radius would conform to it; the radius is bounded at ten times.
    let in_plane = |kappa: f64| 1.0 / (1.0 / radius + kappa).max(0.1 / radius);
    (in_plane(curvature[0]) * in_plane(curvature[1])).sqrt()
}
