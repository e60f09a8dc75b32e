//! A table of exact bridges for one contact angle, from which the numbers of any one of them are interpolated.

use rayon::prelude::*;

use super::axis::Axis;
use super::bound::Bound;
use super::exact::{Branch, Failure};
use super::node::{Node, solved_at, stretch};

/// Share of the end up to which accuracy is promised and measured. Behind it, within a hair of the rupture, some per cent are missing.
pub const MEASURED_TO: f64 = 0.95;

/// Width of a cell in the logarithm of the volume and in [`shape`], of the first try and of the last one.
const CELLS: [(f64, f64); 2] = [(0.8, 0.05), (0.4, 0.025)];

/// Shares of the end at which a table is measured, between those at which it is fitted.
const SHARES: [f64; 11] = [
    0.0,
    0.02,
    0.06,
    0.12,
    0.2,
    0.3,
    0.45,
    0.6,
    0.75,
    0.87,
    MEASURED_TO,
];

/// Why there is no table.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TableError {
    /// A range is empty or outside of what makes sense, or the accuracy is.
    #[error(
        "a table of liquid bridges needs volumes above 0, ratios of radii from 0 to 1 and an accuracy above 0, each range in order, but got volumes {volumes:?}, ratios {ratios:?} and accuracy {accuracy}"
    )]
    Range {
        /// Smallest and largest volume, R_D^3.
        volumes: (f64, f64),
        /// Smallest and largest ratio of radii.
        ratios: (f64, f64),
        /// Largest relative error.
        accuracy: f64,
    },
    /// One of the bridges has no solution.
    #[error(transparent)]
    Bridge(#[from] Failure),
    /// The finest table is not good enough.
    #[error("the table of liquid bridges is accurate to {reached:.1e} only, not to {wanted:.1e}")]
    Accuracy {
        /// Requested relative error.
        wanted: f64,
        /// Relative error of the finest table.
        reached: f64,
    },
}

/// Largest errors of a table, measured in the middle of each of its cells and along its edges. Between, they are hardly larger.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Errors {
    /// Of the force up to [`MEASURED_TO`] of the end, relative to the exact force there (or to that at the end, if it is larger).
    pub force: f64,
    /// Of the end, relative.
    pub end: f64,
    /// Of the work from the touch to the end, relative.
    pub work: f64,
    /// Of the lateral area up to [`MEASURED_TO`] of the end, relative.
    pub area: f64,
}

impl Errors {
    fn largest(self, other: Self) -> Self {
        Self {
            force: f64::max(self.force, other.force),
            end: f64::max(self.end, other.end),
            work: f64::max(self.work, other.work),
            area: f64::max(self.area, other.area),
        }
    }
}

/// Entry of a table for one bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Binding {
    /// Force, energy and end.
    pub bound: Bound,
    /// Whether volume and ratio of radii lie in the table. Otherwise they are those of its nearest bridge, with an end that follows the cube
    /// root of the true volume.
    pub inside: bool,
}

/// Exact bridges of one contact angle, over volume and ratio of radii. Units as the [module](super) has them.
///
/// ```
/// use mercury_engine::contact::adhesion::young_laplace::Table;
/// let table = Table::new(0.0, (0.008, 0.0125), (1.0, 1.0), 1e-3)?;
/// let bound = table.bind(0.01, 1.0).bound;
/// assert!((bound.force(0.0) / 5.5568523 - 1.0).abs() < 1e-3);
/// assert_eq!(bound.energy(bound.end), 0.0);
/// # Ok::<(), mercury_engine::contact::adhesion::young_laplace::TableError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Table {
    theta: f64,
    volumes: Axis,
    shapes: Axis,
    nodes: Vec<Node>,
    errors: Errors,
}

impl Table {
    /// Solves for all of its bridges, in parallel, to the same numbers at any number of threads.
    ///
    /// `theta` is the contact angle (rad); volumes (R_D^3) and ratios of radii (smaller over larger, 0 for a plane) are ranges, which
    /// may be single values; `accuracy` is the largest relative error of the force up to [`MEASURED_TO`] of the end.
    ///
    /// # Errors
    /// If the input makes no sense, a bridge has no solution, or the accuracy is out of reach.
    pub fn new(
        theta: f64,
        volumes: (f64, f64),
        ratios: (f64, f64),
        accuracy: f64,
    ) -> Result<Self, TableError> {
        let sensible = volumes.0 > 0.0
            && volumes.0 <= volumes.1
            && volumes.1.is_finite()
            && ratios.0 >= 0.0
            && ratios.0 <= ratios.1
            && ratios.1 <= 1.0
            && accuracy > 0.0;
        if !sensible {
            return Err(TableError::Range {
                volumes,
                ratios,
                accuracy,
            });
        }
        let mut reached = f64::INFINITY;
        for (volume_cell, shape_cell) in CELLS {
            let volumes = Axis::new(libm::log(volumes.0), libm::log(volumes.1), volume_cell);
            let shapes = Axis::new(shape(ratios.1), shape(ratios.0), shape_cell);
            let table = Self::of_nodes(theta, volumes, shapes)?;
            if table.errors.force <= accuracy {
                return Ok(table);
            }
            reached = f64::min(reached, table.errors.force);
        }
        Err(TableError::Accuracy {
            wanted: accuracy,
            reached,
        })
    }

