//! Every kind of lanes gives in each of them the bits of a number alone.

use std::array::from_fn;

use super::*;

/// Numbers of every kind: both zeros, the smallest, the infinities, no number.
const KINDS: [f64; 12] = [
    0.0,
    -0.0,
    1.0,
    -1.5,
    3.0e-310,
    -3.0e-310,
    1e300,
    -1e300,
    f64::MIN_POSITIVE,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Bits that may be compared: the bits of a NaN are not specified.
fn bits(number: f64) -> u64 {
    // Checked on the bits: seen here with rustc 1.95, `is_nan` of a root of a constant below zero is folded to "no". The solver
    // does not test a constant in this way.
    let bits = number.to_bits();
    if bits & (u64::MAX >> 1) > f64::INFINITY.to_bits() {
        u64::MAX
    } else {
        bits
    }
}

fn assert_lanes<L: Real>(lanes: L, alone: impl Fn(usize) -> f64) {
    for k in 0..L::LANES {
        assert_eq!(bits(lanes.lane(k)), bits(alone(k)), "lane {k} of {lanes:?}");
    }
}

/// Every operation on every pair of kinds.
struct Operations;

impl Task for Operations {
    type Output = ();

    #[inline(always)]
    fn run<L: Real>(self) {
        for a in KINDS {
            for b in KINDS {
                let one = [a, 2.0, b, 0.5, -a, a, 3.0, b];
                let two = [b, 4.0, a, -2.0, b, a, a, -0.0];
                let (x, y) = (L::load(&one), L::load(&two));
                let check = |lanes: L, alone: fn(f64, f64) -> f64| {
                    assert_lanes(lanes, |k| alone(one[k], two[k]));
                };
                check(x + y, |a, b| a + b);
                check(x - y, |a, b| a - b);
                check(x * y, |a, b| a * b);
                check(x / y, |a, b| a / b);
                check(-x, |a, _| -a);
                check(x + 2.5, |a, _| a + 2.5);
                check(x - 2.5, |a, _| a - 2.5);
                check(x * 2.5, |a, _| a * 2.5);
                check(x / 2.5, |a, _| a / 2.5);
                check(x.sqrt(), |a, _| Real::sqrt(a));
                check(x.abs(), |a, _| Real::abs(a));
                check(x.min(y), Real::min);
                check(x.max(y), Real::max);
                let masks = [
                    x.below(y),
                    x.at_most(y),
                    x.equals(y),
                    !x.below(y),
                    x.below(y) | x.equals(y),
                    x.at_most(y) & y.at_most(x),
                ];
                let alone: [fn(f64, f64) -> bool; 6] = [
                    |a, b| a < b,
                    |a, b| a <= b,
                    |a, b| a == b,
                    |a, b| !a.below(b),
                    |a, b| a.below(b) | a.equals(b),
                    |a, b| a <= b && b <= a,
                ];
                for (mask, alone) in masks.into_iter().zip(alone) {
                    let set = |k: &usize| alone(one[*k], two[*k]);
                    let bits = (0..L::LANES).filter(set).fold(0, |bits, k| bits | 1 << k);
                    assert_eq!(mask.bits(), bits);
                    assert_eq!(mask.any(), (0..L::LANES).any(|k| set(&k)));
                    assert_eq!(mask.all(), (0..L::LANES).all(|k| set(&k)));
                    let chosen = L::select(mask, x, y);
                    assert_lanes(chosen, |k| if set(&k) { one[k] } else { two[k] });
                }
            }
        }
        assert_lanes(L::splat(-2.5), |_| -2.5);
        assert_lanes(L::ZERO, |_| 0.0);
        assert_lanes(L::ONE, |_| 1.0);
        assert_lanes(L::default(), |_| 0.0);
        assert!(L::ONE == L::splat(1.0) && L::ONE != L::ZERO);
    }
}

/// From memory and back.
struct Memory;

impl Task for Memory {
    type Output = ();

    #[inline(always)]
    fn run<L: Real>(self) {
        let numbers: [f64; 9] = from_fn(|k| k as f64 + 0.5);
        let lanes = L::load(&numbers[1..]);
        assert_lanes(lanes, |k| numbers[k + 1]);
        let mut written = [0.0; 10];
        lanes.store(&mut written[1..]);
        let expected = from_fn(|k| {
            if (1..=L::LANES).contains(&k) {
                numbers[k]
            } else {
                0.0
            }
        });
        assert_eq!(written, expected, "and nothing beside");

        for bits in 0..1u32 << L::LANES {
            let chosen = (0..L::LANES).filter(|k| bits >> k & 1 == 1);
            let packed = lanes.packed(bits);
            for (place, k) in chosen.enumerate() {
                assert_eq!(packed.lane(place), lanes.lane(k), "{bits:b}");
            }
        }

        let quads: [Quad; 9] = from_fn(|k| {
            Quad(from_fn(|j| {
                if j == 3 {
                    KINDS[k]
                } else {
                    (10 * k + j) as f64
                }
            }))
        });
        let columns = L::columns(|k| &quads[k]);
        for (j, column) in columns.into_iter().enumerate() {
            assert_lanes(column, |k| quads[k].0[j]);
        }
        let vector: Vector<L> = L::vectors(|k| &quads[k]);
        for (j, column) in vector.to_array().into_iter().enumerate() {
            assert_lanes(column, |k| quads[k].0[j]);
        }
        let rows = L::rows(vector, columns[3]);
        for (row, quad) in rows[..L::LANES].iter().zip(&quads) {
            assert_eq!(row.0.map(bits), quad.0.map(bits));
        }
        let differences = L::differences(|k| &quads[k], |k| &quads[k + 1]);
        for (j, difference) in differences.into_iter().enumerate() {
            assert_lanes(difference, |k| {
                let (a, b) = (quads[k].0[j], quads[k + 1].0[j]);
                if j == 3 { a + b } else { a - b }
            });
        }
    }
}

#[test]
fn every_lane_gets_the_bits_of_a_number_alone() {
    Operations.run::<Lanes<4>>();
    for width in Width::all() {
        width.run(Operations);
    }
}

#[test]
fn lanes_come_from_memory_and_go_back() {
    Memory.run::<Lanes<4>>();
    for width in Width::all() {
        width.run(Memory);
    }
}

#[test]
fn widths_are_those_that_the_processor_can() {
    let all: Vec<usize> = Width::all().into_iter().map(Width::lanes).collect();
    assert_eq!(all[..2], [1, 2]);
    assert!(all.contains(&Width::fastest().lanes()));
    assert_eq!(Width::of(8), None);
    assert_eq!(Width::of(3), None);
    assert_eq!(Width::of(0), None);
}
