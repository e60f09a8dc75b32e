//! All bonds of a run, in groups of as many as there are lanes at most: what each step reads and writes, column by column.

use std::array::from_fn;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DQuat, DVec3};

use super::bond::{Bond, Surroundings};
use super::element::{Action, Element, Modes};
use super::evaluation::{Motion, Rotation};
use crate::lanes::{MOST_LANES, Mask, Quad, Real, Task, Vector, Width};
use crate::parallel::each_part;
use crate::state::Load;

/// Groups that a thread takes at a time.
const CHUNK: usize = 256;

/// A number of each bond of a group.
type Column = [f64; MOST_LANES];

/// Force on end A (N), and couples on A and B (N m), each with a zero behind it.
type Loads = [Quad; 3];

/// The bonds that hold, in the order in which they were glued.
#[derive(Debug, Default)]
pub(super) struct Groups {
    heads: Vec<Head>,
    /// The last group repeats the last bond behind it.
    groups: Vec<Group>,
    /// Of each lane of each group, at the last forces.
    loads: Vec<Loads>,
    /// Walls that are glued, by index.
    walls: BTreeSet<u32>,
}

/// Values of a bond that no step reads.
#[derive(Debug, Clone, Copy)]
struct Head {
    plan: u32,
    ids: [u32; 2],
    is_wall: bool,
    anchor: DVec3,
}

/// Bonds side by side.
#[derive(Debug)]
struct Group {
    /// Rows of both ends; in place of a wall the row of end A.
    rows: [[u32; MOST_LANES]; 2],
    /// Bit k: end B of bond k is a wall.
    walls: u32,
    is_damped: bool,
    element: Element<Column>,
    /// The frame of the gluing, in that of each end: x, y, z, w.
    frames: [[Column; 4]; 2],
    strengths: [Column; 2],
    branch: [Column; 3],
    /// At the last forces.
    stresses: [Column; 2],
    /// At the last forces, and at those before.
    energies: [Column; 2],
}

impl Groups {
    /// Memory of a bond, bytes.
    pub(super) const BYTES_OF_BOND: usize =
        size_of::<Head>() + size_of::<Group>() / MOST_LANES + size_of::<Loads>();

    pub(super) fn new(bonds: &[Bond]) -> Self {
        let head = |bond: &Bond| Head {
            plan: bond.plan,
            ids: bond.ids,
            is_wall: bond.is_wall,
            anchor: bond.anchor,
        };
        let mut loads = Vec::with_capacity(bonds.len().next_multiple_of(MOST_LANES));
        let group = |few: &[Bond]| {
            let group = Group::new(|k| &few[k.min(few.len() - 1)]);
            loads.extend((0..MOST_LANES).map(|k| {
                let now = &few[k.min(few.len() - 1)].now;
                [now.force, now.couples[0], now.couples[1]].map(|v| Quad([v.x, v.y, v.z, 0.0]))
            }));
            group
        };
        Self {
            heads: bonds.iter().map(head).collect(),
            groups: bonds.chunks(MOST_LANES).map(group).collect(),
            loads,
            walls: (bonds.iter().filter(|bond| bond.is_wall))
                .map(|bond| bond.ids[1])
                .collect(),
        }
    }

    /// Walls that are glued, by index.
    pub(super) fn walls(&self) -> &BTreeSet<u32> {
        &self.walls
    }

    pub(super) fn len(&self) -> usize {
        self.heads.len()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Bond> + '_ {
        (0..self.len()).map(|k| self.bond(k))
    }