    fn of_nodes(theta: f64, volumes: Axis, shapes: Axis) -> Result<Self, Failure> {
        let nodes = (0..volumes.count * shapes.count)
            .into_par_iter()
            .map(|k| {
                let log_volume = volumes.value((k / shapes.count) as f64);
                Node::solved(
                    theta,
                    log_volume,
                    ratio(shapes.value((k % shapes.count) as f64)),
                )
            })
            .collect::<Result<_, _>>()?;
        let mut table = Self {
            theta,
            volumes,
            shapes,
            nodes,
            errors: Errors::default(),
        };
        table.errors = table.measured()?;
        Ok(table)
    }

    /// Contact angle, rad.
    #[must_use]
    pub fn contact_angle(&self) -> f64 {
        self.theta
    }

    /// Largest errors, measured between its nodes.
    #[must_use]
    pub fn errors(&self) -> Errors {
        self.errors
    }

    /// How many bridges were solved for it, without those that it was measured by.
    #[must_use]
    pub fn bridges(&self) -> usize {
        self.nodes.len()
    }

    /// The numbers of the bridge of a volume (R_D^3) between spheres of a ratio of radii (smaller over larger). They last as long as
    /// these two stay. A volume that is not above 0 has no bridge: [`Bound::NONE`].
    #[must_use]
    pub fn bind(&self, volume: f64, ratio: f64) -> Binding {
        if !(volume > 0.0 && volume.is_finite()) {
            return Binding {
                bound: Bound::NONE,
                inside: false,
            };
        }
        let (node, log_volume, inside) = self.interpolated(volume, ratio);
        let end = node.end * libm::cbrt(volume);
        Binding {
            bound: Bound::new(end, stretch(log_volume), node.force),
            inside,
        }
    }

    /// The gap (R_D) at which the bridge of a volume (R_D^3) between spheres of a ratio of radii ends; 0 where there is none.
    #[must_use]
    pub fn end(&self, volume: f64, ratio: f64) -> f64 {
        if !(volume > 0.0 && volume.is_finite()) {
            return 0.0;
        }
        self.interpolated(volume, ratio).0.end * libm::cbrt(volume)
    }

    /// A bound of the ends over the cube root of the volume, of all bridges: the interpolation between nodes stays below it.
    #[must_use]
    pub fn longest(&self) -> f64 {
        let ends = self.nodes.iter().map(|node| node.end);
        1.01 * ends.fold(0.0, f64::max)
    }

    /// Whether a bridge lies in the table, so that none nearby has to stand for it.
    #[must_use]
    pub fn holds(&self, volume: f64, ratio: f64) -> bool {
        self.volumes.clamped(libm::log(volume)).1 && self.shapes.clamped(shape(ratio)).1
    }

    /// Lateral area (R_D^2) at a gap (R_D) of the bridge of a volume (R_D^3); that of the touch in contact, that of the end beyond it.
    #[must_use]
    pub fn area(&self, volume: f64, ratio: f64, gap: f64) -> f64 {
        if !(volume > 0.0 && volume.is_finite()) {
            return 0.0;
        }
        let (node, log_volume, _) = self.interpolated(volume, ratio);
        let root = libm::cbrt(volume);
        let share = (gap / (node.end * root)).clamp(0.0, 1.0);
        let t = (1.0 - share).sqrt();
        let x = t / (1.0 + stretch(log_volume) * (1.0 - t));
        let area = node.area.iter().rev().fold(0.0, |sum, a| sum * x + a);
        area * root * root
    }

