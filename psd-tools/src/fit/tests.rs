//! Known parameters come back within their stated errors.

use std::path::Path;

use mercury_common::random::Stream;
use mercury_common::sizes::table::{self, Content, Options};

use super::*;
use crate::sample::Sample;
use crate::test_support::uniform_p;

/// A law with its searched parameters.
fn known(word: &str) -> (Family, Vec<f64>) {
    let family: Family = word.parse().expect("a family");
    let theta = match word {
        "lognormal" => vec![0.1, (0.3_f64).ln()],
        "normal" => vec![1.0, (0.15_f64).ln()],
        "rosin-rammler" => vec![0.0, (3.5_f64).ln()],
        "ggs" => vec![0.4, (2.0_f64).ln()],
        "two-lognormal" => vec![-0.4, -0.6, (0.12_f64).ln(), 0.3, (0.15_f64).ln()],
        "two-normal" => vec![0.0, 0.7, (0.08_f64).ln(), 1.4, (0.15_f64).ln()],
        _ => vec![0.3, -0.5, (9.0_f64).ln(), 0.4, (7.0_f64).ln()],
    };
    (family, theta)
}

fn empty(edges: &[f64], number: f64) -> Data {
    let rows: String = edges
        .iter()
        .enumerate()
        .map(|(i, edge)| format!("{edge},{}\n", i as f64 / (edges.len() - 1) as f64))
        .collect();
    let text = format!("diameter [m],cumulative number\n{rows}");
    match table::parse(Path::new("t.csv"), &text, &Options::default()) {
        Ok(Content::Table(table)) => Data::from_table(&table, number).expect("data"),
        other => panic!("{other:?}"),
    }
}

/// The truth in units of m, by the names of the fitted parameters.
fn truth(family: Family, theta: &[f64]) -> Vec<f64> {
    let none = vec![Err(None); theta.len()];
    parameters(family, theta, &none, 1.0, 1.96)
        .iter()
        .map(|p| p.value)
        .collect()
}

/// Share of the 95 % intervals that hold the truth, parameter by parameter.
fn coverage(
    word: &str,
    trials: u64,
    fitted_to: impl Fn(&Law, &mut Stream) -> Data,
) -> Vec<(String, f64)> {
    let (family, theta) = known(word);
    let law = Law::of(family, &theta);
    let truth = truth(family, &theta);
    let mut held = vec![0; truth.len()];
    let mut names = vec![String::new(); truth.len()];
    let mut counted = vec![0; truth.len()];
    for trial in 0..trials {
        let mut stream = Stream::new(trial, "psd coverage", 0);
        let fitted = fit(&fitted_to(&law, &mut stream), family, 0.05).expect("a fit");
        for (i, parameter) in fitted.parameters.iter().enumerate() {
            names[i].clone_from(&parameter.name);
            if let Some([low, high]) = parameter.interval {
                counted[i] += 1;
                held[i] += u64::from(low <= truth[i] && truth[i] <= high);
            }
        }
    }
    let shares = held
        .iter()
        .zip(&counted)
        .map(|(h, c)| *h as f64 / f64::from(*c).max(1.0));
    names.into_iter().zip(shares).collect()
}

fn singles(law: &Law, number: usize, stream: &mut Stream) -> Data {
    let u = |stream: &mut Stream| stream.uniform().max(1e-12);
    let sizes = (0..number).map(|_| law.quantile(u(stream))).collect();
    Data::from_sample(&Sample::new(sizes).expect("sizes")).expect("data")
}

fn edges(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..=count)
        .map(|i| low * (high / low).powf(i as f64 / count as f64))
        .collect()
}

/// 250 trials here, 1000 in the example `coverage`, whose results are in docs/theory. The standard error of a share of 95 % is
/// 1.4 % here; the bounds of the issue (92 ... 98, mixtures 88 ... 99) lie two or more of them away.
#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    for word in ["lognormal", "normal", "rosin-rammler", "ggs"] {
        for (name, share) in coverage(word, 250, |law, stream| singles(law, 300, stream)) {
            let is_end = word == "ggs" && name == "max_diameter";
            assert!(
                is_end || (0.915..=0.985).contains(&share),
                "{word} {name}: {share}"
            );
        }
        let data = empty(&edges(0.2, 3.0, 14), 2000.0);
        for (name, share) in coverage(word, 250, |law, stream| {
            data.drawn(&law.clone().scaled(1.0 / data.unit()), stream)
        }) {
            assert!(
                (0.915..=0.985).contains(&share),
                "{word} in classes {name}: {share}"
            );
        }
    }
}

