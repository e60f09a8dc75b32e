//! Coordinates that are resolved, and those over which the fields are averages.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use glam::DVec3;

/// Resolved coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinates {
    /// Any of x, y, z; none of them is the mean over the domain.
    Cartesian([bool; 3]),
    /// About an axis.
    Cylindrical {
        /// Whether the angle is resolved; else fields are means over circles.
        angle: bool,
        /// Whether the coordinate along the axis is.
        along: bool,
    },
}

impl Default for Coordinates {
    fn default() -> Self {
        Self::Cartesian([true; 3])
    }
}

impl Coordinates {
    /// Names of the resolved coordinates in the order of tables.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        match *self {
            Self::Cartesian(resolved) => {
                let axes = ["x", "y", "z"].into_iter().zip(resolved);
                axes.filter(|(_, resolved)| *resolved)
                    .map(|(name, _)| name)
                    .collect()
            }
            Self::Cylindrical { angle, along } => {
                let mut names = vec!["r"];
                names.extend(angle.then_some("phi"));
                names.extend(along.then_some("z"));
                names
            }
        }
    }

    /// Units of the resolved coordinates.
    #[must_use]
    pub fn units(&self) -> Vec<&'static str> {
        self.names()
            .into_iter()
            .map(|name| if name == "phi" { "rad" } else { "m" })
            .collect()
    }

    /// Cartesian axes that the kernel sees; cylindrical coordinates spread in the plane across the axis.
    #[must_use]
    pub fn kernel_axes(&self) -> [bool; 3] {
        match *self {
            Self::Cartesian(resolved) => resolved,
            Self::Cylindrical { along, .. } => [true, true, along],
        }
    }

    /// The number of dimensions of the kernel.
    #[must_use]
    pub fn kernel_dimensions(&self) -> usize {
        self.kernel_axes()
            .into_iter()
            .filter(|&resolved| resolved)
            .count()
    }

    /// The word of the command line.
    #[must_use]
    pub fn word(&self) -> String {
        match *self {
            Self::Cartesian([false, false, false]) => "O".to_owned(),
            Self::Cartesian(_) => self.names().concat().to_uppercase(),
            Self::Cylindrical { angle, along } => {
                format!(
                    "R{}{}",
                    if angle { "phi" } else { "" },
                    if along { "Z" } else { "" }
                )
            }
        }
    }
}

impl fmt::Display for Coordinates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.word())
    }
}

impl FromStr for Coordinates {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let lower = text.to_ascii_lowercase();
        let cartesian = |word: &str| {
            let mut resolved = [false; 3];
            let mut last = None;
            for letter in word.chars() {
                let axis = "xyz".find(letter)?;
                if last.is_some_and(|last| last >= axis) {
                    return None;
                }
                last = Some(axis);
                resolved[axis] = true;
            }
            last.map(|_| Self::Cartesian(resolved))
        };
        let found = match lower.as_str() {
            "o" => Some(Self::Cartesian([false; 3])),
            "r" => Some(Self::Cylindrical {
                angle: false,
                along: false,
            }),
            "rz" => Some(Self::Cylindrical {
                angle: false,
                along: true,
            }),
            "rphi" => Some(Self::Cylindrical {
                angle: true,
                along: false,
            }),
            "rphiz" => Some(Self::Cylindrical {
                angle: true,
                along: true,
            }),
            word => cartesian(word),
        };
        found.ok_or_else(|| "expected O, X, Y, Z, XY, XZ, YZ, XYZ, R, RZ, Rphi or RphiZ".to_owned())
    }
}

/// Points at equal distances along one coordinate: the middles of cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridAxis {
    /// Lower limit.
    pub min: f64,
    /// Upper limit.
    pub max: f64,
    /// Number of cells.
    pub count: usize,
}

impl GridAxis {
    /// Size of a cell.
    #[must_use]
    pub fn step(&self) -> f64 {
        (self.max - self.min) / self.count as f64
    }

    /// The middle of a cell.
    #[must_use]
    pub fn at(&self, k: usize) -> f64 {
        self.min + (k as f64 + 0.5) * self.step()
    }
}

/// Where fields are evaluated.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// Middles of the cells of a grid: one axis per resolved coordinate, the last one running fastest.
    Grid(Vec<GridAxis>),
    /// Points, each with its resolved coordinates.
    Points(Vec<Vec<f64>>),
}

impl Place {
    /// The number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Grid(axes) => axes.iter().map(|axis| axis.count).product(),
            Self::Points(points) => points.len(),
        }
    }

    /// Whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The resolved coordinates of a point.
    #[must_use]
    pub fn coordinates(&self, point: usize) -> Vec<f64> {
        match self {
            Self::Grid(axes) => {
                let mut rest = point;
                let mut found: Vec<f64> = axes
                    .iter()
                    .rev()
                    .map(|axis| {
                        let k = rest % axis.count;
                        rest /= axis.count;
                        axis.at(k)
                    })
                    .collect();
                found.reverse();
                found
            }
            Self::Points(points) => points[point].clone(),
        }
    }
}

/// The axis of cylindrical coordinates: through a point, along x, y or z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CylinderAxis {
    /// Number of the axis: 0, 1, 2.
    pub along: usize,
    /// A point on it, m.
    pub through: DVec3,
}

impl Default for CylinderAxis {
    fn default() -> Self {
        Self {
            along: 2,
            through: DVec3::ZERO,
        }
    }
}

impl CylinderAxis {
    /// Turns the axes cyclically so that the cylinder's axis is the third, with the origin on it; the coordinate along it is that of the input.
    #[must_use]
    pub fn turn_point(&self, x: DVec3) -> DVec3 {
        let mut from = self.through;
        from[self.along] = 0.0;
        self.turn(x - from)
    }

    /// Components of a vector, permuted in this way.
    #[must_use]
    pub fn turn(&self, v: DVec3) -> DVec3 {
        let k = self.along;
        DVec3::new(v[(k + 1) % 3], v[(k + 2) % 3], v[k])
    }
}

/// Angles of a circle beyond one for each width of the kernel along it.
const MORE_ANGLES: usize = 8;

/// The number of angles of a mean over a circle, for a kernel of this width.
///
/// The mean of a Gaussian of width w around a point at distance s from the axis is `exp(-(r^2 + s^2) / 2 w^2) I_0(r s / w^2)`, and what n
/// angles at equal distances add to it is twice the same with I_n (the trapezoidal rule). Components along r and phi turn with the angle, those of
/// tensors twice, which makes it I_(n-2). With n = 2 pi r/w + 8 this is below 1e-8 for all r and s.
#[must_use]
pub fn angles(radius: f64, smooth: f64) -> usize {
    (2.0 * PI * radius / smooth).ceil() as usize + MORE_ANGLES
}
