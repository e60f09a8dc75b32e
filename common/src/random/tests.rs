use super::*;

/// Draws per statistical test. A mean of n draws has the standard error sigma / sqrt(n); the bound of 5 of them is missed by
/// chance once in 1.7 million tests, and never again once it holds, as the numbers are frozen.
const DRAWS: usize = 100_000;

fn assert_mean(
    values: impl Iterator<Item = f64>,
    expected: f64,
    standard_deviation: f64,
    what: &str,
) {
    let values: Vec<f64> = values.collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let bound = 5.0 * standard_deviation / (values.len() as f64).sqrt();
    assert!(
        (mean - expected).abs() < bound,
        "{what}: mean {mean}, expected {expected} +- {bound}"
    );
}

const FROZEN_WORDS: [u64; 4] = [
    0xf5cd_dbdf_0575_335f,
    0x1b8c_cdfc_7ba5_1a53,
    0xb2b1_a629_e659_9a93,
    0xcca1_ea32_141f_0852,
];
const FROZEN_FAR: u64 = 0x7fcc_da16_4ddc_7df9;
const FROZEN_UNIFORM: f64 = 0.9601724071012157;
/// A normal number, a unit vector, and a quaternion (x, y, z, w).
const FROZEN_DRAWS: [f64; 8] = [
    -1.2392997361081444,
    0.2801558536036708,
    -0.8744483582398824,
    0.3960464195813074,
    0.13875651068838996,
    0.6087891602449411,
    -0.4439946275308428,
    0.6426438825925213,
];

#[test]
fn hash_is_fnv1a() {
    // Test vectors of the authors.
    assert_eq!(fnv1a_64(b""), 0xcbf2_9ce4_8422_2325);
    assert_eq!(fnv1a_64(b"a"), 0xaf63_dc4c_8601_ec8c);
    assert_eq!(fnv1a_64(b"foobar"), 0x8594_4171_f739_67e8);
}

/// These numbers must never change: packings of users depend on them.
#[test]
fn frozen_words() {
    // Computed from the definition by a program in another language.
    let mut stream = Stream::new(42, "insertion", 0);
    for expected in FROZEN_WORDS {
        assert_eq!(stream.next_u64(), expected);
    }
    let far = Stream::new(u64::MAX, "sizes", (1 << 40) + 3)
        .at((1 << 33) + 1)
        .next_u64();
    assert_eq!(far, FROZEN_FAR);
}

/// Frozen values of the functions that are built on the frozen words. Python's library gives the same bits.
#[test]
fn frozen_draws() {
    let mut stream = Stream::new(42, "insertion", 0);
    assert_eq!(stream.uniform().to_bits(), FROZEN_UNIFORM.to_bits());
    let normal = stream.standard_normal();
    let vector = stream.unit_vector();
    let rotation = stream.unit_quaternion();
    assert_eq!(stream.position(), 1 + 1 + 2 + 3);
    let mut found = vec![normal];
    found.extend(vector.to_array());
    found.extend(rotation.to_array());
    assert_eq!(found, FROZEN_DRAWS);
}

#[test]
fn a_position_resumes_the_stream() {
    let mut stream = Stream::new(1, "test", 5);
    for _ in 0..7 {
        let mut resumed = Stream::new(1, "test", 5).at(stream.position());
        let mut rewound = stream.clone().at(3).at(stream.position());
        let ahead: Vec<u64> = {
            let mut copy = stream.clone();
            (0..5).map(|_| copy.next_u64()).collect()
        };
        assert_eq!(
            (0..5).map(|_| resumed.next_u64()).collect::<Vec<_>>(),
            ahead
        );
        assert_eq!(
            (0..5).map(|_| rewound.next_u64()).collect::<Vec<_>>(),
            ahead
        );
        stream.next_u64();
    }
}

#[test]
fn streams_differ_in_seed_purpose_and_index() {
    let first = |seed, purpose, index| Stream::new(seed, purpose, index).next_u64();
    let mut words = vec![
        first(0, "a", 0),
        first(1, "a", 0),
        first(0, "b", 0),
        first(0, "", 0),
        first(0, "ab", 0),
        first(1 << 63, "a", 0),
        first(0, "a", 1 << 63),
    ];
    words.extend((1..1000).map(|index| first(0, "a", index)));
    let count = words.len();
    words.sort_unstable();
    words.dedup();
    assert_eq!(words.len(), count);
}

