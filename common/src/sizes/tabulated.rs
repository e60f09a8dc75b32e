//! Number laws without a closed form: integrated once, inverted by Newton steps.

/// A law of the diameter on [smallest, largest] whose density is known up to a factor.
///
/// The integral over y = ln d is tabulated at the edges of equal panels, each by the ten-point rule of
/// Gauss and Legendre, which for a smooth density over a 256th of the range is exact to round-off.
#[derive(Debug, Clone)]
pub(super) struct Tabulated {
    /// ln d of the panels' edges.
    edges: Vec<f64>,
    /// Share below each edge; 0 at the first, 1 at the last.
    cumulative: Vec<f64>,
    /// Integral over everything, before scaling.
    total: f64,
}

const PANELS: usize = 256;

/// Abscissae and weights on [-1, 1], positive half (Abramowitz and Stegun 1964, table 25.4).
const GAUSS_LEGENDRE: [(f64, f64); 5] = [
    (0.148_874_338_981_631_22, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

fn integral(function: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let sum: f64 = GAUSS_LEGENDRE
        .iter()
        .map(|(x, weight)| weight * (function(middle - half * x) + function(middle + half * x)))
        .sum();
    sum * half
}

impl Tabulated {
    /// Tabulates a density of d, given up to a factor.
    pub(super) fn new(smallest: f64, largest: f64, density: impl Fn(f64) -> f64) -> Self {
        let (low, high) = (libm::log(smallest), libm::log(largest));
        let edge = |i: usize| low + (high - low) * i as f64 / PANELS as f64;
        let edges: Vec<f64> = (0..=PANELS).map(edge).collect();
        let mut cumulative = vec![0.0];
        let mut total = 0.0;
        for panel in edges.windows(2) {
            total += integral(|y| per_ln(&density, y), panel[0], panel[1]);
            cumulative.push(total);
        }
        for share in &mut cumulative {
            *share /= total;
        }
        Self {
            edges,
            cumulative,
            total,
        }
    }

    /// Number-weighted mean of a function of d.
    pub(super) fn mean(&self, density: impl Fn(f64) -> f64, value: impl Fn(f64) -> f64) -> f64 {
        let weighted = |y: f64| per_ln(&density, y) * value(libm::exp(y));
        let sum: f64 = self
            .edges
            .windows(2)
            .map(|panel| integral(weighted, panel[0], panel[1]))
            .sum();
        sum / self.total
    }

    /// The integral of the density as given.
    pub(super) fn total(&self) -> f64 {
        self.total
    }

    /// Share below d.
    pub(super) fn cdf(&self, density: impl Fn(f64) -> f64, diameter: f64) -> f64 {
        let y = libm::log(diameter);
        let panel = self.edges.partition_point(|&edge| edge <= y);
        if panel == 0 {
            return 0.0;
        }
        if panel > PANELS {
            return 1.0;
        }
        let left = self.edges[panel - 1];
        let part = integral(|y| per_ln(&density, y), left, y) / self.total;
        self.cumulative[panel - 1] + part
    }

    /// The d below which a share u lies: Newton steps on the integral inside a panel, kept in a bracket
    /// by bisection.
    pub(super) fn quantile(&self, density: impl Fn(f64) -> f64, u: f64) -> f64 {
        let panel = self
            .cumulative
            .partition_point(|&share| share <= u)
            .clamp(1, PANELS);
        let start = self.edges[panel - 1];
        let wanted = (u - self.cumulative[panel - 1]) * self.total;
        let (mut low, mut high) = (start, self.edges[panel]);
        let mut y = 0.5 * (low + high);
        for _ in 0..60 {
            let excess = integral(|y| per_ln(&density, y), start, y) - wanted;
            if excess > 0.0 {
                high = y;
            } else {
                low = y;
            }
            let newton = y - excess / per_ln(&density, y);
            let next = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            if (next - y).abs() <= 1e-15 * (1.0 + y.abs()) {
                return libm::exp(next);
            }
            y = next;
        }
        libm::exp(y)
    }
}

/// Density per ln d.
fn per_ln(density: impl Fn(f64) -> f64, y: f64) -> f64 {
    let diameter = libm::exp(y);
    density(diameter) * diameter
}
