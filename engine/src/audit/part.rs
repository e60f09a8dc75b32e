//! The audit in a step: powers of contacts at the time of the forces, and what leaves with particles and walls.

use glam::DVec3;

use super::losses::ADHESION;
use super::{Audit, AuditedContact, Losses, Powers, Sums};
use crate::bodies::{angular_velocity, constrained_spin};
use crate::forces::{Exchange, FIRST_VERTEX, Needs, Observation, Partner};
use crate::memory::GROWTH;
use crate::physics::Setup;
use crate::state::{Body, FIXED, Load, Pieces, Plain, PrescribedBody, Row};
use crate::step::{Core, Engine, Exchanged, Part, SizeEstimate};
use crate::sums::exact;
use crate::walls::{RigidVelocity, ServoState, WallNow};

/// How a body or a wall moves at the time of the forces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moving {
    /// Of the particle's centre, or of a wall at the contact point, m/s.
    pub(crate) velocity: DVec3,
    /// rad/s
    pub(crate) spin: DVec3,
}

/// The part that audits the energy.
#[derive(Debug, Default)]
pub(crate) struct Auditor {
    sums: Sums,
    /// Dissipated by dry cohesion since the start, J.
    dissipated_adhesion: f64,
    /// The contacts of the last forces, where several ranks divide the rows those of own rows.
    contacts: Vec<AuditedContact>,
    /// Whether those of the other ranks are there, too: in a state that was saved.
    has_others: bool,
}

impl Part for Auditor {
    fn name(&self) -> &str {
        "audit"
    }

    fn of(core: &mut Core) -> Option<Self> {
        let is_wanted = core.physics().energy_budget;
        is_wanted.then(Self::default)
    }

    /// The contacts of the last forces, and what was observed of them.
    fn bytes(setup: &Setup, crowd: &SizeEstimate) -> f64 {
        let each = size_of::<AuditedContact>() + size_of::<Exchange>();
        let is_wanted = f64::from(u8::from(setup.physics.energy_budget));
        is_wanted * GROWTH * crowd.touching * each as f64
    }

    fn needs(&self) -> Needs {
        // The velocities at the time when all forces are known.
        Needs {
            whole_steps: true,
            sums: true,
            ..Needs::default()
        }
    }

    fn after_exchange(&mut self, core: &mut Core, exchanged: &Exchanged) {
        self.keep_own(core);
        if exchanged.changed {
            self.note_leavers(core);
        }
    }

    fn after_forces(&mut self, core: &mut Core, sums: Option<&Observation>) {
        if let Some(sums) = sums {
            self.take_in(core, sums);
        }
    }

    /// Each rank has the contacts of its rows; the sums are those of the first one.
    fn works_on_ranks(&self) -> bool {
        true
    }

    fn collect_from_ranks(&mut self, core: &mut Core) {
        self.keep_own(core);
        join(core, &mut self.contacts);
        self.has_others = true;
    }

    fn put(&self, core: &Core, pieces: &mut Pieces) {
        self.sums.put(pieces.end());
        if core.physics().laws.has_dry_cohesion() {
            self.dissipated_adhesion.put(pieces.end());
        }
        self.contacts.put(pieces.end());
    }

    fn take(&mut self, core: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        self.sums = Plain::take(bytes)?;
        if core.physics().laws.has_dry_cohesion() {
            self.dissipated_adhesion = Plain::take(bytes)?;
        }
        self.contacts = Plain::take(bytes)?;
        self.has_others = true;
        let (rows, walls) = (core.particles.len(), core.domain.walls.len());
        let leads_somewhere = |contact: &AuditedContact| contact.leads_somewhere(rows, walls);
        if !self.contacts.iter().all(leads_somewhere) {
            let reason = "it has audited contacts of particles or walls that are not there";
            return Err(reason.to_owned());
        }
        Ok(())
    }
}

impl Engine {
    /// The energy balance, if the plan includes it.
    #[must_use]
    pub fn audit(&self) -> Audit {
        let auditor = self.part::<Auditor>();
        let sums = auditor.map_or_else(Sums::default, |auditor| auditor.sums);
        let of_walls = |k: usize| self.parts().map(|part| part.wall_work()[k]).sum::<f64>();
        let mut losses = Losses::of_laws([
            sums.dissipated_normal,
            sums.dissipated_tangential,
            sums.dissipated_rolling,
            sums.dissipated_liquid,
        ]);
        if self.physics().laws.has_dry_cohesion() {
            losses.add(
                ADHESION,
                auditor.map_or(0.0, |auditor| auditor.dissipated_adhesion),
            );
        }
        for part in self.parts() {
            if let Some(energy) = part.dissipated() {
                losses.add(part.name(), energy);
            }
        }
        Audit {
            losses,
            wall_work: sums.wall_work + of_walls(0),
            servo_work: sums.servo_work + of_walls(1),
            left: sums.left,
            vanished: sums.vanished,
        }
    }
}

