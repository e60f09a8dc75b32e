//! A wall as it is now: what changes of it while the plan's [`Wall`] stays as it is.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::drive::{Drive, pose_at};
use super::error::finite_vector;
use super::images::MetBy;
use super::near_box::Corners;
use super::{Pose, RigidVelocity, ServoState, Shape, Wall, WallError, WallState};
use crate::cell::Cell;
use crate::state::MaterialIndex;

/// A wall as it is now: its surface, where it stands, how far its servos have come.
///
/// The engine owns one for each wall of the plan, in its order. The surface is the plan's until something changes it; meshes are
/// shared with the plan until then.
#[derive(Debug, Clone)]
pub struct WallNow {
    /// Index of the material.
    pub material: MaterialIndex,
    /// Where it stands in this step, and how it moves.
    pub state: WallState,
    /// How far each of its servos has come, in the order of the motions.
    pub servos: Vec<ServoState>,
    /// Its present window, if another program drives it.
    drive: Option<Drive>,
    shape: Shape,
    /// Images that meet the wall.
    met_by: MetBy,
    /// Whole periods that were taken off its way, m: now, and when the candidate list was built.
    taken_off: [DVec3; 2],
    /// Where it stood when the candidate list was built.
    listed_pose: Pose,
    /// Whether its surface is another one than the plan's.
    is_reshaped: bool,
    /// How far points of the surface have moved in the wall's frame since the candidate list was built, at most, m.
    reshaped_by: f64,
    /// Velocities of the corners of its mesh in the wall's frame in this step, m/s; empty: the surface is at rest there.
    corner_velocities: Vec<DVec3>,
    /// Whether contacts with it are reported, as it wears.
    wears: bool,
    /// Number of the sheet whose shape it borrows, if it is no wall of the plan.
    surface: Option<u16>,
    /// How far it reaches beyond its triangles on each side, m: half the thickness of a sheet, nothing for walls.
    half_thickness: f64,
}

/// State of a [`WallNow`] that must be kept to go on later, beside the time.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedWall {
    /// How far each of its servos has come.
    pub servos: Vec<ServoState>,
    /// Where it stood when the candidate list was built.
    pub listed_pose: Pose,
    /// How far points of the surface have moved in the wall's frame since then, at most, m.
    pub reshaped_by: f64,
    /// The surface in plain numbers ([`Shape::numbers`]), of a mesh the places of its corners; empty if it is the plan's.
    pub shape: Vec<f64>,
}

crate::state::plain!(SavedWall {
    servos,
    listed_pose,
    reshaped_by,
    shape
});

impl WallNow {
    /// At the start of a run with steps of `dt` (s), in a domain with these images.
    #[must_use]
    pub fn new(wall: &Wall, dt: f64, cell: &Cell) -> Self {
        let mut now = Self {
            material: wall.material,
            state: wall.state(0.0, dt),
            servos: vec![ServoState::default(); wall.motion.all_servos().count()],
            drive: wall.motion.is_external().then_some(Drive::REST),
            shape: wall.shape.clone(),
            met_by: MetBy::new(&wall.shape, cell, keeps_axes(wall)),
            taken_off: [DVec3::ZERO; 2],
            listed_pose: Pose::IDENTITY,
            is_reshaped: false,
            reshaped_by: 0.0,
            corner_velocities: Vec::new(),
            wears: false,
            surface: None,
            half_thickness: 0.0,
        };
        now.set_back(cell);
        now.note_images(cell);
        now
    }

    /// All walls of a plan at the start.
    #[must_use]
    pub fn all(walls: &[Wall], dt: f64, cell: &Cell) -> Vec<Self> {
        walls.iter().map(|wall| Self::new(wall, dt, cell)).collect()
    }

    /// Contacts with it are reported from now on, as it wears.
    pub fn set_wearing(&mut self) {
        self.wears = true;
    }

    /// Whether contacts with it are reported.
    #[inline]
    #[must_use]
    pub fn wears(&self) -> bool {
        self.wears
    }

    /// Borrows the shape of a sheet of this `thickness` (m) from now on.
    pub fn set_surface(&mut self, number: u16, thickness: f64) {
        self.surface = Some(number);
        self.half_thickness = 0.5 * thickness;
    }

    /// How far it reaches beyond its triangles on each side, m: half the thickness of a sheet, 0 for walls.
    #[inline]
    #[must_use]
    pub fn half_thickness(&self) -> f64 {
        self.half_thickness
    }

    /// Number of the sheet whose shape it borrows, if it does.
    #[inline]
    #[must_use]
    pub fn surface(&self) -> Option<u16> {
        self.surface
    }

