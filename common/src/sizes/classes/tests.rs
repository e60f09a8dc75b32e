//! Closed forms, the reference data, and what is no class.

use super::*;
use crate::reference_data::shared;
use crate::scene::Weighting::{Area, Length, Number, Volume};
use crate::sizes::SizeDistribution;
use crate::sizes::table::{self, Content, Options, SizeKind};

fn read(name: &str, per_metre: f64, kind: &str) -> Option<SizeDistribution> {
    let path = shared("data/shapes/psd")?.join(name);
    let options = Options {
        size: Some(SizeKind::Radius),
        per_metre: Some(per_metre),
        values: table::parse_type(kind).ok(),
        mercury: true,
        ..Options::default()
    };
    match table::read_content(&path, &options) {
        Ok(Content::Table(table)) => Some(SizeDistribution::from_classes(
            table.classes,
            table.weighting,
        )),
        other => panic!("{other:?}"),
    }
}

fn assert_digits(got: f64, expected: f64, what: &str) {
    // Expected values are printed with nine digits.
    assert!(
        (got / expected - 1.0).abs() < 5.1e-9,
        "{what}: {got} {expected}"
    );
}

#[test]
fn the_reference_data_have_the_quantiles_of_the_index() {
    let Some(apapm) = read("APAPM.csv", 1.0, "cumulative-number") else {
        return;
    };
    let radius = |w, u| 0.5 * apapm.by(w).quantile(u);
    for (weighting, expected) in [
        (Number, [1.016_179_91e-3, 1.822_554_37e-3, 2.953_337_52e-3]),
        (Length, [1.142_799_70e-3, 2.178_184_55e-3, 3.308_449_60e-3]),
        (Area, [1.396_829_48e-3, 2.471_785_13e-3, 3.633_917_19e-3]),
        (Volume, [1.772_950_24e-3, 2.740_436_00e-3, 3.934_069_35e-3]),
    ] {
        for (u, expected) in [0.1, 0.5, 0.9].into_iter().zip(expected) {
            // The index lists D = 2 r.
            assert_digits(
                2.0 * radius(weighting, u),
                expected,
                &format!("{weighting:?} {u}"),
            );
        }
    }
    let moment = |j: i32| apapm.moment(j) / 2.0_f64.powi(j);
    assert_digits(moment(1), 9.523_131_67e-4, "<r>");
    assert_digits(moment(2), 1.055_531_52e-6, "<r^2>");
    assert_digits(moment(3), 1.330_663_49e-9, "<r^3>");
    assert_digits(apapm.moment(3) / apapm.moment(2), 2.521_314_55e-3, "D[3,2]");
    assert_digits(apapm.moment(4) / apapm.moment(3), 2.800_886_48e-3, "D[4,3]");
    assert_digits(apapm.moment(3).cbrt(), 2.199_814_58e-3, "D[3,0]");

    let Some(lactose) = read("CVDFLactose.csv", 1e6, "cumulative-volume") else {
        return;
    };
    for (weighting, expected) in [
        (Number, [1.083_907_28e-5, 2.561_977_59e-5, 9.599_086_62e-5]),
        (Volume, [7.449_036_98e-5, 1.496_556_77e-4, 2.866_221_71e-4]),
    ] {
        for (u, expected) in [0.1, 0.5, 0.9].into_iter().zip(expected) {
            let d = lactose.by(weighting).quantile(u);
            assert_digits(d, expected, &format!("{weighting:?} {u}"));
        }
    }
    assert_digits(lactose.moment(1) / 2.0, 2.096_937_53e-5, "<r>");
    assert_digits(lactose.moment(2) / 4.0, 8.421_547_48e-10, "<r^2>");
    assert_digits(lactose.moment(3) / 8.0, 5.234_426_16e-14, "<r^3>");
}

#[test]
fn models_inside_a_class_have_their_closed_forms() {
    // One class [1, 2] of volume. n_i = p_i <d^-3>: (a+b)/(2 a^2 b^2) for constant volume density.
    let of = |model| Classes::new(&[1.0, 2.0], &[1.0], Volume, model).expect("a class");
    // <d> by number of q_0 ~ d^-3: (1/1 - 1/2) / ((1 - 1/4) / 2) = 4/3.
    let uniform = of(ClassModel::Uniform(Volume));
    assert!((uniform.moment(1) - 4.0 / 3.0).abs() < 1e-15);
    assert!((uniform.moment(3) - 8.0 / 3.0).abs() < 1e-15 * 4.0);
    // q_3 ~ 1/d, q_0 ~ d^-4: <d> = ((1 - 1/4) / 2) / ((1 - 1/8) / 3) = 9/7; the volume median is sqrt(2).
    let log = of(ClassModel::LogUniform(Volume));
    assert!((log.moment(1) - 9.0 / 7.0).abs() < 1e-15 * 4.0);
    let median = log.by(Volume).quantile(0.5);
    assert!((median - std::f64::consts::SQRT_2).abs() < 1e-15 * 4.0);
}

#[test]
fn empty_classes_at_the_ends_go_and_gaps_stay() {
    let edges = [1.0, 2.0, 3.0, 4.0, 5.0];
    let classes = Classes::new(&edges, &[0.0, 1.0, 0.0, 1.0], Number, ClassModel::default());
    let classes = classes.expect("classes");
    assert_eq!(classes.edges(), [2.0, 3.0, 4.0, 5.0]);
    assert_eq!(classes.shares(Number), [0.5, 0.0, 0.5]);
    let view = classes.by(Number);
    assert_eq!(view.quantile(0.5), 3.0);
    assert_eq!(view.cdf(3.5), 0.5);
    assert_eq!(view.density(3.5), 0.0);
}

#[test]
fn what_is_no_class_is_refused_with_its_place() {
    let new = |edges: &[f64], shares: &[f64]| {
        let classes = Classes::new(edges, shares, Volume, ClassModel::Uniform(Volume));
        classes.expect_err("no classes").to_string()
    };
    assert!(new(&[1.0], &[]).contains("1 diameters bound no 0 classes"));
    assert!(new(&[2.0, 1.0], &[1.0]).starts_with("diameter 2 of the list is 1"));
    assert!(new(&[-1.0, 1.0], &[1.0]).starts_with("diameter 1 of the list is -1"));
    assert!(new(&[1.0, f64::NAN], &[1.0]).starts_with("diameter 2 of the list is NaN"));
    assert!(new(&[1.0, 2.0], &[-0.5]).starts_with("share 1 of the list is -0.5"));
    assert_eq!(new(&[1.0, 2.0], &[0.0]), "all shares are 0");
    assert!(new(&[0.0, 2.0], &[1.0]).contains("\"volume-uniform\" means infinitely many"));
}
