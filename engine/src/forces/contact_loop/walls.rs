//! Contacts with walls.

use std::ops::Range;

use glam::DVec3;

use super::block::Block;
use super::pass::{Pass, Rows};
use super::sheets::AtSheet;
use super::sides::{self, from_behind};
use super::slot_events::SlotEvents;
use super::slots::{BEHIND, FREE, JOINED, THROUGH, WallSlot};
use super::touch_wall::{Reported, WallReports, WallTouch};
use crate::contact::{
    AdhesionLaw, FrictionNow, Histories, History, NormalLaw, RollingLaw, TangentialLaw,
};
use crate::forces::{FeatureLoad, NearWall, Reports, Rub};
use crate::state::{Load, Particle};
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
                    (index, &mut block.near_meshes),
                    &mut block.events,
                    &mut memory,
                    load,
                    &mut block.reports,
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
                        self.alarm_wall(&mut block.reports.alarms, a, (&side, None), &touch, 0);
                    }
                    let at = WallTouch {
                        side: &side,
                        sheet: None,
                        touch: &touch,
                        near: index as u32,
                    };
                    let reports = WallReports {
                        observation: &mut block.reports.observation,
                        surface: None,
                        events: &mut block.events,
                        wall_loads: &mut block.reports.wall_loads,
                    };
                    self.touch_wall(a, &at, slot, load, reports);
                }
                None => {
                    let event = Self::forgotten(near, slot);
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
        (index, near_meshes): (usize, &mut NearMeshes),
        events: &mut SlotEvents<Histories<N, T, R, A>>,
        (touches, scratch): &mut (Touches, Scratch),
        load: &mut Load,
        reports: &mut Reports,
    ) -> u32 {
        let Reports {
            observation,
            alarms,
            feature_loads,
            rubs,
            surface_loads,
            wall_loads,
        } = reports;
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
            events.extend(Self::forgotten(near, slot));
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
            // A contact moves nothing where both sides are held.
            let is_held = sheet.is_some_and(|sheet| sheet.inverse_mass + a.inverse_mass == 0.0);
            let seen = touch.filter(|_| !is_held).map(|touch| {
                let at = self.side_of(a, (side, sheet), touch, slot.state);
                (touch, at)
            });
            // A vertex that is held from behind is looked for from farther away.
            let acts = |(touch, at): &(&Touch, u32)| *at != 0 || touch.distance < contact_reach;
            match seen.filter(acts) {
                Some((touch, at)) => {
                    // A surface that acts on both sides shows any centre its own one.
                    let is_through = at == THROUGH && touch.distance > 0.0;
                    let turned = (at == BEHIND || is_through).then(|| from_behind(touch));
                    let acting = turned.as_ref().unwrap_or(touch);
                    let named = if is_through { acting } else { touch };
                    if self.is_alarming(a, side.wall, named, at) {
                        self.alarm_wall(alarms, a, (side, sheet), named, at);
                    }
                    let wall_touch = WallTouch {
                        side,
                        sheet,
                        touch: acting,
                        near: index as u32,
                    };
                    let reports = WallReports {
                        observation,
                        surface: reported.as_mut(),
                        events,
                        wall_loads,
                    };
                    self.touch_wall(a, &wall_touch, slot, load, reports);
                    slot.state |= at;
                    if joins && saddles.iter().any(|saddle| saddle.of == slot.feature) {
                        slot.state |= JOINED;
                    }
                }
                None => {
                    events.extend(Self::forgotten(near, slot));
                    released.extend(Released::of(slot));
                    slot.clear();
                }
            }
        }
        // Energy that a wall takes away as it vanishes is not dissipated.
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
        if let Some(own) = side.own_velocity(ended.feature) {
            velocity -= own;
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
        let velocity = a.velocity - side.velocity(sheet, touch.feature, at);
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

/// The wall's side of a contact.
pub(super) struct WallSide<'a> {
    pub(super) near: NearWall,
    pub(super) wall: &'a WallNow,
    pub(super) state: &'a WallState,
    /// Centre of the particle's image that is near, m.
    pub(super) centre: DVec3,
}

impl WallSide<'_> {
    /// Velocity of the wall at a place, m/s, at a touch of this feature; of a `sheet` where it is touched.
    pub(super) fn velocity(&self, sheet: Option<&AtSheet<'_>>, feature: u32, at: DVec3) -> DVec3 {
        match sheet {
            None => {
                let of_frame = self.state.velocity.at(at);
                let own = self.own_velocity(feature);
                own.map_or(of_frame, |own| of_frame + own)
            }
            Some(sheet) => sheet.velocity,
        }
    }

    /// Velocity of the surface beside that of the wall's frame where the feature is touched, m/s; `None`: it is at rest in that frame.
    #[inline(always)]
    pub(super) fn own_velocity(&self, feature: u32) -> Option<DVec3> {
        let place = || self.state.into_wall(self.centre);
        let velocity = self.wall.surface_velocity(feature, place)?;
        Some(self.state.out_of_wall(velocity))
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

/// Assigns touches on a mesh, where a contact may pass many triangles in a step: a new contact takes the slot of the one that is
/// no longer there and whose feature is nearest now.
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