    /// Puts the corners of its mesh to where those of its sheet are, m. `since_listed`: how far points of the sheet are from where they
    /// were when the candidate list was built, at most, m.
    ///
    /// # Errors
    /// As [`WallNow::reshape`].
    pub fn follow(
        &mut self,
        corners: &[DVec3],
        since_listed: f64,
        cell: &Cell,
    ) -> Result<(), WallError> {
        self.reshape(corners, cell)?;
        self.reshaped_by = since_listed;
        Ok(())
    }

    /// Points of the surface are at most so far from where they were when the candidate list was built, m, although the mesh stays.
    pub fn note_way(&mut self, since_listed: f64) {
        self.reshaped_by = since_listed;
    }

    /// Fits its mesh, if it is one that has moved since: what is looked for in it is found sooner.
    pub fn fit(&mut self) {
        if let Shape::Mesh(mesh) = &mut self.shape
            && mesh.late() > 0.0
        {
            Arc::make_mut(mesh).fit();
        }
    }

    /// Takes these places of the corners in one go from any earlier shape.
    ///
    /// # Errors
    /// If the mesh cannot take these places.
    pub fn follow_anew(
        &mut self,
        corners: &[DVec3],
        since_listed: f64,
        cell: &Cell,
    ) -> Result<(), WallError> {
        let numbers: Vec<f64> = corners.iter().flat_map(|x| x.to_array()).collect();
        self.shape = self.shape.with_numbers(&numbers)?;
        self.note_reshaped(0.0, cell);
        self.reshaped_by = since_listed;
        Ok(())
    }

    /// The surface in the wall's own frame.
    #[inline]
    #[must_use]
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Puts the corners of its mesh to new places, m, in the wall's frame ([`Mesh::reshape`](super::Mesh::reshape)).
    ///
    /// # Errors
    /// If it is no mesh, or the mesh cannot take these places; it stays as it was then.
    pub fn reshape(&mut self, corners: &[DVec3], cell: &Cell) -> Result<(), WallError> {
        let Shape::Mesh(mesh) = &mut self.shape else {
            return Err(WallError::OtherShape);
        };
        // The plan keeps its own.
        let way = Arc::make_mut(mesh).reshape(corners)?;
        self.note_reshaped(way, cell);
        Ok(())
    }

    /// Gives the corners of its mesh velocities in the wall's frame (m/s, half a step before the positions) until the next step; empty: at rest.
    ///
    /// # Errors
    /// If it has not as many corners, or a velocity is not finite.
    pub fn set_corner_velocities(&mut self, velocities: Vec<DVec3>) -> Result<(), WallError> {
        let corners = self.shape.mesh().map_or(0, |mesh| mesh.corners().len());
        if !velocities.is_empty() && velocities.len() != corners {
            let given = velocities.len();
            return Err(WallError::Corners { corners, given });
        }
        for &velocity in &velocities {
            finite_vector("velocities of corners", velocity)?;
        }
        self.corner_velocities = velocities;
        Ok(())
    }

    /// Velocity of the surface at the nearest point of a feature to `place` (m), all in the wall's frame, m/s: the mean of its corners with the
    /// weights of the point. `None`: at rest.
    #[inline]
    #[must_use]
    pub fn surface_velocity(&self, feature: u32, place: impl FnOnce() -> DVec3) -> Option<DVec3> {
        if self.corner_velocities.is_empty() {
            return None;
        }
        let mesh = self.shape.mesh()?;
        let base = mesh.base(feature, mesh.foot_on(feature, place()));
        let parts = base.corners.iter().zip(base.weights);
        Some(parts.fold(DVec3::ZERO, |sum, (&corner, weight)| {
            sum + self.corner_velocities[corner as usize] * weight
        }))
    }

    /// Takes another surface of the same kind, in the same frame; meshes are [reshaped](WallNow::reshape).
    ///
    /// # Errors
    /// If it has not the same faces and edges.
    pub fn exchange(&mut self, shape: Shape, cell: &Cell) -> Result<(), WallError> {
        let way = self.shape.way_to(&shape)?;
        self.shape = shape;
        self.note_reshaped(way, cell);
        Ok(())
    }

    fn note_reshaped(&mut self, way: f64, cell: &Cell) {
        self.is_reshaped = true;
        self.reshaped_by += way;
        self.met_by = self.met_by.of_shape(&self.shape, cell);
        self.note_images(cell);
    }

