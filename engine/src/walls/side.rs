//! On which side of a curved wall the particles are.

/// The side of a cylinder, cone, sphere or surface of revolution that pushes.
///
/// A wall that pushes on one side only still pushes a centre back that has gone through by less
/// than the query's reach; a centre deeper than that counts as being on the other side, where the
/// wall is not felt. A particle that comes from the other side is therefore caught in the surface
/// as soon as it touches it: where particles can walk round the rim of a bounded wall, the wall
/// should have [`Side::Both`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// The particles are on the side of the axis (of the centre, for a sphere).
    #[default]
    Inside,
    /// The particles are on the side away from the axis.
    Outside,
    /// A thin sheet that pushes away on both sides.
    Both,
}