#[test]
fn intervals_of_mixtures_hold_the_truth() {
    for word in ["two-lognormal", "two-normal", "two-rosin-rammler"] {
        let data = empty(&edges(0.2, 3.0, 24), 3000.0);
        for (name, share) in coverage(word, 100, |law, stream| {
            data.drawn(&law.clone().scaled(1.0 / data.unit()), stream)
        }) {
            assert!((0.87..=1.0).contains(&share), "{word} {name}: {share}");
        }
    }
}

/// The law that made the data has the least BIC of all.
#[test]
fn the_right_family_is_found() {
    for word in ["lognormal", "rosin-rammler", "two-lognormal"] {
        let (family, theta) = known(word);
        let law = Law::of(family, &theta);
        let data = singles(&law, 1500, &mut Stream::new(5, "psd families", 0));
        let best = Family::all()
            .filter_map(|family| fit(&data, family, 0.05).ok())
            .min_by(|a, b| a.bic.total_cmp(&b.bic))
            .expect("a fit");
        assert_eq!(best.family.word(), word);
    }
}

#[test]
fn bootstrap_p_values_are_uniform_under_the_law_and_small_beside_it() {
    let family: Family = "rosin-rammler".parse().expect("a family");
    let (_, theta) = known("rosin-rammler");
    let law = Law::of(family, &theta);
    let p = |seed: u64| {
        let data = singles(&law, 100, &mut Stream::new(seed, "psd bootstrap", 0));
        fit_with_p(&data, family, 0.05, 39, seed)
            .expect("a fit")
            .p
            .expect("a p")
    };
    let list: Vec<f64> = (0..80).map(p).collect();
    // Steps of 1/40: blurred by half of one.
    assert!(uniform_p(&list.iter().map(|p| p - 0.0125).collect::<Vec<_>>()) > 1e-3);
    let (other, theta) = known("two-lognormal");
    let data = singles(
        &Law::of(other, &theta),
        1000,
        &mut Stream::new(1, "psd bootstrap", 0),
    );
    let wrong = fit_with_p(&data, family, 0.05, 99, 1).expect("a fit");
    assert_eq!(wrong.p, Some(0.01));
}

#[test]
fn laws_are_stated_as_scenes_take_them() {
    use mercury_common::scene::parse_psd;
    use mercury_common::sizes::SizeDistribution;
    for word in ["lognormal", "normal", "ggs", "two-normal"] {
        let (family, theta) = known(word);
        let law = Law::of(family, &theta).scaled(1e-3);
        let data = singles(&law, 2000, &mut Stream::new(3, "psd statement", 0));
        let fitted = fit(&data, family, 0.05).expect("a fit");
        let range = [law.quantile(0.001), law.quantile(0.999)];
        let psd =
            parse_psd("fit", &fitted.statement(Some(range)).to_string(), None).expect("a law");
        let sizes = SizeDistribution::from_scene(&psd).expect("sizes");
        // Cut at a thousandth on either side: the median stays within a thousandth's worth of width.
        assert!(
            (sizes.sample_diameter(0.5) / fitted.quantile(0.5) - 1.0).abs() < 5e-3,
            "{word}"
        );
    }
}

#[test]
fn data_that_determine_nothing_are_refused() {
    let family: Family = "two-lognormal".parse().expect("a family");
    let few = Data::from_sample(&Sample::new(vec![1.0, 2.0, 3.0]).expect("sizes")).expect("data");
    let error = fit(&few, family, 0.05).expect_err("too few").to_string();
    assert_eq!(
        error,
        "3 particles do not determine the 5 parameters of two-lognormal"
    );
    let one = Sample::new(vec![1.0, 1.0]).expect("sizes");
    assert_eq!(
        Data::from_sample(&one).expect_err("one size"),
        DataError::OneSize
    );
    let classes = empty(&[1.0, 2.0, 3.0], 100.0);
    let error = fit(&classes, family, 0.05)
        .expect_err("too few")
        .to_string();
    assert_eq!(
        error,
        "2 classes with particles do not determine the 5 parameters of two-lognormal"
    );
}

#[test]
fn a_number_is_estimated_where_none_is_known() {
    // Exact shares of a law, rounded to tenths of per cent: as if of very many particles.
    let (family, theta) = known("lognormal");
    let law = Law::of(family, &theta);
    let bounds = edges(0.3, 4.0, 12);
    let rows: String = bounds
        .iter()
        .map(|edge| {
            let share = (law.share(bounds[0], *edge) / law.share(bounds[0], bounds[12]) * 1e3)
                .round()
                / 10.0;
            format!("{edge},{share}\n")
        })
        .collect();
    let text = format!("diameter [m],cumulative volume [%]\n{rows}");
    let Ok(Content::Table(table)) = table::parse(Path::new("t.csv"), &text, &Options::default())
    else {
        panic!("no table")
    };
    let data = Data::from_table(&table, 1e4)
        .expect("data")
        .with_estimated_number(&[family])
        .expect("a fit");
    assert!(data.number() > 5e3, "{}", data.number());
    let fitted = fit(&data, family, 0.05).expect("a fit");
    assert!((fitted.parameters[1].value - 0.3).abs() < 0.01);
    assert!(Data::from_table(&table, 0.5).is_err());
}