    /// Bonds to walls.
    pub(super) fn at_walls(&self) -> impl Iterator<Item = Bond> + '_ {
        let all = 0..self.len();
        let is_wall = |k: &usize| self.groups[k / MOST_LANES].walls >> (k % MOST_LANES) & 1 == 1;
        all.filter(is_wall).map(|k| self.bond(k))
    }

    fn bond(&self, k: usize) -> Bond {
        self.groups[k / MOST_LANES].bond(k % MOST_LANES, &self.heads[k], &self.loads[k])
    }

    /// Takes the rows of the ends of all bonds, by their ids and whether the second is a wall.
    pub(super) fn set_rows(&mut self, rows: impl Fn([u32; 2], bool) -> [u32; 2]) {
        let Some(last) = self.heads.last() else {
            return;
        };
        for (group, number) in self.groups.iter_mut().zip(0..) {
            for k in 0..MOST_LANES {
                let head = self.heads.get(number * MOST_LANES + k).unwrap_or(last);
                group.set_rows(k, rows(head.ids, head.is_wall), head.is_wall);
            }
        }
    }

    /// Sum of the elastic energies at the last forces, J.
    pub(super) fn elastic_energy(&self) -> f64 {
        let lanes = self.groups.iter().flat_map(|group| group.energies[0]);
        lanes.take(self.len()).sum()
    }

    /// Computes the loads of all bonds; returns whether a strength was reached.
    pub(super) fn act(&mut self, around: &Surroundings<'_>, width: Width, parallel: bool) -> bool {
        let parallel = parallel && self.groups.len() > CHUNK;
        let broken = AtomicBool::new(false);
        let heads = self.heads.chunks(CHUNK * MOST_LANES);
        let loads = self.loads.chunks_mut(CHUNK * MOST_LANES);
        let chunks = self.groups.chunks_mut(CHUNK).zip(loads).zip(heads);
        each_part(parallel, chunks, |((groups, loads), heads)| {
            let act = Act {
                heads,
                groups,
                loads,
                around,
            };
            if width.run(act) {
                broken.store(true, Ordering::Relaxed);
            }
        });
        broken.into_inner()
    }

    /// Adds the loads to those of the particles, in the order of the bonds.
    pub(super) fn add_loads(&self, particles: &mut [Load]) {
        let mut left = self.len();
        for (group, loads) in self.groups.iter().zip(self.loads.chunks_exact(MOST_LANES)) {
            for (k, [force, on_a, on_b]) in loads.iter().enumerate().take(left) {
                let [row, other] = group.rows.map(|rows| rows[k] as usize);
                let [forces, torques] = particles[row].quads_mut();
                *forces += *force;
                *torques += *on_a;
                if group.walls >> k & 1 == 0 {
                    let [forces, torques] = particles[other].quads_mut();
                    *forces -= *force;
                    *torques += *on_b;
                }
            }
            left = left.saturating_sub(MOST_LANES);
        }
    }
}

impl Group {
    fn new<'a>(bond: impl Fn(usize) -> &'a Bond) -> Self {
        let column = |of: &dyn Fn(&Bond) -> f64| from_fn(|k| of(bond(k)));
        let mut new = Self {
            rows: [[0; MOST_LANES]; 2],
            walls: 0,
            is_damped: (0..MOST_LANES).any(|k| bond(k).element.is_damped()),
            element: Element::side_by_side(|k| bond(k).element),
            frames: from_fn(|end| from_fn(|x| column(&|bond| bond.frames[end].to_array()[x]))),
            strengths: from_fn(|mode| column(&|bond| bond.strengths[mode])),
            branch: from_fn(|axis| column(&|bond| bond.branch[axis])),
            stresses: from_fn(|mode| column(&|bond| bond.now.stresses[mode])),
            energies: [
                column(&|bond| bond.now.energy),
                column(&|bond| bond.last_energy),
            ],
        };
        for k in 0..MOST_LANES {
            new.walls |= u32::from(bond(k).is_wall) << k;
            new.set_rows(k, bond(k).rows, bond(k).is_wall);
        }
        new
    }

    fn set_rows(&mut self, k: usize, [row, other]: [u32; 2], is_wall: bool) {
        self.rows[0][k] = row;
        self.rows[1][k] = if is_wall { row } else { other };
    }

    fn bond(&self, k: usize, head: &Head, &[force, on_a, on_b]: &Loads) -> Bond {
        let Head {
            plan,
            ids,
            is_wall,
            anchor,
        } = *head;
        let [row, other] = self.rows.map(|rows| rows[k]);
        let frame = |[x, y, z, w]: [Column; 4]| DQuat::from_xyzw(x[k], y[k], z[k], w[k]);
        Bond {
            plan,
            ids,
            is_wall,
            rows: [row, if is_wall { ids[1] } else { other }],
            element: self.element.of(k),
            frames: self.frames.map(frame),
            anchor,
            branch: DVec3::from(self.branch.map(|column| column[k])),
            strengths: self.strengths.map(|column| column[k]),
            now: Action {
                force: force.into(),
                couples: [on_a.into(), on_b.into()],
                stresses: self.stresses.map(|column| column[k]),
                energy: self.energies[0][k],
            },
            last_energy: self.energies[1][k],
        }
    }
}

