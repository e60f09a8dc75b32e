//! Files of a run: the flags of `[output]` that switch them, and the columns of text tables with units and meanings.
//!
//! Each table is declared here once. The solver writes by it, results find columns and units in it, `mercury-export` its tables, and the pages in
//! `docs/formats` have the text of [`TableSpec::markdown`].

use crate::scene::keys::{Kind, SceneKey, key};

/// Declares flags of `[output]`: default, an example, and the text of the page of the format.
macro_rules! flags {
    ($($name:ident: $default:literal, $example:literal, $text:literal;)*) => {
        /// Files that a run writes: the flags of `[output]`, which plans take over as they are. By [`Default`] nothing is written; the
        /// defaults of a scene stand in its table of keys.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        pub struct Switches {
            $(#[doc = $text] pub $name: bool,)*
        }

        impl Switches {
            pub(crate) const KEYS: &'static [SceneKey] =
                &[$(key(stringify!($name), Kind::Flag, $example, $text).or_flag($default),)*];

            /// Switches with the value of each flag by its name.
            pub(crate) fn read(flag: impl Fn(&'static str) -> bool) -> Self {
                Self { $($name: flag(stringify!($name)),)* }
            }
        }
    };
}

flags! {
    data: true, "false", "`.data`";
    ene: true, "false", "`.ene`";
    fstat: false, "true", "`.fstat`, `.contacts.arrow`";
    vtk: false, "true", "`vtk/`: [series for ParaView](vtu.md)";
    frames: true, "false", "`.particles.arrow` and `.walls.arrow`";
    walls: true, "false", "[`.walls.csv`](tables.md#loads-on-walls)";
    triangle_loads: false, "true", "pressure, shear and power of sliding on each triangle of mesh walls: [`.triangle_loads.arrow`](walls.md#triangle_loadsarrow), arrays in `vtk/`";
    liquid: true, "false", "[`.liquid.csv`](liquid.md), where there is liquid";
    droplets: true, "false", "[`.droplets.arrow`](frames.md#droplets), where there are sprays";
    bonds: true, "false", "[`.bonds.arrow`](bonds.md) and [`.breaks.csv`](bonds.md#broken-bonds), where there are bonds";
    left: false, "true", "[`.left.csv`](tables.md#grains-that-pass): a row for each grain that leaves, or crosses a plane of `[[fluxes]]`";
    pictures: true, "false", "pictures of the end";
}

/// Relation of a column to the time of its row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Name or id: it says what a row is of.
    Label,
    /// Quantity at the time of the row, sums since the start among them.
    Value,
    /// Amount that came since the row before.
    Amount,
    /// Mean over what came since the row before.
    Mean,
}

/// A column of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// SI unit; `1` or empty where it has none.
    pub unit: &'static str,
    /// Relation to the time of the row.
    pub role: Role,
    /// Meaning, as Markdown; neighbours with the same unit and meaning are described together.
    pub meaning: &'static str,
}

/// A table that a run writes: `<prefix>.<file>`.
#[derive(Debug, PartialEq, Eq)]
pub struct TableSpec {
    /// Ending of its file behind the prefix.
    pub file: &'static str,
    /// Kind of thing that a row describes, for messages.
    pub row_of: &'static str,
    /// Part of a scene that makes a run write it.
    pub from: &'static str,
    /// Its columns; the first is the time.
    pub columns: &'static [Column],
}

impl TableSpec {
    /// Name of the table: the ending of its file without `.csv`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.file.strip_suffix(".csv").unwrap_or(self.file)
    }

    /// The column of this name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&'static Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Columns of numbers behind the time.
    pub fn values(&self) -> impl Iterator<Item = &'static Column> {
        let behind = self.columns.iter().skip(1);
        behind.filter(|column| column.role != Role::Label)
    }

    /// Columns and meanings as a table in Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = "| column | unit | meaning |\n|---|---|---|\n".to_owned();
        let alike = |a: &Column, b: &Column| (a.unit, a.meaning) == (b.unit, b.meaning);
        for group in self.columns.chunk_by(alike) {
            let names = group.iter().map(|column| format!("`{}`", column.name));
            let names: Vec<String> = names.collect();
            let unit = match group[0].unit {
                "1" => "",
                unit => unit,
            };
            let cells =
                [names.join(", ").as_str(), unit, group[0].meaning].map(|cell| match cell {
                    "" => " ".to_owned(),
                    cell => format!(" {cell} "),
                });
            text += &format!("|{}|\n", cells.join("|"));
        }
        text
    }
}

