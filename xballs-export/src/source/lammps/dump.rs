//! Dumps: frame after frame of `ITEM:` lines, as `dump custom` writes them; columns by their names.

use std::io::BufRead;

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::formats::lines::LineReader;
use mercury_common::formats::number::parse_number;

use super::{Grains, MOST_IDS, MOST_TYPES};

/// The frames of a dump; ends behind the first that is wrong.
pub(super) struct Frames<R> {
    lines: LineReader<R>,
    is_over: bool,
}

impl<R: BufRead> Frames<R> {
    pub(super) fn new(lines: LineReader<R>) -> Self {
        Self {
            lines,
            is_over: false,
        }
    }

    fn wrong(&self, found: impl Into<String>, expected: &str) -> FormatError {
        FormatError::at(
            self.lines.path(),
            self.lines.line_number(),
            None,
            found,
            expected,
        )
    }

    /// The next line of a frame that has begun.
    fn need(&mut self, what: &str) -> Result<(), FormatError> {
        if self.lines.advance()? {
            return Ok(());
        }
        let error = self.wrong("the end of the file within a frame", what);
        Err(error.with_help("the run that wrote it was stopped while writing, or still runs; the frames before can be used"))
    }

    fn frame(&mut self) -> Result<Option<Grains>, FormatError> {
        let mut grains = Grains::default();
        let mut count = None;
        let mut bounds = None;
        let mut has_begun = false;
        loop {
            if has_begun {
                self.need("more items")?;
            } else if !self.lines.advance()? {
                return Ok(None);
            }
            has_begun = true;
            let line = self.lines.line().trim().to_owned();
            let Some(item) = line.strip_prefix("ITEM:").map(str::trim) else {
                return Err(self.wrong(format!("{line:?}"), "a line that begins with ITEM:"));
            };
            if let Some(columns) = item.strip_prefix("ATOMS") {
                let Some(count) = count else {
                    return Err(self.wrong(
                        "ITEM: ATOMS before ITEM: NUMBER OF ATOMS",
                        "their number first",
                    ));
                };
                let columns: Vec<String> = columns.split_whitespace().map(str::to_owned).collect();
                self.atoms(count, bounds, &columns, &mut grains)?;
                return Ok(Some(grains));
            }
            if let Some(flags) = item.strip_prefix("BOX BOUNDS") {
                let flags: Vec<&str> = flags.split_whitespace().collect();
                for (periodic, flag) in grains.periodic.iter_mut().zip(&flags) {
                    *periodic = *flag == "pp";
                }
                bounds = Some(self.bounds()?);
                grains.domain = bounds;
                continue;
            }
            self.need("the value of the item above")?;
            let mut tokens = self.lines.tokens();
            match item {
                "TIMESTEP" => {
                    let step = tokens.integer("the step")?;
                    grains.step = u64::try_from(step)
                        .map_err(|_| self.wrong(format!("the step {step}"), "a step from 0 on"))?;
                }
                "NUMBER OF ATOMS" => {
                    let number = tokens.integer("the number of atoms")?;
                    let number = usize::try_from(number)
                        .ok()
                        .filter(|n| (*n as i64) < MOST_IDS);
                    count = Some(number.ok_or_else(|| {
                        self.wrong("a number of atoms out of range", "a number from 0 to 4e9")
                    })?);
                }
                "TIME" => {
                    let time = tokens.number("the time")?;
                    if !time.is_finite() {
                        return Err(self.wrong(format!("the time {time}"), "a time in s"));
                    }
                    grains.time = Some(time);
                }
                // Their value is one line: UNITS, LABEL.
                _ => {}
            }
        }
    }