/// A sieving whose second peak lies within one class of 0.5 mm: the data do not determine its width, and an error larger than the
/// value would be meaningless. The other parameters are known.
#[test]
fn a_width_within_one_class_is_not_determined() {
    let rows = "3.0,0\n3.5,8\n4.0,31\n4.5,63\n5.0,88\n5.6,100\n";
    let text = format!("diameter [mm],cumulative volume [%]\n{rows}");
    let Ok(Content::Table(table)) = table::parse(Path::new("t.csv"), &text, &Options::default())
    else {
        panic!("no table")
    };
    let data = Data::from_table(&table, 2000.0).expect("data");
    for (word, width) in [
        ("two-normal", "standard_deviation 2"),
        ("two-lognormal", "sigma 2"),
    ] {
        let fitted = fit(&data, word.parse().expect("a family"), 0.05).expect("a fit");
        for parameter in &fitted.parameters {
            let is_known = parameter.error.is_some();
            assert_eq!(is_known, parameter.name != width, "{parameter:?}");
            assert_eq!(parameter.lack.is_none(), is_known, "{parameter:?}");
            if let Some(error) = parameter.error {
                assert!(error < parameter.value, "{parameter:?}");
            }
        }
        let lack = fitted.parameters.last().and_then(|p| p.lack.clone());
        let lack = lack.expect("a reason");
        assert!(
            lack.starts_with("not determined by these data: a hundred times smaller"),
            "{lack}"
        );
        // z^2/2 of 95 %.
        assert!(lack.ends_with("falls by 1.92"), "{lack}");
    }
    let single = fit(&data, "lognormal".parse().expect("a family"), 0.05).expect("a fit");
    assert!(single.parameters.iter().all(|p| p.lack.is_none()));
}

/// Two parts fitted to one law: the second one can be anything, and its parameters are marked so.
#[test]
fn a_part_that_is_not_needed_is_not_determined() {
    let (family, theta) = known("lognormal");
    let law = Law::of(family, &theta);
    let data = empty(&edges(0.2, 5.0, 20), 1e4);
    // The law's own shares: no sample could be more like it.
    let data = match data.kind() {
        data::Kind::Classes { edges, .. } => {
            let law = law.scaled(1.0 / data.unit());
            let counts = (edges.windows(2)).map(|class| 1e4 * law.share(class[0], class[1]));
            data.with_kind(data::Kind::Classes {
                edges: edges.clone(),
                counts: counts.collect(),
            })
        }
        data::Kind::Sizes(_) => panic!("classes"),
    };
    let two = fit(&data, "two-lognormal".parse().expect("a family"), 0.05).expect("a fit");
    assert!(
        two.parameters.iter().all(|p| p.lack.is_some()),
        "{:#?}",
        two.parameters
    );
}

/// Six particles, or five: one law will do, or a part on one of them makes the likelihood as large as one likes. Two groups of three are
/// two groups.
#[test]
fn few_particles_determine_no_mixture() {
    let of = |sizes: &[f64]| {
        Data::from_sample(&Sample::new(sizes.to_vec()).expect("sizes")).expect("data")
    };
    let family: Family = "two-lognormal".parse().expect("a family");
    let one_will_do = fit(&of(&[1.0, 1.3, 1.45, 1.9, 2.4, 3.1]), family, 0.05).expect("a fit");
    for parameter in &one_will_do.parameters {
        assert!(parameter.error.is_none(), "{parameter:?}");
        let lack = parameter.lack.as_deref().expect("a reason");
        assert!(lack.starts_with("not determined by these data: "), "{lack}");
    }
    let error = fit(&of(&[1.0, 1.0001, 1.9, 2.4, 3.1, 4.0]), family, 0.05).expect_err("unbounded");
    assert_eq!(
        error.to_string(),
        "two-lognormal is not determined by 6 particles: the likelihood grows without bound as one part of it closes in on a few of them"
    );
    let groups = fit(&of(&[1.0, 1.01, 1.03, 3.0, 3.1, 3.25]), family, 0.05).expect("a fit");
    assert!(groups.parameters.iter().all(|p| p.lack.is_none()));
    assert!((groups.parameters[0].value - 0.5).abs() < 1e-3);
}