/// Declares columns: role, names, unit, meaning.
macro_rules! columns {
    ($($role:ident $($name:literal)+ [$unit:literal]: $meaning:literal;)*) => {
        &[$($(Column { role: Role::$role, name: $name, unit: $unit, meaning: $meaning },)+)*]
    };
}

/// Loads on walls, and their motion.
pub static WALLS: TableSpec = TableSpec {
    file: "walls.csv",
    row_of: "wall",
    from: "a scene with walls and without walls = false in [output]",
    columns: columns! {
        Value "time" ["s"]: "";
        Label "name" [""]: "of the wall; `box.-z` and so on";
        Value "fx" "fy" "fz" ["N"]: "force of the particles on the wall, and of sheets whose vertices it holds";
        Value "tx" "ty" "tz" ["N m"]: "their torque on the wall about its reference point";
        Value "power" ["W"]: "power of the wall on the particles: positive where it drives them. That of a drum which turns at w about its axis is −w · t, of a lid that goes at v −v · f";
        Value "x" "y" "z" ["m"]: "the reference point, where it is now; along periodic axes [less whole periods](../theory/neighbour-lists.md#periodic-axes-images-as-integer-shifts)";
        Value "qw" "qx" "qy" "qz" ["1"]: "how the wall has turned since the start, a unit quaternion";
        Value "vx" "vy" "vz" ["m/s"]: "velocity of the reference point";
        Value "wx" "wy" "wz" ["rad/s"]: "angular velocity";
    },
};

/// Content of regions.
pub static REGIONS: TableSpec = TableSpec {
    file: "regions.csv",
    row_of: "region",
    from: "[[regions]] in the scene",
    columns: columns! {
        Value "time" ["s"]: "";
        Label "name" [""]: "of the region";
        Label "material" [""]: "of the spheres, or of the surface of the bodies";
        Value "number" ["1"]: "spheres and bodies";
        Value "mass" ["kg"]: "";
        Value "vx" "vy" "vz" ["m/s"]: "momentum over mass; 0 where nothing is";
        Value "kinetic" ["J"]: "of translation, as in `summary.json`, in the frame of the scene (not about the mean velocity)";
        Value "solid_fraction" ["1"]: "volume of what is counted over the volume of the region's part within the domain";
    },
};

/// Particles that crossed planes.
pub static FLUX: TableSpec = TableSpec {
    file: "flux.csv",
    row_of: "plane of [[fluxes]]",
    from: "[[fluxes]] in the scene",
    columns: columns! {
        Value "time" ["s"]: "end of the interval; the first row, at t = 0, is empty";
        Label "name" [""]: "of the plane";
        Label "material" [""]: "of the spheres, or of the surface of the bodies";
        Amount "forward" "backward" ["1"]: "spheres and bodies that crossed along the normal and against it";
        Amount "mass" ["kg"]: "along the normal less against it";
        Amount "volume" ["m3"]: "likewise, of the solid";
        Amount "px" "py" "pz" ["kg m/s"]: "momentum that was carried across, likewise: what goes backwards with a velocity against the normal counts twice negative, thus positive along it";
        Mean "d10" "d32" "d43" ["m"]: "mean diameters D[1,0], D[3,2], D[4,3] of those that crossed along the normal; 0 if none did. A body has the diameter of a sphere of its volume";
    },
};

