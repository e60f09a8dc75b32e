//! Liquid bridges: capillary attraction and viscous forces, in contact and across a gap.
//!
//! The law of a pair evaluates a bridge that is there. Whether there is one, and how much liquid it holds, is decided by the
//! rules of migration ([`crate::liquid`]), which are applied to the [events](super::BridgeEvent) that this law requests: a touch at
//! which a bridge may form, and the gap at which one breaks.

mod bridge;
mod energy;
mod formulas;
mod keys;
mod table;
#[cfg(test)]
mod tests;

pub use bridge::{Bridge, BridgeEvent, BridgeEvents, CURVE, SHORT, saved_numbers, saved_volume};
pub use formulas::{
    Curve, Form, bagheri, end_of_equal_spheres, end_of_unequal_spheres, lian_seville, willett,
    willett_classical,
};
pub(in crate::contact) use keys::KEYS;
pub use table::Tables;

use std::f64::consts::PI;

use libm::{cbrt, exp, log};
pub use mercury_common::scene::{LianSevilleVolume, Lubrication};

use super::young_laplace::{Bound, Table};
use super::{AdhesionForce, AdhesionLaw};
use crate::contact::{Contact, History, NormalForce};
use crate::lanes::{Mask, Real, Vector};

/// Which fit gives the capillary force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fit {
    /// [`bagheri`].
    Bagheri,
    /// [`willett_classical`].
    WillettClassical,
    /// [`lian_seville`].
    LianSeville,
    /// [`willett`].
    Willett,
    /// A [table](Tables) of exact solutions, made before the run.
    YoungLaplace,
}

impl Fit {
    /// How the numbers of its curve give a force.
    #[must_use]
    pub fn form(self) -> Form {
        match self {
            Self::WillettClassical => Form::Exponential,
            Self::Bagheri | Self::LianSeville | Self::Willett => Form::Rational,
            Self::YoungLaplace => Form::Exact,
        }
    }

    /// Its name in scenes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bagheri => "bagheri",
            Self::WillettClassical => "willett-classical",
            Self::LianSeville => "lian-seville",
            Self::Willett => "willett",
            Self::YoungLaplace => "young-laplace",
        }
    }
}

/// Where a bridge breaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rupture {
    /// (1 + θ/2) V^(1/3) (Lian, Thornton & Adams 1993).
    Lian,
    /// [`end_of_equal_spheres`].
    Willett,
    /// [`end_of_unequal_spheres`].
    Radii,
    /// The end of the stable branch, as the table of the pair has it.
    Table,
}

/// The liquid of one pair of materials. No bridge forms where `max_volume` is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Liquid {
    /// Capillary force.
    pub fit: Fit,
    /// Measure of the volume in the fit of Lian & Seville.
    pub lian_seville_volume: LianSevilleVolume,
    /// Where bridges break.
    pub rupture: Rupture,
    /// γ, N/m.
    pub surface_tension: f64,
    /// θ, rad.
    pub contact_angle: f64,
    /// Largest volume of a bridge, m^3.
    pub max_volume: f64,
    /// Least volume of a bridge that forms, m^3.
    pub min_volume: f64,
    /// Share of a broken bridge's liquid that goes to neighbouring bridges.
    pub distribution: f64,
    /// η, Pa s.
    pub viscosity: f64,
    /// Least gap of the viscous force, m; `None`: R*/100.
    pub roughness: Option<f64>,
    /// How the viscous force behaves at small gaps.
    pub lubrication: Lubrication,
    /// Whether its normal part goes on while the two touch.
    pub lubrication_in_contact: bool,
    /// Gap at which the longest bridge of these materials breaks, m.
    pub range: f64,
    /// Largest relative error of the force of [`Fit::YoungLaplace`], and the number of its table.
    pub accuracy: f64,
    /// See `accuracy`.
    pub table: u32,
}

