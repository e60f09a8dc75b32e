//! Subjects of the page, in its order, and the sections of each with the names of their checks.

/// A subject of the page.
pub(super) struct Subject {
    pub(super) title: &'static str,
    /// Introduction for the reader.
    pub(super) about: &'static str,
    pub(super) sections: &'static [Section],
}

/// A case of a subject.
pub(super) struct Section {
    /// The common beginning of the names of its checks; the page leaves it out.
    pub(super) prefix: &'static str,
    pub(super) title: &'static str,
    /// Set-up and remarks.
    pub(super) about: &'static str,
    /// Pictures and what they show.
    pub(super) pictures: &'static str,
}

const fn section(prefix: &'static str, title: &'static str) -> Section {
    Section {
        prefix,
        title,
        about: "",
        pictures: "",
    }
}

const HERTZ_PHASE: &str = "![Restitution of a Hertz impact over the phase of the first touch](pictures/hertz-phase.svg)

The overlap at the first step in contact depends on where in a step the touch falls; the damping of the Hertz law grows with the fourth root of it. The jumps are where the contact ends a step earlier. The error falls with the step.";

const CONVERGENCE: &str = "![Convergence of the time step](pictures/convergence.svg)

The error of the free oscillation of a sphere on a spring is of second order in the step. A collision with damping begins and ends within a step, which leaves an error of first order at most.";

const THREE_BEADS: &str = "A grain in the groove of two fixed beads, 1 degree off the top, where friction exceeds the slope of the groove (Vyas et al. 2025). With the sliding velocity taken against the normal at the end of the step (`sliding_normal = \"step\"`, and other codes) it is pulled into the groove and never falls ([why](theory/time-integration.md#the-normal-of-the-half-step)).";

const WEAR: &str = "The scene [wear-plate](../scenes/wear/wear-plate.toml): a ball of 5 mm is drawn over a plate and presses with its weight. In the other set-ups the plate moves, is turned or lies elsewhere, or the ball swings in one place until it has ground a groove ([theory](theory/wear.md)).";

const WET: &str = "Forces of the laws, exact bridges between unequal spheres and at planes, restitution of wet grains, and the volumes after bridges have formed and broken ([theory](theory/liquid.md)). The Stokes number is v m*/(6 pi eta R*^2); without tension theory has the restitution of rigid grains with films, which is 0 below a critical number.";

const MFIX_FALLS: &str = "Linear spring and dashpot; set-ups of MFiX 21.3.2 (DEM01 to DEM05), gravity 9.80665 m/s². What is compared is the theory that MFiX prints beside its own results, at the times that it prints; its Euler steps are off by up to 2 mm in DEM01. *Not run*: DEM06, a sphere in a gas that flows upwards, needs the drag of a gas.";

const CHUNG_OOI: &str = "Set-ups, time steps, digitised curves and limits as in Kratos, whose measure is the sum of all differences over the sum of all values. Walls are rigid, which leaves the ratio of the stiffnesses and so the rebound as it is. Tests 4 as a whole and 5, 6 and 8 where they slide; \
what a sphere does that sticks depends on the law: in test 4 their codes agree with the factor 1 on Mindlin's stiffness (our default is 2/3), in test 5 with neither. Tests 6 and 8 cut off tension, as Kratos does, with the damping that then gives e = 0.5.";