    /// The node for a bridge, the logarithm of the volume at which the table was read, and whether it and the ratio lie in the table.
    fn interpolated(&self, volume: f64, ratio: f64) -> (Node, f64, bool) {
        let (log_volume, volume_inside) = self.volumes.clamped(libm::log(volume));
        let (shape, ratio_inside) = self.shapes.clamped(shape(ratio));
        let (first_row, rows) = self.volumes.weights(log_volume);
        let (first, columns) = self.shapes.weights(shape);
        let mut sum = Node::default();
        for (i, row) in rows.iter().enumerate().take(self.volumes.count) {
            for (j, column) in columns.iter().enumerate().take(self.shapes.count) {
                let node = (first_row + i) * self.shapes.count + first + j;
                sum.add(row * column, &self.nodes[node]);
            }
        }
        (sum, log_volume, volume_inside && ratio_inside)
    }

    /// Errors in the middle of each cell, and along the edges.
    fn measured(&self) -> Result<Errors, Failure> {
        let (rows, columns) = (self.volumes.probes(), self.shapes.probes());
        let errors: Vec<Errors> = (0..rows.len() * columns.len())
            .into_par_iter()
            .map(|k| {
                let volume = libm::exp(rows[k / columns.len()]);
                self.errors_at(volume, ratio(columns[k % columns.len()]))
            })
            .collect::<Result<_, _>>()?;
        Ok(errors.into_iter().fold(Errors::default(), Errors::largest))
    }

    fn errors_at(&self, volume: f64, ratio: f64) -> Result<Errors, Failure> {
        let branch = Branch::new(self.theta, volume, ratio)?;
        let bound = self.bind(volume, ratio).bound;
        let (end, last) = (branch.end(), branch.last());
        let relative = |found: f64, exact: f64| ((found - exact) / exact).abs();
        let mut errors = Errors {
            end: relative(bound.end, end),
            ..Errors::default()
        };
        for share in SHARES {
            let gap = share * end;
            let exact = solved_at(&branch, (self.theta, volume, ratio), gap)?;
            let scale = f64::max(exact.force.abs(), last.force);
            let force = (bound.force(gap) - exact.force).abs() / scale;
            let area = relative(self.area(volume, ratio, gap), exact.area);
            errors.force = f64::max(errors.force, force);
            errors.area = f64::max(errors.area, area);
            if share == 0.0 {
                let work = last.surface_energy - exact.surface_energy;
                errors.work = relative(-bound.energy(0.0), work);
            }
        }
        Ok(errors)
    }
}

/// Coordinate of the table for the ratio of radii: |d|^(2/3) with d = (1 - ratio)/(1 + ratio), from 0 for equal spheres to 1 for
/// a plane.
///
/// Where asymmetric shapes end the stable branch, its end is a smooth function of this power near equal spheres, as that of any
/// slightly imperfect pitchfork is (Koiter 1945); elsewhere of d^2, which is the third power of it.
fn shape(ratio: f64) -> f64 {
    let d = (1.0 - ratio) / (1.0 + ratio);
    libm::cbrt(d * d)
}

/// The ratio of radii for a [`shape`].
fn ratio(shape: f64) -> f64 {
    let root = shape.clamp(0.0, 1.0).sqrt();
    let d = root * root * root;
    (1.0 - d) / (1.0 + d)
}

#[cfg(test)]
mod tests {
    use super::super::NUMBERS;
    use super::*;

    const DEGREE: f64 = std::f64::consts::PI / 180.0;