    fn bounds(&mut self) -> Result<(DVec3, DVec3), FormatError> {
        let (mut low_corner, mut high_corner) = (DVec3::ZERO, DVec3::ZERO);
        for axis in 0..3 {
            self.need("three lines of bounds")?;
            let mut tokens = self.lines.tokens();
            let low = tokens.number("the lower bound")?;
            let high = tokens.number("the upper bound")?;
            if !(low < high && low.is_finite() && high.is_finite()) {
                return Err(self.wrong(
                    format!("the bounds {low} and {high}"),
                    "two numbers, the lower one first",
                ));
            }
            if tokens
                .next()
                .is_some_and(|tilt| parse_number(tilt.text) != Some(0.0))
            {
                return Err(self.wrong("a box that is not upright", "two bounds for each axis"));
            }
            (low_corner[axis], high_corner[axis]) = (low, high);
        }
        Ok((low_corner, high_corner))
    }

    fn atoms(
        &mut self,
        count: usize,
        bounds: Option<(DVec3, DVec3)>,
        columns: &[String],
        grains: &mut Grains,
    ) -> Result<(), FormatError> {
        let place = Places::of(columns).map_err(|(found, help)| {
            self.wrong(found, "columns by their names, as dump custom writes them")
                .with_help(help)
        })?;
        let mut others: Vec<Option<Vec<f64>>> =
            place.others.iter().map(|_| Some(Vec::new())).collect();
        let (mut velocity, mut spin, mut force, mut mass) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut cells: Vec<(f64, bool)> = Vec::with_capacity(columns.len());
        for row in 0..count {
            self.need(&format!("{count} lines of atoms"))?;
            if self.lines.line().starts_with("ITEM:") {
                return Err(self.wrong(
                    format!("only {row} atoms"),
                    &format!("{count} lines of atoms"),
                ));
            }
            cells.clear();
            cells.extend(
                self.lines
                    .tokens()
                    .map(|token| match parse_number(token.text) {
                        Some(number) => (number, true),
                        None => (f64::NAN, false),
                    }),
            );
            if cells.len() != columns.len() {
                let found = format!("{} columns", cells.len());
                return Err(self.wrong(found, &format!("{} as in ITEM: ATOMS", columns.len())));
            }
            let number = |at: usize| match cells[at] {
                (number, true) if number.is_finite() => Ok(number),
                _ => Err(self.wrong(
                    format!("no number in the column {}", columns[at]),
                    "a finite number",
                )),
            };
            let whole = |at: usize, most: i64| {
                let value = number(at)?;
                let fits = value.fract() == 0.0 && value >= 1.0 && value <= most as f64;
                fits.then_some(value as u64).ok_or_else(|| {
                    self.wrong(
                        format!("{value} in the column {}", columns[at]),
                        &format!("a whole number from 1 to {most}"),
                    )
                })
            };
            let vector = |at: [usize; 3]| {
                Ok::<_, FormatError>(DVec3::new(number(at[0])?, number(at[1])?, number(at[2])?))
            };
            grains.ids.push(match place.id {
                Some(at) => whole(at, MOST_IDS)?,
                None => row as u64 + 1,
            });
            grains.types.push(match place.kind {
                Some(at) => whole(at, MOST_TYPES)? as u32,
                None => 1,
            });
            let (at, factor) = place.radius;
            let radius = factor * number(at)?;
            if radius <= 0.0 {
                return Err(self.wrong(format!("the radius {radius}"), "a radius above 0, in m"));
            }
            grains.radius.push(radius);
            let mut position = vector(place.position)?;
            if place.is_scaled {
                let Some((low, high)) = bounds else {
                    return Err(self.wrong(
                        "scaled positions without ITEM: BOX BOUNDS",
                        "the bounds first",
                    ));
                };
                position = low + position * (high - low);
            }
            grains.position.push(position);
            if let Some(at) = place.velocity {
                velocity.push(vector(at)?);
            }
            if let Some(at) = place.angular_velocity {
                spin.push(vector(at)?);
            }
            if let Some(at) = place.force {
                force.push(vector(at)?);
            }
            if let Some(at) = place.mass {
                mass.push(number(at)?);
            } else if let Some(at) = place.density {
                mass.push(
                    number(at)? * 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius,
                );
            }
            for (values, &at) in others.iter_mut().zip(&place.others) {
                match cells[at] {
                    (number, true) => values.iter_mut().for_each(|values| values.push(number)),
                    // Words, as the names of elements: no column of numbers.
                    (_, false) => *values = None,
                }
            }
        }
        grains.velocity = place.velocity.map(|_| velocity);
        grains.angular_velocity = place.angular_velocity.map(|_| spin);
        grains.force = place.force.map(|_| force);
        grains.mass = place.mass.or(place.density).map(|_| mass);
        let named = place.others.iter().zip(others);
        grains.others = named
            .filter_map(|(&at, values)| Some((columns[at].clone(), values?)))
            .collect();
        grains.sort().map_err(|id| {
            self.wrong(
                format!("the atom {id} occurs twice in a frame"),
                "each id once",
            )
        })
    }
}