    /// Moves on by a step of `dt` (s) that ends at `time` (s), as planned, in a domain with these images.
    pub fn advance(&mut self, wall: &Wall, time: f64, dt: f64, cell: &Cell) {
        self.corner_velocities.clear();
        for (motor, state) in wall.motion.all_servos().zip(&mut self.servos) {
            *state = motor.advance(*state, time, dt);
        }
        if wall.motion.is_static() {
            self.state.present = wall.is_present(time, dt);
        } else {
            let before = self.state.pose.translation;
            self.state = self.state_of(wall, time, dt);
            self.set_back(cell);
            // Set back by a period it is somewhere else at once, and found by other images before the next list.
            let gone = (self.state.pose.translation - before).abs();
            if gone.cmpgt(0.25 * cell.size()).any() {
                self.note_images(cell);
            }
        }
    }

    /// Pose and velocities at `time` (s), along periodic axes in a domain that goes on for ever.
    fn at(&self, wall: &Wall, time: f64, servos: &[ServoState]) -> (Pose, RigidVelocity) {
        match &self.drive {
            Some(drive) => (drive.pose(time), drive.velocity(time)),
            None => (
                wall.motion.driven_pose(time, servos),
                wall.motion.driven_velocity(time, servos),
            ),
        }
    }

    /// The state in the step of `dt` (s) that ends at `time` (s).
    fn state_of(&self, wall: &Wall, time: f64, dt: f64) -> WallState {
        match &self.drive {
            Some(drive) => wall.state_by(
                time,
                dt,
                |time| drive.pose(time),
                |time| drive.velocity(time),
            ),
            None => wall.driven_state(time, dt, &self.servos),
        }
    }

    /// The present window of a wall that another program drives.
    #[must_use]
    pub fn drive(&self) -> Option<&Drive> {
        self.drive.as_ref()
    }

    /// Its motion in the next window (s): with velocities of its reference point (m/s) and about it (rad/s) to a place of this point (m) and a turn since
    /// the start.
    ///
    /// # Errors
    /// If the scene does not leave its motion to another program, or a number is not finite.
    pub fn next_drive(
        &self,
        wall: &Wall,
        window: [f64; 2],
        (place, turn): (DVec3, DQuat),
        velocities: [DVec3; 2],
    ) -> Result<Drive, WallError> {
        let drive = self.drive.as_ref().ok_or(WallError::NotExternal)?;
        finite_vector("place", place)?;
        finite_vector("velocity", velocities[0])?;
        finite_vector("angular_velocity", velocities[1])?;
        let length = turn.length();
        if !(length.is_finite() && length > 0.0) {
            return Err(WallError::NoTurn { length });
        }
        let target = pose_at(wall.reference, place, turn / length);
        Ok(drive.next(window, target, wall.reference, velocities))
    }

    /// Drives it so, from the next step on.
    pub fn set_drive(&mut self, drive: Drive) {
        self.drive = Some(drive);
    }

    /// Goes on with a window at `time` (s) with steps of `dt` (s), the rest of the wall being restored.
    pub fn restore_drive(
        &mut self,
        wall: &Wall,
        drive: Drive,
        (time, dt): (f64, f64),
        cell: &Cell,
    ) {
        self.drive = Some(drive);
        self.state = self.state_of(wall, time, dt);
        self.set_back(cell);
        self.taken_off[1] = self.taken_off[0];
        self.note_images(cell);
    }

    /// The state with its velocities as the plan's wall has them at `time` (s), which is that of the state: contacts see those of half a step before.
    #[must_use]
    pub fn state_at(&self, wall: &Wall, time: f64) -> WallState {
        let mut state = self.state;
        if state.moves {
            let (pose, velocity) = self.at(wall, time, &self.servos);
            let set_back = state.pose.translation - pose.translation;
            state.velocity = velocity;
            state.velocity.origin += set_back;
        }
        state
    }

    /// Where the frame of the wall stood at `time` (s), within the step that ends at `end` (s), and its velocities at that time.
    #[must_use]
    pub fn motion_at(&self, wall: &Wall, time: f64, end: f64) -> (Pose, RigidVelocity) {
        if !self.state.moves {
            return (Pose::IDENTITY, RigidVelocity::REST);
        }
        let before = |servo: &ServoState| ServoState {
            displacement: servo.displacement - (end - time) * servo.velocity,
            ..*servo
        };
        let servos: Vec<ServoState> = self.servos.iter().map(before).collect();
        let (at_end, _) = self.at(wall, end, &self.servos);
        let set_back = self.state.pose.translation - at_end.translation;
        let (mut pose, mut velocity) = self.at(wall, time, &servos);
        pose.translation += set_back;
        velocity.origin += set_back;
        (pose, velocity)
    }

    /// Takes whole periods off the way that it has gone along periodic axes.
    fn set_back(&mut self, cell: &Cell) {
        if self.state.moves {
            let back = self.met_by.whole_periods(&self.state.pose, cell);
            self.state.shift(back);
            self.taken_off[0] = back;
        }
    }