/// Motion of named particles and bodies.
pub static TRACK: TableSpec = TableSpec {
    file: "track.csv",
    row_of: "particle, clump or insertion in output.track",
    from: "track = [\"NAME\"] in [output] of the scene",
    columns: columns! {
        Value "time" ["s"]: "";
        Label "name" [""]: "of the particle, clump or insertion";
        Label "id" [""]: "of the sphere, or of the first pebble of the body";
        Value "x" "y" "z" ["m"]: "centre; along periodic axes as in a domain that goes on for ever";
        Value "vx" "vy" "vz" ["m/s"]: "velocity";
        Value "qw" "qx" "qy" "qz" ["1"]: "orientation, a unit quaternion";
        Value "wx" "wy" "wz" ["rad/s"]: "angular velocity";
        Value "fx" "fy" "fz" ["N"]: "force of all contacts";
        Value "tx" "ty" "tz" ["N m"]: "torque of all contacts about the centre";
    },
};

/// Grains that leave or cross a plane.
pub static LEFT: TableSpec = TableSpec {
    file: "left.csv",
    row_of: "grain",
    from: "left = true in [output] of the scene",
    columns: columns! {
        Value "time" ["s"]: "end of the drift";
        Label "at" [""]: "`plane` (of `[[fluxes]]`: the grain goes on), `region` (of `[[deletions]]`), `face` (of the domain)";
        Label "name" [""]: "of the plane or region; `-x` ... `+z` of the face";
        Value "direction" ["1"]: "of planes 1 along the normal and -1 against it, else 1";
        Label "id" [""]: "of the sphere, or of the body";
        Label "clump" [""]: "kind of clump of a body; empty: a sphere";
        Label "material" [""]: "";
        Value "diameter" ["m"]: "of a body that of a sphere of its volume";
        Value "x" "y" "z" ["m"]: "centre at `time`, inside a periodic domain";
        Value "vx" "vy" "vz" ["m/s"]: "its velocity, that of the leapfrog's half step";
    },
};

/// Volumes of liquid.
pub static LIQUID: TableSpec = TableSpec {
    file: "liquid.csv",
    row_of: "output time",
    from: "a scene with liquid and without liquid = false in [output]",
    columns: columns! {
        Value "time" ["s"]: "";
        Value "films" ["m3"]: "on particles";
        Value "bridges" ["m3"]: "in bridges between particles, and between particles and walls";
        Value "wall_films" ["m3"]: "on walls with a `film`; droplets that such walls keep count here";
        Value "in_flight" "emitted" ["m3"]: "in droplets in flight, and in all that [sprays](../theory/sprays.md) released";
        Value "absorbed" "lost" ["m3"]: "in droplets that particles caught, and that were lost at walls";
        Value "left" ["m3"]: "on particles and in droplets that left through a face of the domain";
        Value "evaporated" ["m3"]: "from films, bridges and walls";
        Value "inserted" "deleted" ["m3"]: "on particles that were inserted, and that were deleted in a region";
        Value "error" ["m3"]: "`films` + `bridges` + `wall_films` + `in_flight` + `lost` + `left` + `evaporated` + `deleted` - `inserted` - `emitted` - the volume at the start: round-off, below 2e-14 of the total";
        Value "bridge_count" ["1"]: "bridges at this time";
        Value "formed" "ruptured" ["1"]: "bridges that formed and broke since the start";
    },
};

/// Bonds that broke.
pub static BREAKS: TableSpec = TableSpec {
    file: "breaks.csv",
    row_of: "broken bond",
    from: "[[bonds]] in the scene, without bonds = false in [output],",
    columns: columns! {
        Value "time" ["s"]: "end of the step in which it broke";
        Label "i" "j" [""]: "ids of the particles; `j` is empty at a wall";
        Label "bond" [""]: "name of the entry of `[[bonds]]`";
        Label "mode" [""]: "`tension`, `shear`, or `deletion` (one of its ends left the simulation)";
        Value "x" "y" "z" ["m"]: "middle of the bond";
        Value "energy" ["J"]: "elastic energy that the bond set free";
        Label "wall" [""]: "name of the wall; empty between particles";
    },
};