impl<R: BufRead> Iterator for Frames<R> {
    type Item = Result<Grains, FormatError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_over {
            return None;
        }
        let frame = self.frame().transpose();
        self.is_over = !matches!(frame, Some(Ok(_)));
        frame
    }
}

/// In which column each value stands.
struct Places {
    id: Option<usize>,
    kind: Option<usize>,
    /// Column of the radius, and the factor to it.
    radius: (usize, f64),
    position: [usize; 3],
    /// Positions from 0 to 1 within the box.
    is_scaled: bool,
    velocity: Option<[usize; 3]>,
    angular_velocity: Option<[usize; 3]>,
    force: Option<[usize; 3]>,
    mass: Option<usize>,
    density: Option<usize>,
    others: Vec<usize>,
}

impl Places {
    /// A column is missing or occurs twice; the second text is the advice.
    fn of(columns: &[String]) -> Result<Self, (String, &'static str)> {
        if let Some(twice) = (1..columns.len()).find(|&k| columns[..k].contains(&columns[k])) {
            return Err((
                format!("the column {} a second time", columns[twice]),
                "each column once",
            ));
        }
        let at = |name: &str| columns.iter().position(|column| column == name);
        let three = |names: [&str; 3]| Some([at(names[0])?, at(names[1])?, at(names[2])?]);
        let upright = three(["x", "y", "z"]).or_else(|| three(["xu", "yu", "zu"]));
        let scaled = three(["xs", "ys", "zs"]).or_else(|| three(["xsu", "ysu", "zsu"]));
        let Some(position) = upright.or(scaled) else {
            return Err((
                "no columns x, y, z".to_owned(),
                "dump ... custom ... id type x y z radius vx vy vz omegax omegay omegaz",
            ));
        };
        let size = at("radius").map(|at| (at, 1.0));
        let Some(radius) = size.or_else(|| at("diameter").map(|at| (at, 0.5))) else {
            return Err((
                "no column radius or diameter".to_owned(),
                "add radius to the columns of the dump: without it spheres have no size",
            ));
        };
        let mut places = Self {
            id: at("id"),
            kind: at("type"),
            radius,
            position,
            is_scaled: upright.is_none(),
            velocity: three(["vx", "vy", "vz"]),
            angular_velocity: three(["omegax", "omegay", "omegaz"]),
            force: three(["fx", "fy", "fz"]),
            mass: at("mass"),
            density: at("density"),
            others: Vec::new(),
        };
        let used = [
            &["id", "type", "radius", "diameter", "mass", "volume"][..],
            &[
                "x", "y", "z", "vx", "vy", "vz", "omegax", "omegay", "omegaz", "wx", "wy", "wz",
                "fx", "fy", "fz", "material",
            ],
        ]
        .concat();
        places.others = (0..columns.len())
            .filter(|&k| !used.contains(&columns[k].as_str()) && !places.position.contains(&k))
            .collect();
        Ok(places)
    }
}