impl Modes<Column> {
    fn side_by_side(of: impl Fn(usize) -> Modes) -> Self {
        Self {
            normal: from_fn(|k| of(k).normal),
            shear: from_fn(|k| of(k).shear),
            twist: from_fn(|k| of(k).twist),
            bending: from_fn(|k| of(k).bending),
        }
    }

    fn of(&self, k: usize) -> Modes {
        Modes {
            normal: self.normal[k],
            shear: self.shear[k],
            twist: self.twist[k],
            bending: self.bending[k],
        }
    }

    #[inline(always)]
    fn load<L: Real>(&self, at: usize) -> Modes<L> {
        Modes {
            normal: L::load(&self.normal[at..]),
            shear: L::load(&self.shear[at..]),
            twist: L::load(&self.twist[at..]),
            bending: L::load(&self.bending[at..]),
        }
    }
}

impl Element<Column> {
    fn side_by_side(of: impl Fn(usize) -> Element) -> Self {
        Self {
            length: from_fn(|k| of(k).length),
            radius: from_fn(|k| of(k).radius),
            stiffness: Modes::side_by_side(|k| of(k).stiffness),
            damping: Modes::side_by_side(|k| of(k).damping),
        }
    }

    fn of(&self, k: usize) -> Element {
        Element {
            length: self.length[k],
            radius: self.radius[k],
            stiffness: self.stiffness.of(k),
            damping: self.damping.of(k),
        }
    }

    #[inline(always)]
    fn load<L: Real>(&self, at: usize) -> Element<L> {
        Element {
            length: L::load(&self.length[at..]),
            radius: L::load(&self.radius[at..]),
            stiffness: self.stiffness.load(at),
            damping: self.damping.load(at),
        }
    }
}

/// Three columns as a vector.
#[inline(always)]
fn vector<L: Real>([x, y, z]: &[Column; 3], at: usize) -> Vector<L> {
    Vector::new(L::load(&x[at..]), L::load(&y[at..]), L::load(&z[at..]))
}

/// Loads of a chunk of bonds; the result is whether a strength was reached.
struct Act<'a> {
    heads: &'a [Head],
    groups: &'a mut [Group],
    loads: &'a mut [Loads],
    around: &'a Surroundings<'a>,
}

impl Task for Act<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Real>(self) -> bool {
        let Self {
            heads,
            groups,
            loads,
            around,
        } = self;
        let records = &around.particles.records;
        let mut broken = false;
        let loads = loads.chunks_exact_mut(MOST_LANES);
        for ((number, group), loads) in groups.iter_mut().enumerate().zip(loads) {
            // Plain loops: `map` over these arrays is not inlined.
            let of_walls;
            let mut ends = [[&[Quad([0.0; 4]); 3]; MOST_LANES]; 2];
            let mut orientations = [[Quad([0.0; 4]); MOST_LANES]; 2];
            for (end, rows) in group.rows.iter().enumerate() {
                for (k, &row) in rows.iter().enumerate() {
                    ends[end][k] = records[row as usize].quads();
                    orientations[end][k] = Quad(around.orientation(row as usize).to_array());
                }
            }
            if group.walls != 0 {
                of_walls = walls_of(&heads[number * MOST_LANES..], around);
                for (k, (end, orientation)) in of_walls.iter().enumerate() {
                    if group.walls >> k & 1 == 1 {
                        ends[1][k] = end;
                        orientations[1][k] = *orientation;
                    }
                }
            }
            for at in (0..MOST_LANES).step_by(L::LANES) {
                broken |= evaluate::<L>((group, loads), at, (&ends, &orientations), around);
            }
        }
        broken
    }
}

/// Ends of bonds at walls: place, velocity and angular velocity as records of particles have them, and orientation.
#[inline(never)]
fn walls_of(heads: &[Head], around: &Surroundings<'_>) -> [([Quad; 3], Quad); MOST_LANES] {
    from_fn(|k| {
        let head = heads[k.min(heads.len() - 1)];
        if !head.is_wall {
            return Default::default();
        }
        let state = &around.walls[head.ids[1] as usize].state;
        let point = state.pose.to_global(head.anchor);
        let quads = [
            point,
            state.velocity.at(point),
            state.velocity.angular_velocity,
        ];
        (
            quads.map(|v| Quad([v.x, v.y, v.z, 0.0])),
            Quad(state.pose.rotation.to_array()),
        )
    })
}