    /// Finds out by which images it is met where it stands.
    pub fn note_images(&mut self, cell: &Cell) {
        let outer = self.outer_box();
        self.met_by.stand(outer, cell);
    }

    /// Codes of the images by which particles meet the wall, where it stood when they were [noted](WallNow::note_images) last and by
    /// less than half a period from there; which of them goes for a particle: [`WallNow::image_of`].
    #[must_use]
    pub fn met_by(&self) -> &[u32] {
        self.met_by.codes()
    }

    /// The image of a particle at `position` (m) that meets the wall, of those that go with the code `met_by`.
    #[inline]
    #[must_use]
    pub fn image_of(&self, position: DVec3, met_by: u32) -> u32 {
        let (shape, state) = (&self.shape, &self.state);
        self.met_by.image_of(shape, state, position, met_by)
    }

    /// The images between which [`WallNow::image_of`] chooses for particles in a box, m.
    pub(super) fn images_of_box(
        &self,
        cell: &Cell,
        corners: Corners,
        met_by: u32,
    ) -> impl Iterator<Item = u32> + use<> {
        let (shape, state) = (&self.shape, &self.state);
        (self.met_by).images_of_box(shape, state, cell, corners, met_by)
    }

    /// Whether places of the surface may lie on its own images: what touches it is sorted out by [`WallNow::keep_own`] then.
    #[inline]
    #[must_use]
    pub fn may_join(&self) -> bool {
        self.met_by.may_join()
    }

    /// The image by which a particle goes on to meet the same copy of the wall as by `image`, when a list is built and puts it into the
    /// domain `way` farther, whole periods, m.
    #[must_use]
    pub fn renamed(&self, cell: &Cell, image: u32, way: DVec3) -> u32 {
        let [now, listed] = self.taken_off;
        self.met_by.renamed(image, way, now - listed, cell)
    }

    /// The candidate list is built with the wall as it is now.
    pub fn note_listed(&mut self) {
        self.taken_off[1] = self.taken_off[0];
        self.listed_pose = self.state.pose;
        self.reshaped_by = 0.0;
    }

    /// Upper bound in m of how far any point of the surface within `reach` of `about` (m) is from the surface as it was when the
    /// candidate list was built; see [`Shape::displacement`].
    #[must_use]
    pub fn displacement_since_listed(&self, about: DVec3, reach: f64) -> f64 {
        let moved = if self.state.moves {
            let (from, to) = (&self.listed_pose, &self.state.pose);
            self.shape.displacement(from, to, about, reach)
        } else {
            0.0
        };
        moved + self.reshaped_by
    }

    /// The way (m) of a point of the surface, in the wall's own frame (m), since the start.
    pub(super) fn way_of(&self, point: DVec3) -> DVec3 {
        if self.state.moves {
            self.state.pose.to_global(point) - self.taken_off[0] - point
        } else {
            DVec3::ZERO
        }
    }

    /// State that must be kept to go on later.
    #[must_use]
    pub fn save(&self) -> SavedWall {
        SavedWall {
            servos: self.servos.clone(),
            listed_pose: self.listed_pose,
            reshaped_by: self.reshaped_by,
            shape: if self.is_reshaped {
                self.shape.numbers()
            } else {
                Vec::new()
            },
        }
    }

    /// Goes on from `saved` at `time` (s) with steps of `dt` (s).
    ///
    /// # Errors
    /// If the saved surface cannot have come from the wall's, or it has another number of servos.
    pub fn restore(
        &mut self,
        wall: &Wall,
        saved: &SavedWall,
        (time, dt): (f64, f64),
        cell: &Cell,
    ) -> Result<(), WallError> {
        self.is_reshaped = !saved.shape.is_empty();
        self.shape = if self.is_reshaped {
            wall.shape.with_numbers(&saved.shape)?
        } else {
            wall.shape.clone()
        };
        self.met_by = self.met_by.of_shape(&self.shape, cell);
        self.reshaped_by = saved.reshaped_by;
        if saved.servos.len() != self.servos.len() {
            return Err(WallError::OtherServos);
        }
        self.servos.clone_from(&saved.servos);
        self.listed_pose = saved.listed_pose;
        self.drive = wall.motion.is_external().then_some(Drive::REST);
        self.state = self.state_of(wall, time, dt);
        self.set_back(cell);
        // A wall that is set back is listed anew in the same step.
        self.taken_off[1] = self.taken_off[0];
        self.note_images(cell);
        Ok(())
    }
}

/// Whether the motion of a wall leaves the direction of each axis as it is.
fn keeps_axes(wall: &Wall) -> [bool; 3] {
    [0, 1, 2].map(|axis| wall.motion.keeps_axis(axis))
}
