//! The energy that a bridge stores: minus the work that it takes to pull it from a gap to its end.

use libm::{atan, exp, log, sqrt};

use super::bridge::{Bridge, SHORT};
use super::formulas::{Curve, Form};
use super::table::bound_of;

/// The pull at a gap `s` >= 0.
#[must_use]
pub(super) fn pull<const N: usize>(form: Form, bridge: &Bridge<f64, N>, s: f64) -> f64 {
    let [f, a, p, q, j] = bridge.resized::<SHORT>().curve;
    match form {
        Form::Exact => bound_of(bridge).force(s),
        Form::Rational => f * (1.0 + a * s) / (1.0 + s * (p + q * s)),
        Form::Exponential if s > 0.0 => {
            let x = log(j * s);
            f * exp(-a * exp(x * (p + q * x)))
        }
        Form::Exponential => f,
    }
}

/// The integral of the pull from a gap `from` >= 0 to the end of a bridge; 0 where `from` lies beyond.
///
/// Of the rational form in closed form. With D = 1 + p s + q s² and Q = √(4q − p²),
/// ∫ (1 + a s)/D ds = (a/2q) ln D + (1 − a p/2q) (2/Q) atan((2 q s + p)/Q). Of the exponential form, and where Q is
/// no real number, by Gauss's rule on panels that become shorter towards the touch, where the pull has a steep start.
#[must_use]
pub(super) fn work<const N: usize>(form: Form, bridge: &Bridge<f64, N>, from: f64) -> f64 {
    let end = bridge.end;
    if from >= end {
        return 0.0;
    }
    let curve = &bridge.resized::<SHORT>().curve;
    let [f, a, p, q, _] = *curve;
    let square = 4.0 * q - p * p;
    match form {
        Form::Exact => -bound_of(bridge).energy(from),
        Form::Rational if square > 0.0 => {
            let root = sqrt(square);
            let integral = |s: f64| {
                0.5 * a / q * log(1.0 + s * (p + q * s))
                    + (1.0 - 0.5 * a * p / q) * (2.0 / root) * atan((2.0 * q * s + p) / root)
            };
            f * (integral(end) - integral(from))
        }
        _ => {
            // Panels between end 2^-k: the pull is smooth in ln s.
            let mut sum = 0.0;
            let mut upper = end;
            for _ in 0..PANELS {
                let lower = (0.5 * upper).max(from);
                sum += panel(form, curve, lower, upper);
                if lower <= from {
                    return sum;
                }
                upper = lower;
            }
            sum + panel(form, curve, from, upper)
        }
    }
}

/// Below `end` 2^-40 the pull is that of the touch to round-off.
const PANELS: usize = 40;

/// Nodes and weights of Gauss and Legendre's rule with eight points on (−1, 1), positive half (Abramowitz & Stegun 1964, table 25.4).
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

fn panel(form: Form, curve: &Curve, lower: f64, upper: f64) -> f64 {
    let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
    let at = |s: f64| {
        let short = Bridge {
            curve: *curve,
            ..Bridge::default()
        };
        pull(form, &short, s)
    };
    let mut sum = 0.0;
    for (node, weight) in GAUSS {
        sum += weight * (at(middle - half * node) + at(middle + half * node));
    }
    half * sum
}
