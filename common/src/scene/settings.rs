//! `[time]`, `[domain]` and `[contact]`: duration, space and conventions.

use glam::DVec3;

use super::cursor::Fields;
use super::liquid::{self, LianSevilleVolume, Lubrication};
use super::source::{Located, Place};

/// `[time]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Time {
    /// Simulated time, s.
    pub end: Located<f64>,
    /// The time step.
    pub step: Located<TimeStep>,
    /// Whether the run ends early once the particles rest; default false.
    pub until_at_rest: Located<bool>,
    /// Reference speed of the automatic time step, m/s; none: estimated.
    pub v_ref: Option<Located<f64>>,
}

/// How long a step is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeStep {
    /// A fraction of the shortest contact.
    Auto,
    /// As given, s.
    Seconds(f64),
}

/// `[domain]`: particles that leave it through a face without wall are deleted.
#[derive(Debug, Clone, PartialEq)]
pub struct Domain {
    /// Where the table stands.
    pub place: Place,
    /// Lowest corner, m.
    pub min: Located<DVec3>,
    /// Highest corner, m.
    pub max: Located<DVec3>,
    /// Which of x, y, z are periodic; default none.
    pub periodic: [bool; 3],
    /// Default 3.
    pub dimensions: Dimensions,
}

/// The dimensions of space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Dimensions {
    /// Discs in the x-y plane, mass per unit length.
    Two,
    /// Spheres.
    Three,
}

/// An axis of space with a sign: a face of the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Face {
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Whether it is the face at the highest coordinate.
    pub is_upper: bool,
}

impl Face {
    /// All faces, in the order of all outputs.
    pub const ALL: [Face; 6] = [
        Face {
            axis: 0,
            is_upper: false,
        },
        Face {
            axis: 0,
            is_upper: true,
        },
        Face {
            axis: 1,
            is_upper: false,
        },
        Face {
            axis: 1,
            is_upper: true,
        },
        Face {
            axis: 2,
            is_upper: false,
        },
        Face {
            axis: 2,
            is_upper: true,
        },
    ];

    /// `-x`, `+x`, `-y`, `+y`, `-z`, `+z`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match (self.axis, self.is_upper) {
            (0, false) => "-x",
            (0, true) => "+x",
            (1, false) => "-y",
            (1, true) => "+y",
            (_, false) => "-z",
            (_, true) => "+z",
        }
    }
}

/// `[contact]`: conventions, each of which changes results.
#[derive(Debug, Clone, PartialEq)]
pub struct Conventions {
    /// How tangential springs follow the contact plane; default project.
    pub tangential_history: TangentialHistory,
    /// The lever arm of rolling and torsion; default R*.
    pub rolling_lever: RollingLever,
    /// Whether tensile visco-elastic forces are cut off; default false.
    pub clamp_tension: bool,
    /// How friction is kept within Coulomb's limit; default bounded.
    pub coulomb_limits: CoulombLimits,
    /// Against which normal the sliding velocity is taken; default half-step.
    pub sliding_normal: SlidingNormal,
    /// How viscous forces of liquid behave at small gaps; default clamped.
    pub lubrication: Lubrication,
    /// What stands for the volume in the fit of Lian & Seville; default V/R_D^3.
    pub lian_seville_volume: LianSevilleVolume,
    /// Whether R* includes the curvature of walls; default false.
    pub wall_curvature: bool,
    /// Overlap at the start, in smaller radii, that is an error; default 0.5.
    pub overlap_error: Located<f64>,
    /// Overlap at the start, in smaller radii, that is a warning; default 0.1.
    pub overlap_warning: Located<f64>,
    /// Whether springs advance in the evaluation before the first step; default false.
    pub startup_increment: bool,
    /// The effective mass of contacts of clumps; default body.
    pub clump_mass: ClumpMass,
}

/// What mass a clump brings into the effective mass of its contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ClumpMass {
    /// That of the whole body.
    Body,
    /// The mass that resists a push along the normal at the contact point: less than the body's where the push also turns it.
    ContactPoint,
}

/// How tangential springs follow the contact plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TangentialHistory {
    /// Projected on the plane and rescaled to the old length.
    Project,
    /// Rotated with the pair, infinitesimally.
    Incremental,
}

/// The lever arm of rolling and torsion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RollingLever {
    /// `R*`
    ReducedRadius,
    /// `2R*`
    TwiceReducedRadius,
}

/// How friction is kept within Coulomb's limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum CoulombLimits {
    /// The elastic part decides whether the contact slides, which leaves no viscous part; else the sum of both is cut. The limit
    /// is mu max(F_n, 0).
    #[default]
    Bounded,
    /// Mindlin: the elastic part is cut, damping is added when sticking, beyond the limit mu |F_n|. Linear: as `Total`.
    Elastic,
    /// The sum of elastic part and damping is cut at mu |F_n|, and the spring set back by what is left of it.
    Total,
}

/// Against which normal velocities of sliding, rolling and torsion are taken.
///
/// Velocity Verlet evaluates forces with the positions of a step's end and the velocities of its middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum SlidingNormal {
    /// The normal at the middle of the step, the time of the velocities (Vyas et al. 2025).
    #[default]
    HalfStep,
    /// The normal at the end of the step, as in LIGGGHTS and MercuryDPM: of first order in the step.
    Step,
}