/// Moments of the uniform distribution: 1/2, 1/12, and no correlation of neighbours or streams.
#[test]
fn uniform_numbers() {
    let mut stream = Stream::new(1, "uniform", 0);
    let u: Vec<f64> = (0..DRAWS).map(|_| stream.uniform()).collect();
    assert!(u.iter().all(|u| (0.0..1.0).contains(u)));
    assert_mean(u.iter().copied(), 0.5, (1.0f64 / 12.0).sqrt(), "u");
    // Fourth central moment 1/80, so the variance of (u - 1/2)^2 is 1/80 - 1/144.
    let spread = (1.0f64 / 80.0 - 1.0 / 144.0).sqrt();
    assert_mean(
        u.iter().map(|u| (u - 0.5).powi(2)),
        1.0 / 12.0,
        spread,
        "variance",
    );
    assert_mean(
        u.windows(2).map(|w| (w[0] - 0.5) * (w[1] - 0.5)),
        0.0,
        1.0 / 12.0,
        "neighbours",
    );
    let across = (0..DRAWS as u64).map(|index| {
        let draw = |index| Stream::new(1, "uniform", index).uniform() - 0.5;
        draw(index) * draw(index + 1)
    });
    assert_mean(across, 0.0, 1.0 / 12.0, "neighbouring streams");
    // Chi-squared with 99 degrees of freedom: mean 99, standard deviation sqrt(198).
    let mut bins = [0.0; 100];
    u.iter().for_each(|u| bins[(u * 100.0) as usize] += 1.0);
    let expected = DRAWS as f64 / 100.0;
    let chi_squared: f64 = bins
        .iter()
        .map(|n: &f64| (n - expected).powi(2) / expected)
        .sum();
    assert!(
        (chi_squared - 99.0).abs() < 5.0 * 198f64.sqrt(),
        "{chi_squared}"
    );
    let x = stream.uniform_in(-3.0, -1.0);
    assert!((-3.0..=-1.0).contains(&x));
}

/// Moments of the normal distribution: 0, 1, 0, 3, with the variances 1, 2, 15, 96.
#[test]
fn normal_numbers() {
    let mut stream = Stream::new(1, "normal", 0);
    let z: Vec<f64> = (0..DRAWS).map(|_| stream.standard_normal()).collect();
    for (power, expected, variance) in [
        (1, 0.0, 1.0),
        (2, 1.0, 2.0),
        (3, 0.0, 15.0),
        (4, 3.0, 96.0f64),
    ] {
        assert_mean(
            z.iter().map(|z| z.powi(power)),
            expected,
            variance.sqrt(),
            "normal moment",
        );
    }
}

/// On the sphere each coordinate has mean 0 and mean square 1/3, products of two have mean 0.
#[test]
fn unit_vectors() {
    let mut stream = Stream::new(1, "vector", 0);
    let v: Vec<DVec3> = (0..DRAWS).map(|_| stream.unit_vector()).collect();
    // A few roundings of size 2^-53.
    assert!(v.iter().all(|v| (v.length() - 1.0).abs() < 1e-15));
    for axis in 0..3 {
        let other = (axis + 1) % 3;
        assert_mean(
            v.iter().map(|v| v[axis]),
            0.0,
            (1.0f64 / 3.0).sqrt(),
            "coordinate",
        );
        // <x^4> = 1/5, <x^2 y^2> = 1/15.
        let spread = (1.0f64 / 5.0 - 1.0 / 9.0).sqrt();
        assert_mean(
            v.iter().map(|v| v[axis] * v[axis]),
            1.0 / 3.0,
            spread,
            "square",
        );
        assert_mean(
            v.iter().map(|v| v[axis] * v[other]),
            0.0,
            (1.0f64 / 15.0).sqrt(),
            "product",
        );
    }
}

/// A uniform rotation takes every axis to a uniform direction, and its angle has the density (1 - cos a)/pi, so
/// <cos a> = -1/2 and <cos^2 a> = 1/2.
#[test]
fn unit_quaternions() {
    let mut stream = Stream::new(1, "rotation", 0);
    let q: Vec<DQuat> = (0..DRAWS).map(|_| stream.unit_quaternion()).collect();
    assert!(q.iter().all(|q| (q.length() - 1.0).abs() < 1e-15));
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for component in 0..3 {
            assert_mean(
                q.iter().map(|q| (*q * axis)[component]),
                0.0,
                (1.0f64 / 3.0).sqrt(),
                "axis",
            );
        }
    }
    assert_mean(
        q.iter().map(|q| 2.0 * q.w * q.w - 1.0),
        -0.5,
        0.5,
        "cosine of the angle",
    );
}
