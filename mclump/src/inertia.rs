//! Mass, centre of mass and inertia by every route.