/// Loads of the bonds from `at` on, as many as there are lanes.
#[inline(always)]
fn evaluate<L: Real>(
    (group, loads): (&mut Group, &mut [Loads]),
    at: usize,
    (ends, orientations): (&[[&[Quad; 3]; MOST_LANES]; 2], &[[Quad; MOST_LANES]; 2]),
    around: &Surroundings<'_>,
) -> bool {
    let [a, b] = ends;
    let [x, y, z, _] = L::differences(|k| &b[at + k][0], |k| &a[at + k][0]);
    let mut branch = Vector::new(x, y, z);
    if around.cell.has_images() {
        branch = nearest_image(branch, vector(&group.branch, at), around);
    }
    let rotations = [
        rotation::<L>(&orientations[0], &group.frames[0], at),
        rotation::<L>(&orientations[1], &group.frames[1], at),
    ];
    let motion;
    let motion = if group.is_damped {
        let [x, y, z, _] = L::differences(|k| &b[at + k][1], |k| &a[at + k][1]);
        motion = Motion {
            velocity: Vector::new(x, y, z),
            spins: [L::vectors(|k| &a[at + k][2]), L::vectors(|k| &b[at + k][2])],
        };
        Some(&motion)
    } else {
        None
    };
    let now = group.element.load::<L>(at).loads(branch, rotations, motion);
    for (column, number) in group.branch.iter_mut().zip(branch.to_array()) {
        number.store(&mut column[at..]);
    }
    let [energy, last_energy] = &mut group.energies;
    L::load(&energy[at..]).store(&mut last_energy[at..]);
    now.energy.store(&mut energy[at..]);
    let [tension, shear] = now.stresses;
    tension.store(&mut group.stresses[0][at..]);
    shear.store(&mut group.stresses[1][at..]);
    let on_ends = [
        L::rows(now.force, L::ZERO),
        L::rows(now.couples[0], L::ZERO),
        L::rows(now.couples[1], L::ZERO),
    ];
    for (k, loads) in loads[at..at + L::LANES].iter_mut().enumerate() {
        *loads = [on_ends[0][k], on_ends[1][k], on_ends[2][k]];
    }
    // A stress that is not a number breaks nothing: the step finds its particle.
    let strengths = &group.strengths;
    let broken =
        L::load(&strengths[0][at..]).at_most(tension) | L::load(&strengths[1][at..]).at_most(shear);
    broken.any()
}

/// Rotations of ends from the gluing.
#[inline(always)]
fn rotation<L: Real>(
    orientations: &[Quad; MOST_LANES],
    [i, j, k, real]: &[Column; 4],
    at: usize,
) -> Rotation<L> {
    let [x, y, z, w] = L::columns(|k| &orientations[at + k]);
    let orientation = Rotation {
        vector: Vector::new(x, y, z),
        real: w,
    };
    let frame = Rotation {
        vector: Vector::new(L::load(&i[at..]), L::load(&j[at..]), L::load(&k[at..])),
        real: L::load(&real[at..]),
    };
    orientation.times(frame)
}

/// Branches by the images nearest to where they were: beyond half a period a bond is still that of its own image.
#[inline(always)]
fn nearest_image<L: Real>(
    branch: Vector<L>,
    before: Vector<L>,
    around: &Surroundings<'_>,
) -> Vector<L> {
    let way = branch - before;
    let half = around.cell.size() * 0.5;
    let periodic = around.cell.periodic();
    let limit = |axis: usize| {
        L::splat(if periodic[axis] {
            half[axis]
        } else {
            f64::INFINITY
        })
    };
    let is_near =
        way.x.abs().below(limit(0)) & way.y.abs().below(limit(1)) & way.z.abs().below(limit(2));
    if is_near.all() {
        return branch;
    }
    let image = |k: usize| {
        let way = DVec3::from(way.lane(k));
        Vector::from(around.cell.min_image(way, DVec3::ZERO).0)
    };
    Vector::select(is_near, branch, before + Vector::gather(image))
}