/// Wear of walls.
pub static WEAR: TableSpec = TableSpec {
    file: "wear.csv",
    row_of: "wall that wears",
    from: "`wear` at a wall of the scene",
    columns: columns! {
        Value "time" ["s"]: "";
        Label "name" [""]: "of the wall";
        Value "owed" ["m3"]: "by the law, of all contacts since the start: `front` + `back`";
        Value "removed" ["m3"]: "signed volume between the first surface and the present one, positive on the side that owes more";
        Value "pending" ["m3"]: "what waits: \\|`front` - `back`\\| - `removed`; of a wall that is worn on one side `owed` - `removed`";
        Value "front" "back" ["m3"]: "owed by contacts on the side of the normals, and on the other";
        Value "max_depth" ["m"]: "depth of the deepest vertex";
        Value "x" "y" "z" ["m"]: "first place of the deepest vertex";
        Value "moves" ["1"]: "moves of the surface";
        Value "blocked" ["1"]: "vertices at which the last move that wanted to move them was shortened";
    },
};

/// Elastic sheets.
pub static MEMBRANES: TableSpec = TableSpec {
    file: "membranes.csv",
    row_of: "sheet",
    from: "[[membranes]] in the scene",
    columns: columns! {
        Value "time" ["s"]: "";
        Label "name" [""]: "of the sheet";
        Value "area" ["m2"]: "present area";
        Value "volume" ["m3"]: "enclosed volume, open rims closed by fans about the mean of their vertices";
        Value "pressure" ["Pa"]: "";
        Value "x" "y" "z" ["m"]: "centre of mass";
        Value "vx" "vy" "vz" ["m/s"]: "velocity of the centre of mass";
        Value "fx" "fy" "fz" ["N"]: "force of grains and walls on the sheet";
        Value "tx" "ty" "tz" ["N m"]: "torque of grains and walls on the sheet, about the origin";
        Value "nxx" "nyy" "nzz" "nxy" "nxz" "nyz" ["N/m"]: "mean tension: sum of area times tension over the area; Cauchy stress times thickness, tension positive";
        Value "kinetic" "gravitational" "stretching" "bending" ["J"]: "energies";
        Value "dissipated" "pressure_work" "hold_work" ["J"]: "since the start";
        Value "min_stretch" "max_stretch" ["1"]: "least and largest length of an edge over its rest length";
    },
};

/// Loads of sheets on what holds them.
pub static HOLDS: TableSpec = TableSpec {
    file: "holds.csv",
    row_of: "hold",
    from: "a hold of one of the [[membranes]] in the scene",
    columns: columns! {
        Value "time" ["s"]: "";
        Label "membrane" [""]: "of the sheet";
        Label "name" [""]: "of the hold";
        Value "fx" "fy" "fz" ["N"]: "force of the sheet on what holds it: all that acts on the held vertices but the hold";
        Value "tx" "ty" "tz" ["N m"]: "its torque about the origin";
        Value "power" ["W"]: "of the hold on the sheet";
    },
};

/// Column of the budget that stands for one of each force that takes energy: `NAME` is that of the force.
pub const DISSIPATED: &str = "dissipated_NAME";

/// Columns of the budget that runs with sheets have alone.
pub const BUDGET_OF_SHEETS: [&str; 7] = [
    "membrane_kinetic",
    "membrane_gravitational",
    "membrane_stretching",
    "membrane_bending",
    "membrane_dissipated",
    "pressure_work",
    "hold_work",
];