impl Auditor {
    /// Takes the contacts of the force evaluation just made into the sums.
    fn take_in(&mut self, core: &mut Core, observation: &Observation) {
        core.fetch_loads();
        self.note_vanished_walls(core);
        let dt = core.since_last();
        let fields: Vec<_> = (0..core.domain.walls.len())
            .map(|wall| core.wall_fields(wall, dt))
            .collect();
        let reports = core.contacts.reports();
        // All ranks have the vertices of sheets: they count once.
        let is_first = core.is_first();
        let counts = |exchanges: &&[Exchange]| {
            let of_vertices = |exchange: &Exchange| exchange.row >= FIRST_VERTEX;
            is_first || !exchanges.first().is_some_and(of_vertices)
        };
        let exchanges = || {
            let blocks = reports.iter();
            let exchanges = blocks.map(|reports| &reports.observation.exchanges[..]);
            exchanges.filter(counts)
        };
        let blocks = exchanges().map(|exchanges| powers(core, &fields, exchanges, dt).to_array());
        let powers = exact(blocks);
        let contacts = exchanges().flatten().map(AuditedContact::of).collect();
        let powers = core.add_exactly(powers).map(|sum| sum.value());
        let powers = Powers::from_array(powers);
        self.sums.take_in(observation, powers, dt);
        if dt > 0.0 {
            self.dissipated_adhesion += observation.dissipated_by_adhesion;
        }
        self.contacts = contacts;
        self.has_others = false;
    }

    /// Lets go of the contacts of other ranks, before a list gives rows other numbers.
    fn keep_own(&mut self, core: &Core) {
        if std::mem::take(&mut self.has_others) && core.is_divided() {
            let own = core.own_rows();
            self.contacts.retain(|contact| match contact.is_vertex() {
                true => core.is_first(),
                false => own.contains(&(contact.row as usize)),
            });
        }
    }

    /// Particles were removed since the last forces, and no list was built yet: what their contacts stored leaves with them.
    fn note_leavers(&mut self, core: &mut Core) {
        let boundaries = core.boundaries();
        let is_gone = |contact: &mut AuditedContact| {
            !contact.is_vertex() && boundaries.is_removed(contact.row)
                || !contact.is_wall && boundaries.is_removed(contact.partner)
        };
        let gone = self.contacts.extract_if(.., is_gone).collect();
        self.let_go(core, gone, false);
    }

    /// Notes the contacts of walls that were there at the last forces and are not at these.
    fn note_vanished_walls(&mut self, core: &mut Core) {
        let walls = &core.domain.walls;
        if walls.iter().all(|wall| wall.state.present) {
            return;
        }
        let is_gone = |contact: &&AuditedContact| {
            contact.is_wall && !walls[contact.partner as usize].state.present
        };
        let gone = self.contacts.iter().filter(is_gone).copied().collect();
        self.let_go(core, gone, true);
    }

    /// Takes account of contacts that are gone, of all ranks.
    fn let_go(&mut self, core: &mut Core, mut gone: Vec<AuditedContact>, by_wall: bool) {
        join(core, &mut gone);
        for contact in &gone {
            self.sums.let_go(&contact.stored, by_wall);
        }
    }
}

/// Puts contacts that each rank has together, in the order of one process: blocks, then vertices of sheets.
fn join(core: &mut Core, contacts: &mut Vec<AuditedContact>) {
    core.join_ranks(contacts);
    contacts.sort_by_key(AuditedContact::is_vertex);
}

/// Powers of the contacts of a block, W; `fields`: velocities of each wall, `dt` (s) ends with these forces.
fn powers(core: &Core, fields: &[[RigidVelocity; 2]], exchanges: &[Exchange], dt: f64) -> Powers {
    let mut powers = Powers::default();
    for exchange in exchanges {
        let Exchange {
            normal,
            levers,
            force,
            lossy,
            tangential,
            adhesive,
            couple,
            adhesive_couple,
            ..
        } = *exchange;
        let a = core.moving(Row::new(exchange.row as usize), 0.5 * dt);
        let mut velocity = a.velocity + a.spin.cross(-normal * levers[0]);
        let mut spin = a.spin;
        let b = match exchange.partner {
            Partner::Particle { row, .. } => {
                let b = core.moving(Row::new(row as usize), 0.5 * dt);
                Moving {
                    velocity: b.velocity + b.spin.cross(normal * levers[1]),
                    ..b
                }
            }
            Partner::Wall { .. } if exchange.sheet.is_some() => {
                core.moving_sheet(exchange, 0.5 * dt)
            }
            Partner::Wall { wall, .. } => {
                let [before, after] = &fields[wall.index()];
                let b = Moving {
                    velocity: 0.5 * (before.at(exchange.point) + after.at(exchange.point)),
                    spin: 0.5 * (before.angular_velocity + after.angular_velocity),
                };
                let power = force.dot(b.velocity) + couple.dot(b.spin);
                powers.walls += power;
                if !core.domain.walls[wall.index()].servos.is_empty() {
                    powers.servos += power;
                }
                b
            }
        };
        velocity -= b.velocity;
        spin -= b.spin;
        powers.normal -= (normal * lossy).dot(velocity);
        powers.tangential -= tangential.dot(velocity);
        powers.liquid -= adhesive.dot(velocity) + adhesive_couple.dot(spin);
        powers.rolling -= (couple - adhesive_couple).dot(spin);
    }
    powers
}