impl Liquid {
    /// No liquid.
    pub const NONE: Self = Self {
        fit: Fit::Bagheri,
        lian_seville_volume: LianSevilleVolume::Relative,
        rupture: Rupture::Radii,
        surface_tension: 0.0,
        contact_angle: 0.0,
        max_volume: 0.0,
        min_volume: 0.0,
        distribution: 1.0,
        viscosity: 0.0,
        roughness: None,
        lubrication: Lubrication::Clamped,
        lubrication_in_contact: false,
        range: 0.0,
        accuracy: 1e-3,
        table: 0,
    };

    /// With the range of bridges between particles of which the smallest has this radius (m): their gaps grow as R_D falls.
    #[must_use]
    pub fn reaching(self, smallest_radius: f64, tables: &Tables) -> Self {
        if self.max_volume <= 0.0 {
            return Self { range: 0.0, ..self };
        }
        if self.fit == Fit::YoungLaplace {
            let longest = tables.get(self.table).map_or(0.0, Table::longest);
            let range = longest * cbrt(self.max_volume);
            return Self { range, ..self };
        }
        let end = self.end(self.max_volume, [smallest_radius; 2], tables);
        // At a wall R_D is twice the radius, and a bridge ends sooner.
        let at_wall = self.end(self.max_volume, [smallest_radius, f64::INFINITY], tables);
        Self {
            range: end.max(at_wall),
            ..self
        }
    }

    /// The gap at which a bridge of the given volume (m^3) breaks between spheres of these radii (m; infinite at a wall), m.
    #[must_use]
    pub fn end(&self, volume: f64, radii: [f64; 2], tables: &Tables) -> f64 {
        let diameter = reduced_diameter(radii);
        let relative = volume / (diameter * diameter * diameter);
        let angle = self.contact_angle;
        match self.rupture {
            _ if volume <= 0.0 => 0.0,
            Rupture::Lian => (1.0 + 0.5 * angle) * cbrt(volume),
            _ if self.takes_cubic_metres() => end_of_equal_spheres(volume, angle),
            Rupture::Willett => diameter * end_of_equal_spheres(relative, angle),
            Rupture::Radii => diameter * end_of_unequal_spheres(relative, angle, ratio_of(radii)),
            Rupture::Table => (tables.get(self.table))
                .map_or(0.0, |table| diameter * table.end(relative, ratio_of(radii))),
        }
    }

    fn takes_cubic_metres(&self) -> bool {
        self.fit == Fit::LianSeville && self.lian_seville_volume == LianSevilleVolume::CubicMetres
    }

    /// A bridge with another volume (m^3), between spheres of these radii (m; infinite at a wall): its end and its force.
    #[must_use]
    pub fn fill(&self, bridge: &Bridge, volume: f64, radii: [f64; 2], tables: &Tables) -> Bridge {
        if volume <= 0.0 {
            return Bridge {
                volume: 0.0,
                end: 0.0,
                curve: [0.0; CURVE],
                ..*bridge
            };
        }
        let diameter = reduced_diameter(radii);
        let relative = volume / (diameter * diameter * diameter);
        let angle = self.contact_angle;
        let strength = self.surface_tension * diameter;
        let (curve, unit) = match self.fit {
            Fit::YoungLaplace => {
                let table = tables.get(self.table);
                let bound = table.map_or(Bound::NONE, |table| {
                    table.bind(relative, ratio_of(radii)).bound
                });
                let bound = bound.scaled(diameter, strength);
                return Bridge {
                    volume,
                    wet: 1.0,
                    end: bound.end,
                    curve: table::curve_of(&bound),
                    ..*bridge
                };
            }
            Fit::Bagheri => (bagheri(relative, angle), diameter),
            Fit::WillettClassical => (willett_classical(relative, angle), diameter),
            Fit::Willett => (willett(relative, angle), diameter),
            Fit::LianSeville if self.takes_cubic_metres() => {
                let end = end_of_equal_spheres(volume, angle);
                (lian_seville(volume, angle, end), 1.0)
            }
            Fit::LianSeville => {
                let end = end_of_equal_spheres(relative, angle);
                (lian_seville(relative, angle, end), diameter)
            }
        };
        let [f, a, p, q, j] = curve;
        let curve = match self.fit.form() {
            Form::Exponential => [f * strength, a, p, q, j / unit],
            Form::Rational | Form::Exact => {
                [f * strength, a / unit, p / unit, q / (unit * unit), 0.0]
            }
        };
        let filled = Bridge {
            volume,
            wet: 1.0,
            end: self.end(volume, radii, tables),
            gap: bridge.gap,
            force: bridge.force,
            curve,
        };
        filled.resized()
    }

