//! `[time]`, `[domain]` and `[contact]`: duration, space and conventions.

use glam::DVec3;

use super::cursor::Fields;
use super::from_item::{FromItem, FromKey};
use super::item::Item;
use super::keys::{Absent, Kind, TableKeys, Word, key, non_negative, positive, vector, word};
use super::liquid::{LianSevilleVolume, Lubrication};
use super::results::{self, UNTIL, Until};
use super::source::{Located, SourceSpan};

/// `[time]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Time {
    /// Simulated time, s.
    pub end: Located<f64>,
    /// The time step.
    pub step: Located<TimeStep>,
    /// Whether the run ends early once the particles rest; default false.
    pub until_at_rest: Located<bool>,
    /// Results whose errors end the run; default none.
    pub until: Vec<Until>,
    /// Reference speed of the automatic time step, m/s; none: estimated.
    pub v_ref: Option<Located<f64>>,
}

/// Length of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeStep {
    /// A fraction of the shortest contact.
    Auto,
    /// Step as given, s.
    Seconds(f64),
}

/// `[domain]`: particles that leave it through a face without wall are deleted.
#[derive(Debug, Clone, PartialEq)]
pub struct Domain {
    /// Where the table stands.
    pub place: SourceSpan,
    /// Lowest corner, m.
    pub min: Located<DVec3>,
    /// Highest corner, m.
    pub max: Located<DVec3>,
    /// Periodic directions of x, y, z; default none.
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
    /// Measure of the volume in the fit of Lian & Seville; default V/R_D^3.
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

/// Mass of a clump in the effective mass of its contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ClumpMass {
    /// Mass of the whole body.
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

impl FromItem for TimeStep {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        match item.is_text() {
            true => item.keyword("auto").map(|()| Self::Auto),
            false => f64::from_item(item, kind).map(Self::Seconds),
        }
    }
}

impl FromKey for TimeStep {
    fn placeholder(_: &SourceSpan) -> Self {
        Self::Auto
    }
}

impl FromItem for Dimensions {
    fn from_item(item: &Item<'_>, _: &'static Kind) -> Option<Self> {
        match item.whole(0)?.value {
            2 => Some(Self::Two),
            3 => Some(Self::Three),
            other => {
                item.report(format!("must be 2 or 3, got {other}"));
                None
            }
        }
    }
}

impl FromKey for Dimensions {
    fn placeholder(_: &SourceSpan) -> Self {
        Self::Three
    }
}

/// An axis by its name.
#[derive(Clone, Copy)]
pub(super) struct Axis(pub(super) usize);

impl Word for Axis {
    const WHAT: &'static str = "axis";
    const WORDS: &'static [(&'static str, Self)] =
        &[("x", Self(0)), ("y", Self(1)), ("z", Self(2))];
}

impl Word for ClumpMass {
    const WHAT: &'static str = "mass of clumps";
    const WORDS: &'static [(&'static str, Self)] =
        &[("body", Self::Body), ("contact-point", Self::ContactPoint)];
}

impl Word for TangentialHistory {
    const WHAT: &'static str = "tangential history";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("project", Self::Project),
        ("incremental", Self::Incremental),
    ];
}

impl Word for RollingLever {
    const WHAT: &'static str = "rolling lever";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("R*", Self::ReducedRadius),
        ("2R*", Self::TwiceReducedRadius),
    ];
}

impl Word for CoulombLimits {
    const WHAT: &'static str = "Coulomb limit";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("bounded", Self::Bounded),
        ("elastic", Self::Elastic),
        ("total", Self::Total),
    ];
}

impl Word for SlidingNormal {
    const WHAT: &'static str = "sliding normal";
    const WORDS: &'static [(&'static str, Self)] =
        &[("half-step", Self::HalfStep), ("step", Self::Step)];
}

/// `[time]`
#[rustfmt::skip]
pub(super) static TIME: TableKeys = TableKeys::new(&[&[
    key("end", positive("s"), "1.0", "simulated time"),
    key("step", Kind::OneOf(&[positive("s"), Kind::Keyword("auto")]), "1e-5", "`\"auto\"`: 1/50 of the shortest contact of the plan").or_word("auto"),
    key("until_at_rest", Kind::Flag, "true", "also ends [at rest](#when-a-run-is-at-rest)").or_flag(false),
    key("until", Kind::OneOf(&[Kind::Table(&UNTIL), Kind::List("results", &Kind::Table(&UNTIL))]), "{ result = \"torque\", error = \"2 %\" }", "also ends when [results are known](../how-to/results-and-errors.md#end-a-run-when-a-result-is-known) to these errors; a list: all of them").or_open("`end` alone"),
    key("v_ref", positive("m/s"), "1.0", "reference speed of Hertz contacts for the automatic step").or_open("estimated"),
]]);