/// All subjects but the comparisons with files of other programs, which have a table of their own.
pub(super) const SUBJECTS: &[Subject] = &[
    Subject {
        title: "Head-on collisions",
        about: "",
        sections: &[
            section(
                "T1 ",
                "Linear law: parameters and collisions of two spheres",
            ),
            section("T2 ", "Linear law with tension cut off"),
            section("T3 ", "Elasto-plastic law"),
            section("T4 ", "Elastic Hertz contacts"),
            section("T5 ", "Damped Hertz contacts"),
            section(
                "T6 ",
                "Damping for a given restitution with tension cut off",
            ),
            section("T21 ", "Chung & Ooi (2011), tests 1 to 3"),
            Section {
                about: MFIX_FALLS,
                pictures: "![Heights of spheres that fall and bounce, and oblique impacts, by MFiX and by Mercury](pictures/mfix.svg)",
                ..section("MFiX DEM01", "MFiX DEM01: fall and rebound")
            },
            section("MFiX DEM02", "MFiX DEM02: bounces"),
            section("MFiX DEM03", "MFiX DEM03: two spheres, squeezed"),
            section("scene two-spheres: ", "The scene two-spheres"),
            Section {
                pictures: HERTZ_PHASE,
                ..section("scene hertz-wall: ", "The scene hertz-wall")
            },
        ],
    },
    Subject {
        title: "Oblique impacts",
        about: "",
        sections: &[
            section("T8 ", "Two spheres with linear friction, point by point"),
            section("T9 ", "Hertz-Mindlin sphere on a wall, point by point"),
            section("T11 ", "Gross sliding"),
            section("T12 ", "Linear friction"),
            Section {
                pictures: "![Tangential rebound over impact angle](pictures/oblique-impact.svg)",
                ..section("T13 ", "Mindlin friction")
            },
            section(
                "T20 ",
                "Chung & Ooi (2011), tests 4 to 8: rigid-body lines and measurements",
            ),
            Section {
                about: CHUNG_OOI,
                pictures: "![Tests 4, 5, 6 and 8 of Chung & Ooi: their curves, measurements, and Mercury with two factors on Mindlin's stiffness](pictures/chung-ooi.svg)",
                ..section("Chung & Ooi ", "Chung & Ooi (2011), tests 4 to 8: curves")
            },
            Section {
                about: "Alumina spheres of 2.5 mm at 3.9 m/s on each other and on a wall (Kharaz et al. 2001), friction 0.092, e = 1, which is what the file's impacts that slide were made with. Only those are compared: what the others do depends on a tangential stiffness that the file does not state ([picture](#mfix-dem01-fall-and-rebound)).",
                ..section("MFiX DEM05", "MFiX DEM05: oblique impacts")
            },
        ],
    },
    Subject {
        title: "Friction along a given path",
        about: "",
        sections: &[
            section("T16 ", "Shear cycles at constant overlap"),
            section("T17 ", "Energy of a shear and release cycle"),
        ],
    },
    Subject {
        title: "Sliding, rolling and torsion",
        about: "",
        sections: &[
            section(
                "T10 ",
                "Unequal spheres with rolling and torsion, point by point",
            ),
            section("T14 ", "A sphere slides and rolls on a plane"),
            section("T15 ", "Rolling and torsion resistance"),
            section("T22 ", "Slip to roll, and rolling that slows down"),
            section("MFiX DEM04", "MFiX DEM04: slip to roll"),
        ],
    },
    Subject {
        title: "Integration in time",
        about: "",
        sections: &[
            Section {
                pictures: CONVERGENCE,
                ..section("T7 ", "The time step")
            },
            Section {
                about: THREE_BEADS,
                ..section("Three beads ", "A grain rolls off two beads")
            },
        ],
    },
    Subject {
        title: "Two materials",
        about: "",
        sections: &[section("T18 ", "Mixing of parameters")],
    },
    Subject {
        title: "Walls",
        about: "",
        sections: &[
            section("T19 ", "Mesh walls beside the walls that they tessellate"),
            section("scene press: ", "A lid that presses"),
        ],
    },
    Subject {
        title: "Wear",
        about: "",
        sections: &[Section {
            about: WEAR,
            ..section("T23 ", "A ball wears a plate")
        }],
    },
    Subject {
        title: "Elastic sheets",
        about: "",
        sections: &[Section {
            about: "The mechanics of a sheet alone, and sheets of rubber of 0.3 mm with E = 1.25 MPa in the whole engine ([theory](theory/membranes.md)).",
            ..section("T24 ", "Sheets under loads")
        }],
    },
    Subject {
        title: "Liquid bridges",
        about: "",
        sections: &[Section {
            about: WET,
            pictures: "![Restitution of wet collisions over the Stokes number](pictures/wet-restitution.svg)",
            ..section("T25 ", "Forces, wet collisions and how liquid moves")
        }],
    },
    Subject {
        title: "Dry cohesion",
        about: "",
        sections: &[
            Section {
                about: "The curve of Johnson, Kendall & Roberts, and a sphere of 0.1 mm that meets a wall: below v_s = 22.2 mm/s it sticks ([theory](theory/contact-laws.md#dry-cohesion)).",
                ..section("T28 ", "`jkr`: curve, restitution, loss")
            },
            section("T29 ", "Other laws"),
        ],
    },
    Subject {
        title: "Bonds",
        about: "",
        sections: &[Section {
            about: "One element by the numbers of the theory, and the scenes [bonded-cantilever](../scenes/bonded-cantilever.toml) and [agglomerate](../scenes/agglomerate.toml) ([theory](theory/bonds.md)).",
            ..section("T31 ", "Glued grains")
        }],
    },
    Subject {
        title: "Rigid clumps",
        about: "",
        sections: &[
            section("scene clumps/t-bar: ", "Free rotation"),
            section("scene clumps/wheels: ", "Rolling down a slope"),
            section("scene clumps/egg: ", "The pose at rest"),
            section("scene clumps/rattleback: ", "A rattleback"),
            section("scene clumps/rod-gas: ", "A gas of rods"),
            section("scene clumps/t-bar-gas: ", "A gas of T-bars"),
            section("scene clumps/dominoes: ", "Dominoes"),
            section("scene clumps/drum: ", "A drum of clumps"),
            Section {
                about: "Bodies that `mclump` makes of shapes shipped with MercuryDPM, on a table; lengths as in their files, density 1, gravity 10. [What they show](how-to/grains-of-real-shape.md#how-many-pebbles).",
                ..section("goemboec", "Reference shapes")
            },
            section("rattleback from the surface", "Rattlebacks from a surface"),
        ],
    },
];