    /// Whether the fit has no force for a bridge of this volume (m^3) between spheres of these radii (m; infinite at a wall): its
    /// denominator vanishes at a gap up to the end, or it pulls or pushes at the touch with more than 2π γ R_D, the pull of an infinitely
    /// small bridge at θ = 0, which no bridge reaches.
    #[must_use]
    pub fn has_pole(&self, volume: f64, radii: [f64; 2], tables: &Tables) -> bool {
        if self.fit.form() != Form::Rational {
            return false;
        }
        let bridge = self.fill(&Bridge::default(), volume, radii, tables);
        let [touch, _, p, q, _] = bridge.resized::<SHORT>().curve;
        let most = 2.0 * PI * self.surface_tension * reduced_diameter(radii);
        let denominator = |s: f64| 1.0 + s * (p + q * s);
        // It is least at an end of the gap, or where it turns.
        let turn = (-0.5 * p / q).clamp(0.0, bridge.end);
        let least = denominator(turn).min(denominator(bridge.end));
        // A number that is none is no force either.
        !(least > 0.0 && touch.abs() <= (1.0 + 1e-9) * most)
    }

    /// Whether the nearest bridge of a table stands for one of this volume (m^3).
    #[must_use]
    pub fn is_clamped(&self, volume: f64, radii: [f64; 2], tables: &Tables) -> bool {
        let diameter = reduced_diameter(radii);
        let relative = volume / (diameter * diameter * diameter);
        self.fit == Fit::YoungLaplace
            && tables
                .get(self.table)
                .is_some_and(|table| !table.holds(relative, ratio_of(radii)))
    }

    /// Lateral area of a bridge at the gap of the last force evaluation, m^2, by the exact bridges of the pair's table.
    #[must_use]
    pub fn area(&self, bridge: &Bridge, radii: [f64; 2], tables: &Tables) -> f64 {
        let diameter = reduced_diameter(radii);
        let relative = bridge.volume / (diameter * diameter * diameter);
        let table = tables.get(self.table);
        table.map_or(0.0, |table| {
            let area = table.area(relative, ratio_of(radii), bridge.gap / diameter);
            area * diameter * diameter
        })
    }

    /// The capillary pull of a bridge at a gap (m), N.
    #[must_use]
    pub fn force_at(&self, bridge: &Bridge, gap: f64) -> f64 {
        energy::pull(self.fit.form(), bridge, gap)
    }

    /// The largest viscous coefficients of a film between two with R* (m): normal and tangential, kg/s.
    #[must_use]
    pub fn most_viscous(&self, effective_radius: f64) -> [f64; 2] {
        let ratio = effective_radius / self.roughness.unwrap_or(0.01 * effective_radius);
        let scale = 6.0 * PI * self.viscosity * effective_radius;
        [
            scale * ratio,
            scale * (8.0 / 15.0 * log(ratio) + 0.9588).max(0.0),
        ]
    }

    /// Energy of a bridge at its gap of the last force evaluation, J: minus the work from there to its end.
    #[must_use]
    pub fn energy_of<const N: usize>(&self, bridge: &Bridge<f64, N>) -> f64 {
        if bridge.volume <= 0.0 {
            return 0.0;
        }
        let form = self.fit.form();
        let to_end = energy::work(form, bridge, bridge.gap.max(0.0));
        let overlap = (-bridge.gap).max(0.0);
        -(to_end + bridge.curve[0] * overlap)
    }