/// The energy budget.
pub static BUDGET: TableSpec = TableSpec {
    file: "budget.csv",
    row_of: "output time",
    from: "energy_budget = true in [output] of the scene",
    columns: columns! {
        Value "time" ["s"]: "";
        Value "kinetic" "rotational" ["J"]: "kinetic energy of translation and of rotation, now";
        Value "gravitational" ["J"]: "-g · Σ m x, now; 0 at the origin, so only differences mean something";
        Value "elastic" ["J"]: "stored in contacts, now";
        Value "dissipated_NAME" ["J"]: "dissipated since the start by each force that takes energy: `normal` (viscous and plastic normal forces), `tangential` (sliding friction and tangential dashpots), `rolling` (rolling and torsion resistance), `liquid` (viscous bridges, and bridges as they form, grow and break; negative where they set energy free), and other forces by their names";
        Value "wall_work" ["J"]: "work of all walls on the particles";
        Value "servo_work" ["J"]: "the part of `wall_work` that walls with a servo did";
        Value "inserted" ["J"]: "kinetic and gravitational energy of particles that were inserted after the first row, and what droplets of sprays (with `momentum` or `mass`) and liquid with mass brought to particles";
        Value "deleted" ["J"]: "energy of particles that were deleted or left the domain, with what their contacts stored";
        Value "deleted_elastic" ["J"]: "the part of `deleted` that their contacts stored";
        Value "vanished_walls" ["J"]: "stored in contacts with walls that vanished (`until`)";
        Value "membrane_kinetic" "membrane_gravitational" "membrane_stretching" "membrane_bending" ["J"]: "energies of elastic sheets, now; in runs with sheets alone";
        Value "membrane_dissipated" "pressure_work" "hold_work" ["J"]: "of elastic sheets since the start: dissipation, work of their pressure and of their holds; in runs with sheets alone";
        Value "error" ["J"]: "what is missing (positive) or too much";
        Value "closure" ["1"]: "`error` over the largest term in this row or any row before";
    },
};

/// Energies in the format of MercuryDPM: blanks between the columns, and no units in the head.
pub static ENERGIES: TableSpec = TableSpec {
    file: "ene",
    row_of: "output time",
    from: "a scene without ene = false in [output]",
    columns: columns! {
        Value "time" ["s"]: "";
        Value "gravitEnergy" ["J"]: "-g · Σ m x";
        Value "traKineticEnergy" ["J"]: "Σ m v²/2";
        Value "rotKineticEnergy" ["J"]: "Σ ω·I ω/2";
        Value "elasticEnergy" ["J"]: "energy stored in contacts: normal and friction springs, adhesion, bonds";
        Value "centerOfMassX" "centerOfMassY" "centerOfMassZ" ["m"]: "centre of mass; `nan` if nothing can move";
    },
};

/// Looks at the results that end a run.
pub static RESULTS: TableSpec = TableSpec {
    file: "results.csv",
    row_of: "result of `time.until`, each time when it was looked at (not each output time)",
    from: "`time.until` in the scene",
    columns: columns! {
        Value "time" ["s"]: "";
        Label "name" [""]: "of the result";
        Label "unit" [""]: "of the next five columns; `1` of a plain number";
        Value "value" [""]: "of the rows up to that time";
        Value "error" [""]: "one standard error";
        Value "low" "high" [""]: "ends of the 95 % interval";
        Value "wanted" [""]: "the error at which the result is known";
        Value "batches" ["1"]: "independent batches";
        Value "from" "to" ["s"]: "times of the first and the last row that count";
        Value "steady" ["1"]: "1: the rows are steady behind the start-up that was cut, else 0";
        Value "more" ["s"]: "how much longer the run goes on, by an error that falls as one over the root of the time; 0: the result is known at this look";
    },
};

/// All tables with commas between their columns.
pub static ALL: [&TableSpec; 12] = [
    &WALLS, &REGIONS, &FLUX, &LEFT, &TRACK, &BUDGET, &LIQUID, &BREAKS, &WEAR, &MEMBRANES, &HOLDS,
    &RESULTS,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_begins_with_the_time_and_names_a_column_once() {
        for table in ALL.into_iter().chain([&ENERGIES]) {
            let names: Vec<&str> = table.columns.iter().map(|column| column.name).collect();
            assert_eq!(names[0], "time", "{}", table.file);
            for (place, name) in names.iter().enumerate() {
                assert!(!names[..place].contains(name), "{}: {name}", table.file);
            }
        }
        assert!(
            BUDGET_OF_SHEETS
                .iter()
                .all(|name| BUDGET.column(name).is_some())
        );
        assert!(BUDGET.column(DISSIPATED).is_some());
    }

    #[test]
    fn columns_with_one_meaning_are_described_together() {
        let text = HOLDS.markdown();
        assert!(text.contains("\n| `time` | s | |\n"), "{text}");
        assert!(
            text.contains("| `fx`, `fy`, `fz` | N | force of the sheet"),
            "{text}"
        );
    }
}