    /// Even numbers in (0, 1).
    fn random() -> impl FnMut() -> f64 {
        let mut state = 20_261_125_u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
        }
    }

    #[test]
    fn random_bridges_are_within_the_accuracy() {
        for degrees in [0.0, 28.0, 60.0, 75.0, 90.0] {
            let theta = degrees * DEGREE;
            let (volumes, accuracy) = ((1e-4, 0.2), 1e-3);
            let table = Table::new(theta, volumes, (0.0, 1.0), accuracy).unwrap();
            assert!(table.errors().force <= accuracy && table.errors().end <= 1e-2);
            let mut random = random();
            for k in 0..60 {
                let share = random();
                let volume = volumes.0 * libm::pow(volumes.1 / volumes.0, share);
                // every third one next to equal spheres, where the table is steepest
                let ratio = if k % 3 == 0 {
                    1.0 - 0.05 * random() * random()
                } else {
                    random()
                };
                let branch = Branch::new(theta, volume, ratio).unwrap();
                let Binding { bound, inside } = table.bind(volume, ratio);
                assert!(inside);
                assert!((bound.end / branch.end() - 1.0).abs() < 1e-2);
                let place = format!("{degrees} degrees, V* = {volume}, ratio {ratio}");
                for share in [0.0, random() * MEASURED_TO, MEASURED_TO] {
                    let gap = share * branch.end();
                    let exact = branch.at(gap).unwrap();
                    // As it is measured: the force may be 0 near the touch at wide angles.
                    let scale = f64::max(exact.force.abs(), branch.last().force);
                    let force = (bound.force(gap) - exact.force) / scale;
                    assert!(force.abs() < accuracy, "{place}, {share}: {force}");
                    let area = table.area(volume, ratio, gap) / exact.area - 1.0;
                    assert!(area.abs() < accuracy, "{place}, {share}: area {area}");
                    let stored = exact.surface_energy - branch.last().surface_energy;
                    let touch = branch.at(0.0).unwrap().surface_energy;
                    let work = branch.last().surface_energy - touch;
                    // the integral of forces that are within the accuracy
                    let energy = (bound.energy(gap) - stored) / work;
                    assert!(energy.abs() < accuracy, "{place}, {share}: energy {energy}");
                }
            }
        }
    }

    #[test]
    fn the_same_numbers_at_any_number_of_threads() {
        let numbers = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            let table = pool.install(|| Table::new(0.4, (0.01, 0.02), (0.5, 1.0), 1e-3));
            let table = table.unwrap();
            let errors = table.errors();
            let bound = table.bind(0.013, 0.7).bound.to_array();
            let bits = bound.map(f64::to_bits);
            (table.nodes, bits, errors)
        };
        assert_eq!(numbers(1), numbers(2));
    }

    #[test]
    fn one_volume_and_one_ratio_make_a_table_of_one_bridge() {
        let table = Table::new(0.3, (0.02, 0.02), (0.0, 0.0), 1e-3).unwrap();
        assert_eq!(table.bridges(), 1);
        let branch = Branch::new(0.3, 0.02, 0.0).unwrap();
        let Binding { bound, inside } = table.bind(0.02, 0.0);
        assert!(inside);
        assert!((bound.end / branch.end() - 1.0).abs() < 1e-12);
        let gap = 0.4 * bound.end;
        let exact = branch.at(gap).unwrap();
        assert!((bound.force(gap) / exact.force - 1.0).abs() < 1e-3);
    }

    #[test]
    fn outside_of_its_ranges_the_table_gives_its_nearest_bridge_and_reports_it() {
        let table = Table::new(0.3, (0.01, 0.02), (0.5, 1.0), 1e-3).unwrap();
        let edge = table.bind(0.02, 0.5);
        assert!(edge.inside);
        let beyond = table.bind(8.0 * 0.02, 0.2);
        assert!(!beyond.inside);
        // twice the cube root of the volume: the end twice as far, the force the same at the same share of it
        assert!((beyond.bound.end / edge.bound.end - 2.0).abs() < 1e-12);
        let (near, far) = (edge.bound.force(0.1), beyond.bound.force(0.2));
        assert!((near / far - 1.0).abs() < 1e-12);
        // a smaller one
        let less = table.bind(1e-9, 1.0);
        assert!(!less.inside && less.bound.end > 0.0 && less.bound.end < 0.01);
        // no liquid, and no numbers
        for volume in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let none = table.bind(volume, 1.0);
            assert_eq!((none.bound, none.inside), (Bound::NONE, false));
            assert_eq!(table.area(volume, 1.0, 0.0), 0.0);
        }
        let odd = table.bind(0.015, f64::NAN);
        assert!(!odd.inside && odd.bound.to_array().iter().all(|x| x.is_finite()));
        assert_eq!(odd.bound.to_array().len(), NUMBERS);
    }

    #[test]
    fn impossible_input_is_refused() {
        for (volumes, ratios, accuracy) in [
            ((0.0, 0.1), (0.0, 1.0), 1e-3),
            ((0.2, 0.1), (0.0, 1.0), 1e-3),
            ((0.1, f64::INFINITY), (0.0, 1.0), 1e-3),
            ((f64::NAN, 0.1), (0.0, 1.0), 1e-3),
            ((0.01, 0.1), (-0.1, 1.0), 1e-3),
            ((0.01, 0.1), (0.0, 1.1), 1e-3),
            ((0.01, 0.1), (0.0, 1.0), 0.0),
            ((0.01, 0.1), (0.0, 1.0), f64::NAN),
        ] {
            let error = Table::new(0.3, volumes, ratios, accuracy).unwrap_err();
            assert!(matches!(error, TableError::Range { .. }), "{error}");
        }
        let error = Table::new(2.0, (0.01, 0.01), (1.0, 1.0), 1e-3).unwrap_err();
        assert!(matches!(error, TableError::Bridge(_)), "{error}");
        let error = Table::new(0.3, (0.01, 0.01), (1.0, 1.0), 1e-12).unwrap_err();
        assert!(error.to_string().contains("not to 1.0e-12"), "{error}");
    }
}