    /// The capillary pull, N, of bridges that are there.
    #[inline(always)]
    fn pull<L: Real, const N: usize>(&self, bridge: &Bridge<L, N>, gap: L) -> L {
        let [f, a, p, q, j] = bridge.resized::<SHORT>().curve;
        let apart = L::ZERO.below(gap);
        if !apart.any() {
            return f;
        }
        let over_gap = match self.fit.form() {
            Form::Exact => table::bound_of(bridge).force(gap),
            Form::Rational => f * (a * gap + L::ONE) / ((q * gap + p) * gap + L::ONE),
            Form::Exponential => {
                let x = L::from_lanes(|k| log((j.lane(k) * gap.lane(k)).max(f64::MIN_POSITIVE)));
                let inner = (q * x + p) * x;
                let exponential = |x: L| L::from_lanes(|k| exp(x.lane(k)));
                f * exponential(-(a * exponential(inner)))
            }
        };
        L::select(apart, over_gap, f)
    }

    /// Viscous force on A (Adams & Perchard 1985 along the normal; Goldman, Cox & Brenner 1967 across it): 6π η R*² u_n/h and
    /// 6π η R* max(0, 8/15 ln(R*/h) + 0.9588) u_t, with h the larger of gap and roughness.
    #[inline(always)]
    fn drag<L: Real>(&self, contact: &Contact<L>, end: L, gap: L) -> AdhesionForce<L> {
        let radius = contact.effective_radius;
        let apart = L::ZERO.below(gap);
        if !apart.any() && !self.lubrication_in_contact {
            return AdhesionForce::NONE;
        }
        let least = match self.roughness {
            Some(roughness) => L::splat(roughness),
            None => radius * 0.01,
        };
        let film = gap.max(least);
        let (mut along, mut across) = (apart, apart);
        if self.lubrication == Lubrication::Cut {
            let limit = match self.fit {
                Fit::LianSeville => end * 0.25,
                _ => radius * 0.01,
            };
            along = along & limit.below(gap);
            across = along;
        } else if self.lubrication_in_contact {
            along = apart | !apart;
        }
        let scale = radius * (6.0 * PI * self.viscosity);
        let ratio = radius / film;
        let viscous = scale * ratio * -contact.normal_velocity;
        let log_ratio = if across.any() {
            L::from_lanes(|k| log(ratio.lane(k)))
        } else {
            L::ZERO
        };
        let shear = scale * (log_ratio * (8.0 / 15.0) + 0.9588).max(L::ZERO);
        across = across & L::ZERO.below(shear);
        AdhesionForce {
            normal: NormalForce {
                elastic: L::ZERO,
                viscous: L::select(along, viscous, L::ZERO),
            },
            tangential: contact.tangential_velocity * -L::select(across, shear, L::ZERO),
            ..AdhesionForce::NONE
        }
    }

    /// Force on A; the bridge keeps what the audit needs of this evaluation.
    #[inline(always)]
    fn act<L: Real, const N: usize>(
        &self,
        contact: &Contact<L>,
        bridge: &mut Bridge<L, N>,
    ) -> AdhesionForce<L> {
        let gap = -contact.overlap;
        if self.max_volume > 0.0 {
            bridge.gap = gap;
        }
        let open = gap.max(L::ZERO);
        let holds = L::ZERO.below(bridge.volume) & open.below(bridge.end);
        if !holds.any() {
            bridge.force = L::ZERO;
            return AdhesionForce::NONE;
        }
        let mut force = if self.viscosity > 0.0 {
            let drag = self.drag(contact, bridge.end, gap);
            AdhesionForce {
                normal: NormalForce {
                    elastic: L::ZERO,
                    viscous: L::select(holds, drag.normal.viscous, L::ZERO),
                },
                tangential: Vector::select(holds, drag.tangential, Vector::ZERO),
                ..AdhesionForce::NONE
            }
        } else {
            AdhesionForce::NONE
        };
        force.normal.elastic = L::select(holds, -self.pull(bridge, open), L::ZERO);
        bridge.force = force.normal.elastic;
        force
    }