impl Core {
    /// The velocities of a wall half a step before and after the present forces; before the first step those of the start.
    pub(crate) fn wall_fields(&self, wall: usize, dt: f64) -> [RigidVelocity; 2] {
        let Some(planned) = self.physics().walls.get(wall) else {
            return [RigidVelocity::REST; 2];
        };
        let WallNow { state, servos, .. } = &self.domain.walls[wall];
        if !state.moves || dt == 0.0 {
            return [state.velocity; 2];
        }
        // Of servos whose time has not come or is over, nothing comes of what they would do next.
        let motors = planned.motion.all_servos().zip(servos);
        let next: Vec<ServoState> = motors
            .map(|(motor, state)| ServoState {
                velocity: motor.advance(*state, self.time() + dt, dt).velocity,
                ..*state
            })
            .collect();
        let after = planned
            .motion
            .driven_velocity(self.time() + 0.5 * dt, &next);
        [state.velocity, after]
    }

    /// How a particle moves at the time of the present forces, `half` (s) after the velocities that are kept.
    pub(crate) fn moving(&self, row: Row, half: f64) -> Moving {
        if row.index() >= FIRST_VERTEX as usize {
            return self.moving_vertex(row.index() - FIRST_VERTEX as usize, half);
        }
        let particles = &self.particles;
        let record = &particles.records[row.index()];
        let mut moving = Moving {
            velocity: record.velocity,
            spin: record.angular_velocity,
        };
        if record.flags & FIXED != 0 {
            return moving;
        }
        if let Some(bodies) = &particles.bodies
            && let Some(pebble) = bodies.of_row[row.index()]
        {
            let pebble = &bodies.pebbles[pebble.index()];
            let body = &bodies.all[pebble.body.index()];
            let prescribed = bodies.prescribed.iter().find(|it| it.body == pebble.body);
            return self.moving_body(body, prescribed, body.orientation * pebble.offset, half);
        }
        let Load { force, torque, .. } = particles.loads[row.index()];
        let acceleration = force * record.inverse_mass + self.physics().gravity;
        moving.velocity += acceleration * half;
        if self.turns() {
            let per_torque =
                self.inverse_inertia() * record.inverse_mass / (record.radius * record.radius);
            moving.spin += torque * (per_torque * half);
        }
        if let Some(prescribed) = particles.prescribed.iter().find(|it| it.row == row) {
            for axis in 0..3 {
                if let Some(velocity) = prescribed.velocity[axis] {
                    moving.velocity[axis] = velocity;
                }
                if let Some(spin) = prescribed.angular_velocity[axis] {
                    moving.spin[axis] = spin;
                }
            }
        }
        moving
    }

    /// Motion of a vertex, by its number among those of all sheets.
    fn moving_vertex(&self, mut number: usize, half: f64) -> Moving {
        for surface in &self.domain.surfaces {
            if let Some(velocity) = surface.velocities.get(number) {
                let kick = surface.kick(number, half, self.physics().gravity);
                return Moving {
                    velocity: *velocity + kick,
                    spin: DVec3::ZERO,
                };
            }
            number -= surface.positions.len();
        }
        Moving {
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
        }
    }

    /// Motion of a point of a sheet, whose own energy counts: it does no work as walls do.
    fn moving_sheet(&self, exchange: &Exchange, half: f64) -> Moving {
        let at = exchange.sheet.unwrap_or_default();
        let surface = &self.domain.surfaces[usize::from(at.0)];
        let [velocity, spin] = surface.moving(&at.1, half, self.physics().gravity);
        Moving { velocity, spin }
    }

    /// Motion of a body, at the end of `lever` (m) from its centre. An audit does not close for prescribed components.
    fn moving_body(
        &self,
        body: &Body,
        prescribed: Option<&PrescribedBody>,
        lever: DVec3,
        half: f64,
    ) -> Moving {
        let acceleration = body.load.force / body.mass + self.physics().gravity;
        let momentum = body.angular_momentum + body.load.torque * half;
        let mut velocity = body.velocity + acceleration * half;
        let mut spins = [None; 3];
        if let Some(prescribed) = prescribed {
            for axis in 0..3 {
                velocity[axis] = prescribed.velocity[axis].unwrap_or(velocity[axis]);
            }
            spins = prescribed.angular_velocity;
        }
        let spin = if spins == [None; 3] {
            angular_velocity(body.orientation, momentum, body.moments)
        } else {
            let kicked = Body {
                angular_momentum: momentum,
                ..*body
            };
            constrained_spin(&kicked, spins)
        };
        Moving {
            velocity: velocity + spin.cross(lever),
            spin,
        }
    }
}