pub(super) fn read_time(fields: &Fields<'_>) -> Option<Time> {
    let end = fields.need("end").and_then(|item| {
        let end = item.number()?;
        if *end <= 0.0 {
            item.report(format!(
                "the end lies before the start: must be > 0, got {}",
                item.place.text()
            ));
            return None;
        }
        Some(end)
    });
    let step = match fields.get("step") {
        None => Some(fields.default("step", TimeStep::Auto)),
        Some(item) if item.is_text() => item.keyword("auto").map(|()| Located {
            value: TimeStep::Auto,
            place: item.place,
        }),
        Some(item) => (item.positive()).map(|step| step.map(TimeStep::Seconds)),
    };
    let until_at_rest = match fields.get("until_at_rest") {
        Some(item) => item.boolean().map(|value| Located {
            value,
            place: item.place.clone(),
        }),
        None => Some(fields.default("until_at_rest", false)),
    };
    let v_ref = fields.get("v_ref").and_then(|item| item.positive());
    fields.finish();
    Some(Time {
        end: end?,
        step: step?,
        until_at_rest: until_at_rest?,
        v_ref,
    })
}

pub(super) fn read_domain(fields: &Fields<'_>) -> Option<Domain> {
    let dimensions = match fields.get("dimensions") {
        None => Some(Dimensions::Three),
        Some(item) => item.whole(0).and_then(|number| match number.value {
            2 => Some(Dimensions::Two),
            3 => Some(Dimensions::Three),
            other => {
                item.report(format!("must be 2 or 3, got {other}"));
                None
            }
        }),
    };
    let min = fields.need("min").and_then(|item| item.vector());
    let max = fields.need("max").and_then(|item| item.vector());
    let periodic = fields.get("periodic").map_or(Some([false; 3]), |item| {
        let mut axes = [false; 3];
        for item in item.list()? {
            axes[item.word("axis", &[("x", 0_usize), ("y", 1), ("z", 2)])?] = true;
        }
        Some(axes)
    });
    fields.finish();
    let (min, max) = min.zip(max)?;
    let dimensions = dimensions?;
    let periodic = periodic?;
    let mut is_right = true;
    for axis in 0..3 {
        // In two dimensions the z range has no meaning for discs, it may be empty.
        let may_be_empty = axis == 2 && dimensions == Dimensions::Two;
        if min[axis] > max[axis] || (min[axis] == max[axis] && !may_be_empty) {
            let name = ["x", "y", "z"][axis];
            let lie = if may_be_empty {
                "not lie below"
            } else {
                "lie above"
            };
            let message = format!(
                "must {lie} min: in {name} min = {} and max = {}",
                min[axis], max[axis]
            );
            fields.context.report(max.error(message));
            is_right = false;
        }
    }
    if dimensions == Dimensions::Two && periodic[2] {
        fields.context.report(
            fields
                .absent("periodic")
                .error("z cannot be periodic in two dimensions"),
        );
        is_right = false;
    }
    is_right.then(|| Domain {
        place: fields.place().clone(),
        min,
        max,
        periodic,
        dimensions,
    })
}

pub(super) fn read_conventions(fields: &Fields<'_>) -> Option<Conventions> {
    let fraction = |key, default| match fields.get(key) {
        Some(item) => item.non_negative(),
        None => Some(fields.default(key, default)),
    };
    let overlap_error = fraction("overlap_error", 0.5);
    let overlap_warning = fraction("overlap_warning", 0.1);
    let conventions = Conventions {
        tangential_history: fields
            .get("tangential_history")
            .and_then(|item| {
                item.word(
                    "tangential history",
                    &[
                        ("project", TangentialHistory::Project),
                        ("incremental", TangentialHistory::Incremental),
                    ],
                )
            })
            .unwrap_or(TangentialHistory::Project),
        rolling_lever: fields
            .get("rolling_lever")
            .and_then(|item| {
                item.word(
                    "rolling lever",
                    &[
                        ("R*", RollingLever::ReducedRadius),
                        ("2R*", RollingLever::TwiceReducedRadius),
                    ],
                )
            })
            .unwrap_or(RollingLever::ReducedRadius),
        clamp_tension: flag(fields, "clamp_tension", false),
        coulomb_limits: fields
            .get("coulomb_limits")
            .and_then(|item| {
                item.word(
                    "Coulomb limit",
                    &[
                        ("bounded", CoulombLimits::Bounded),
                        ("elastic", CoulombLimits::Elastic),
                        ("total", CoulombLimits::Total),
                    ],
                )
            })
            .unwrap_or_default(),
        sliding_normal: fields
            .get("sliding_normal")
            .and_then(|item| {
                item.word(
                    "sliding normal",
                    &[
                        ("half-step", SlidingNormal::HalfStep),
                        ("step", SlidingNormal::Step),
                    ],
                )
            })
            .unwrap_or_default(),
        lubrication: liquid::lubrication(fields),
        lian_seville_volume: liquid::lian_seville_volume(fields),
        wall_curvature: flag(fields, "wall_curvature", false),
        overlap_error: overlap_error?,
        overlap_warning: overlap_warning?,
        startup_increment: flag(fields, "startup_increment", false),
        clump_mass: fields
            .get("clump_mass")
            .and_then(|item| {
                item.word(
                    "mass of clumps",
                    &[
                        ("body", ClumpMass::Body),
                        ("contact-point", ClumpMass::ContactPoint),
                    ],
                )
            })
            .unwrap_or(ClumpMass::Body),
    };
    fields.finish();
    Some(conventions)
}

/// A switch; the default when it is absent.
pub(super) fn flag(fields: &Fields<'_>, key: &'static str, default: bool) -> bool {
    fields
        .get(key)
        .and_then(|item| item.boolean())
        .unwrap_or(default)
}