    /// Whether a contact with this bridge has an event.
    #[inline(always)]
    fn has_event<L: Real, const N: usize>(
        &self,
        contact: &Contact<L>,
        bridge: &Bridge<L, N>,
    ) -> L::Mask {
        let touches = L::ZERO.below(contact.overlap);
        let dry = bridge.wet.equals(L::ZERO);
        if self.max_volume <= 0.0 {
            return touches & !touches;
        }
        // A dry pair is looked at when it touches or its films meet; one that touched without liquid has the end 0.
        dry | (!touches & !dry & bridge.end.at_most(-contact.overlap))
    }

    /// The work that the capillary force has done since the last evaluation, as the integrator counts it, less what the energy of the
    /// bridge has fallen: 0 but for the step in which it breaks. The energy set free when it forms or takes liquid is counted
    /// where that happens.
    fn loss_of<const N: usize>(
        &self,
        contact: &Contact,
        [before, after]: [&Bridge<f64, N>; 2],
    ) -> f64 {
        let way = before.gap + contact.overlap;
        let work = 0.5 * (before.force + after.force) * way;
        work - (self.energy_at(contact, after) - self.energy_of(before))
    }

    /// Minus the work from the gap of a contact to the end of the bridge.
    fn energy_at<L: Real, const N: usize>(&self, contact: &Contact<L>, bridge: &Bridge<L, N>) -> L {
        L::from_lanes(|k| {
            self.energy_of(&Bridge {
                gap: -contact.overlap.lane(k),
                ..bridge.lane(k)
            })
        })
    }
}

/// R_D = 2 R*, m, of spheres of these radii (m; infinite at a wall).
#[must_use]
pub fn reduced_diameter(radii: [f64; 2]) -> f64 {
    2.0 / (1.0 / radii[0] + 1.0 / radii[1])
}

/// The smaller of two radii over the larger one; 0 at a wall.
fn ratio_of(radii: [f64; 2]) -> f64 {
    (radii[0] / radii[1]).min(radii[1] / radii[0])
}

/// How the plan and the log call a law from which no bridge forms.
const NO_LIQUID: &str = "no liquid";

/// The law of liquid bridges whose contacts keep `N` numbers of a bridge's force: [`SHORT`] for the formulas, [`CURVE`] for all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiquidLaw<const N: usize>(pub Liquid);

impl<const N: usize> AdhesionLaw for LiquidLaw<N> {
    type History<L: Real> = Bridge<L, N>;
    type Events = BridgeEvents;
    const ACTIVE: bool = true;
    const SHEARS: bool = true;

    fn name(&self) -> &'static str {
        if self.0.max_volume > 0.0 {
            self.0.fit.name()
        } else {
            NO_LIQUID
        }
    }

    fn range(&self) -> f64 {
        self.0.range
    }

    #[inline(always)]
    fn forms_on_contact(&self) -> bool {
        true
    }

    fn least_films(&self) -> f64 {
        if self.0.max_volume > 0.0 {
            self.0.min_volume.max(f64::MIN_POSITIVE)
        } else {
            f64::INFINITY
        }
    }

    #[inline(always)]
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        _: f64,
        bridge: &mut Bridge<L, N>,
    ) -> AdhesionForce<L> {
        self.0.act(contact, bridge)
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, bridge: &Bridge<L, N>) -> L {
        self.0.energy_at(contact, bridge)
    }

    #[inline(always)]
    fn event<L: Real>(&self, contact: &Contact<L>, bridge: &Bridge<L, N>) -> L::Mask {
        self.0.has_event(contact, bridge)
    }

    fn loss(&self, contact: &Contact, _: &Contact, _: f64, bridges: [&Bridge<f64, N>; 2]) -> f64 {
        self.0.loss_of(contact, bridges)
    }
}