/// `[domain]`
#[rustfmt::skip]
pub(super) static DOMAIN: TableKeys = TableKeys::new(&[&[
    key("min", vector("m"), "[0, 0, 0]", "lowest corner"),
    key("max", vector("m"), "[0.1, 0.1, 0.2]", "highest corner; `min < max` along each axis"),
    key("periodic", Kind::List("", &word::<Axis>()), "[\"x\"]", "any of `\"x\"`, `\"y\"`, `\"z\"`").absent(Absent::EmptyList),
    key("dimensions", Kind::Whole(2, 3), "2", "2: discs in x-y, mass per unit length; the z range is then free and z cannot be periodic").or(3.0),
]]);

/// `[contact]`
#[rustfmt::skip]
pub(super) static CONTACT: TableKeys = TableKeys::new(&[&[
    key("tangential_history", word::<TangentialHistory>(), "\"incremental\"", "`\"incremental\"`: springs rotate with the pair").or_word("project"),
    key("rolling_lever", word::<RollingLever>(), "\"2R*\"", "lever arm of rolling and torsion").or_word("R*"),
    key("clamp_tension", Kind::Flag, "true", "true: no tensile visco-elastic force").or_flag(false),
    key("coulomb_limits", word::<CoulombLimits>(), "\"elastic\"", "friction never exceeds the limit; `\"elastic\"`, `\"total\"`: as in other codes ([what they do](../theory/contact-laws.md#coulombs-limit-contact-coulomb_limits))").or_word("bounded"),
    key("sliding_normal", word::<SlidingNormal>(), "\"step\"", "`\"step\"`: sliding, rolling and torsion against the normal at the end of the step, as LIGGGHTS and MercuryDPM have it ([why not](../theory/time-integration.md#the-normal-of-the-half-step))").or_word("half-step"),
    key("lubrication", word::<Lubrication>(), "\"cut\"", "`\"cut\"`: no viscous force of liquid at small gaps, as MercuryDPM has it ([why not](../theory/liquid.md#viscosity))").or_word("clamped"),
    key("lian_seville_volume", word::<LianSevilleVolume>(), "\"cubic-metres\"", "`\"cubic-metres\"`: V itself instead of V/R_D^3 in the fit of Lian & Seville, as MercuryDPM has it; for comparison alone").or_word("relative"),
    key("wall_curvature", Kind::Flag, "true", "true: R* includes the curvature of walls").or_flag(false),
    key("overlap_error", non_negative(""), "0.5", "overlap at the start that is an error, as a fraction of the smaller radius").or(0.5),
    key("overlap_warning", non_negative(""), "0.1", "overlap at the start that is a warning, as a fraction of the smaller radius").or(0.1),
    key("startup_increment", Kind::Flag, "true", "true: springs advance in the evaluation before the first step").or_flag(false),
    key("clump_mass", word::<ClumpMass>(), "\"contact-point\"", "`\"contact-point\"`: contacts of clumps are damped by the mass at the contact point ([what it means](../theory/rigid-bodies.md#restitution))").or_word("body"),
]]);

pub(super) fn read_time(fields: &Fields<'_>) -> Time {
    Time {
        end: fields.read("end"),
        step: fields.read("step"),
        until_at_rest: fields.read("until_at_rest"),
        until: (fields.get("until")).map_or_else(Vec::new, |item| results::read_until(&item)),
        v_ref: fields.read("v_ref"),
    }
}

pub(super) fn read_domain(fields: &Fields<'_>) -> Domain {
    let axes: Vec<Axis> = fields.read("periodic");
    let domain = Domain {
        place: fields.place().clone(),
        min: fields.read("min"),
        max: fields.read("max"),
        periodic: [0, 1, 2].map(|axis| axes.iter().any(|other| other.0 == axis)),
        dimensions: fields.read("dimensions"),
    };
    let (min, max) = (&domain.min, &domain.max);
    let is_flat = domain.dimensions == Dimensions::Two;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        // In two dimensions the z range has no meaning for discs, it may be empty.
        let may_be_empty = axis == 2 && is_flat;
        if min[axis] > max[axis] || (min[axis] == max[axis] && !may_be_empty) {
            let lie = if may_be_empty {
                "not lie below"
            } else {
                "lie above"
            };
            fields.context.report(max.error(format!(
                "must {lie} min: in {name} min = {} and max = {}",
                min[axis], max[axis]
            )));
        }
    }
    if is_flat && domain.periodic[2] {
        let periodic = fields.absent("periodic");
        let error = periodic.error("z cannot be periodic in two dimensions");
        fields.context.report(error);
    }
    domain
}

pub(super) fn read_conventions(fields: &Fields<'_>) -> Conventions {
    Conventions {
        tangential_history: fields.read("tangential_history"),
        rolling_lever: fields.read("rolling_lever"),
        clamp_tension: fields.read("clamp_tension"),
        coulomb_limits: fields.read("coulomb_limits"),
        sliding_normal: fields.read("sliding_normal"),
        lubrication: fields.read("lubrication"),
        lian_seville_volume: fields.read("lian_seville_volume"),
        wall_curvature: fields.read("wall_curvature"),
        overlap_error: fields.read("overlap_error"),
        overlap_warning: fields.read("overlap_warning"),
        startup_increment: fields.read("startup_increment"),
        clump_mass: fields.read("clump_mass"),
    }
}
