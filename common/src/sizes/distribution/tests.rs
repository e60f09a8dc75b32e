//! All weightings of all forms against quadrature and each other; the distributions that a scene describes.

use super::*;
use crate::scene::{Files, parse_psd, parse_scene};
use crate::sizes::{ClassModel, changes};
use proptest::prelude::*;

fn law(text: &str) -> SizeDistribution {
    let psd = parse_psd("law.toml", text, None).expect("a law");
    SizeDistribution::from_scene(&psd).expect("sizes")
}

/// One of each family in each weighting that it can have, classes in each model, a mixture.
fn all() -> Vec<SizeDistribution> {
    let mut all = Vec::new();
    for weighting in ["number", "length", "area", "volume"] {
        for keys in [
            "kind = \"uniform\"\nmin_diameter = 1e-3\nmax_diameter = 3e-3",
            "kind = \"normal\"\nmean_diameter = 2e-3\nstandard_deviation = 2e-4",
            "kind = \"lognormal\"\nmedian_diameter = 3e-3\nsigma = 0.2",
            "kind = \"rosin-rammler\"\nd63 = 1e-3\nexponent = 3.7\ncut = [0.01, 0.99]",
            "kind = \"ggs\"\nmax_diameter = 1e-3\nexponent = 3.2\ncut = [0.02, 1.0]",
            "kind = \"phi-normal\"\nmedian_diameter = 1e-3\nsigma_phi = 0.4\ncut = [0.1, 0.8]",
            "kind = \"mixture\"\nof = [{ share = 0.3, kind = \"lognormal\", median_diameter = 1e-3, sigma = 0.1 },\n\
             { share = 0.7, kind = \"uniform\", min_diameter = 2e-3, max_diameter = 3e-3 }]",
        ] {
            all.push(law(&format!("{keys}\nweighting = \"{weighting}\"\n")));
        }
        for (model, _) in ClassModel::all() {
            all.push(law(&format!(
                "kind = \"classes\"\ndiameters = [1e-3, 1.5e-3, 2e-3, 4e-3]\nshares = [1.0, 0.0, 2.5]\n\
                 model = \"{model}\"\nweighting = \"{weighting}\"\n"
            )));
        }
    }
    all
}

/// Midpoint rule in ln d, n points in each of the pieces that kinks divide the range into.
fn integral(sizes: &SizeDistribution, f: impl Fn(f64) -> f64) -> f64 {
    let mut ends = vec![sizes.smallest(), sizes.largest()];
    match &sizes.form {
        Form::Classes(classes) => ends.extend(classes.edges()),
        Form::Mixture(parts) => {
            ends.extend(parts.iter().flat_map(|(_, p)| [p.smallest(), p.largest()]));
        }
        Form::Law(_) => {}
    }
    ends.sort_by(f64::total_cmp);
    let n = 4000;
    let mut sum = 0.0;
    for piece in ends.windows(2) {
        let (a, b) = (piece[0].ln(), piece[1].ln());
        for i in 0..n {
            let d = (a + (b - a) * (f64::from(i) + 0.5) / f64::from(n)).exp();
            sum += f(d) * d * (b - a) / f64::from(n);
        }
    }
    sum
}

#[test]
fn densities_and_moments_agree_with_quadrature() {
    for sizes in all() {
        let number = sizes.by(Weighting::Number);
        for weighting in Weighting::ALL {
            let view = sizes.by(weighting);
            // The midpoint rule of 4000 points misses (h^2/24) f''/f, some 1e-6 for the steepest flank here.
            let all = integral(&sizes, |d| view.density(d));
            assert!((all - 1.0).abs() < 2e-6, "{sizes:?} {weighting:?}: {all}");
            // q_k = d^k q_0 / M_k
            let k = i32::from(weighting.power());
            let d = sizes.by(Weighting::Volume).quantile(0.4);
            let expected = d.powi(k) * number.density(d) / sizes.moment(k);
            assert!(
                (view.density(d) / expected - 1.0).abs() < 1e-9,
                "{sizes:?} {weighting:?}: {} {expected}",
                view.density(d)
            );
        }
        for j in [-2, 1, 2, 3, 4, 6] {
            let expected = integral(&sizes, |d| number.density(d) * d.powi(j));
            let moment = sizes.moment(j);
            assert!((moment / expected - 1.0).abs() < 3e-6, "{sizes:?} {j}");
        }
    }
}

#[test]
fn quantiles_invert_shares_in_every_weighting() {
    for sizes in all() {
        for weighting in Weighting::ALL {
            let view = sizes.by(weighting);
            let mut last = 0.0;
            for i in 0..=200 {
                let u = f64::from(i) / 200.0;
                let d = view.quantile(u);
                assert!(d >= last, "{sizes:?}: not increasing at {u}");
                last = d;
                // d is known to round-off; the share changes by d q(d) per unit of ln d, at most 40 here.
                let back = view.cdf(d);
                assert!(
                    (back - u).abs() < 1e-12,
                    "{sizes:?} {weighting:?}: {u} {back}"
                );
            }
            assert_eq!(view.cdf(sizes.smallest() * 0.999), 0.0);
            assert_eq!(view.cdf(sizes.largest()), 1.0);
            assert_eq!(view.density(sizes.largest() * 1.001), 0.0);
        }
    }
}

#[test]
fn statements_read_back_as_the_same_distribution() {
    for sizes in all() {
        let again = law(&sizes.statement().to_string());
        for u in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let (a, b) = (sizes.sample_diameter(u), again.sample_diameter(u));
            assert!((a / b - 1.0).abs() < 1e-13, "{sizes:?} {u}: {a} {b}");
        }
        assert_eq!(sizes.weighting(), again.weighting());
    }
}

#[test]
fn cuts_are_exact_and_say_what_they_removed() {
    for sizes in all() {
        for weighting in Weighting::ALL {
            let (after, effect) = changes::cut(&sizes, weighting, 0.2, 0.9).expect("a cut");
            let (before, view) = (sizes.by(weighting), after.by(weighting));
            for u in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let (a, b) = (view.quantile(u), before.quantile(0.2 + 0.7 * u));
                // Share 1e-12 as in the test of quantiles, over a density of at least 0.01 per ln d away from gaps.
                assert!(
                    (a / b - 1.0).abs() < 1e-9,
                    "{sizes:?} {weighting:?} {u}: {a} {b}"
                );
            }
            let removed = match weighting {
                Weighting::Number => effect.removed_number,
                Weighting::Volume => effect.removed_volume,
                _ => continue,
            };
            assert!(
                (removed - 0.3).abs() < 1e-11,
                "{sizes:?} {weighting:?} {removed}"
            );
        }
    }
}

#[test]
fn scaling_and_squeezing_move_the_quantiles() {
    for sizes in all() {
        let (after, _) = changes::scale(&sizes, 2.5).expect("a factor");
        let (squeezed, effect) =
            changes::squeeze(&sizes, Weighting::Volume, 0.5).expect("a squeeze");
        let median = sizes.by(Weighting::Volume).quantile(0.5);
        for i in 1..10 {
            // Not 0.3: there the mixture by number has a gap.
            let u = f64::from(i) / 10.0 + 0.03;
            let d = sizes.sample_diameter(u);
            assert!((after.sample_diameter(u) / (2.5 * d) - 1.0).abs() < 1e-11);
            // Numbers in classes survive; a law is divided into a thousand, so within one of them. Classes whose
            // number density is not constant are so again, in other bounds: within a class.
            let expected = median + 0.5 * (d - median);
            let tolerance = match sizes.classes().map(Classes::model) {
                None => 2e-3,
                Some(ClassModel::Uniform(Weighting::Number)) => 1e-12,
                Some(_) => 0.1,
            };
            let got = squeezed.sample_diameter(u);
            assert!(
                (got / expected - 1.0).abs() < tolerance,
                "{sizes:?} {u}: {got} {expected}"
            );
        }
        assert_eq!(effect.classes.is_none(), sizes.classes().is_some());
    }
    let wide =
        law("kind = \"uniform\"\nmin_diameter = 1.0\nmax_diameter = 3.0\nweighting = \"number\"");
    let error = changes::squeeze(&wide, Weighting::Number, 3.0).expect_err("below 0");
    assert_eq!(
        error.to_string(),
        "a squeeze by 3 makes the smallest diameter -1 m: choose a factor below 2"
    );
    assert!(changes::scale(&wide, -1.0).is_err());
    assert!(changes::cut(&wide, Weighting::Number, 0.5, 0.5).is_err());
}

#[test]
fn a_mixture_counts_its_shares_in_its_weighting() {
    // Half the volume 1 mm, half 2 mm: 8 small ones for each large one.
    let sizes = law(
        "kind = \"mixture\"\nweighting = \"volume\"\nof = [{ share = 1, kind = \"monodisperse\", diameter = 1e-3 },\n\
         { share = 1, kind = \"monodisperse\", diameter = 2e-3 }]",
    );
    assert!(sizes.has_single_sizes());
    assert!((sizes.number_cdf(1.5e-3) - 8.0 / 9.0).abs() < 1e-15);
    assert!((sizes.by(Weighting::Volume).cdf(1.5e-3) - 0.5).abs() < 1e-15);
    assert_eq!(sizes.sample_diameter(0.8), 1e-3);
    assert_eq!(sizes.sample_diameter(0.9), 2e-3);
    let mean = (8.0 * 1e-3 + 2e-3) / 9.0;
    assert!((sizes.mean_diameter() - mean).abs() < 1e-18);
}

fn requested(psd: &str) -> Result<SizeDistribution, SizeError> {
    let text = format!(
        "[time]\nend = 1.0\nstep = 0.1\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n\
         [output]\ninterval = 0.1\n[materials.m]\ndensity = 1.0\n\
         normal = {{ law = \"linear\", stiffness = 1.0, dissipation = 0.0 }}\n\
         [[insertions]]\nname = \"feed\"\nmaterial = \"m\"\ntotal = {{ full = true }}\n\
         region = {{ shape = \"sphere\", origin = [0, 0, 0], radius = 1 }}\npsd = {psd}\n"
    );
    let path = std::path::Path::new("feed.toml");
    let scene = parse_scene(path, &text, &[], Files::Unchecked).expect("a scene");
    SizeDistribution::from_scene(scene.insertions[0].mixture[0].psd.as_ref().unwrap())
}

/// The mass retained on a sieve and on all larger ones is one minus the mass that passes: 32.5 % stays on 1 mm, 72.5 % on 0.5 mm,
/// and classes of constant number density have the mass of d^4 in them.
#[test]
fn a_lab_sheet_in_a_scene_has_its_median() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cr3.psd.csv");
    let sheet = "Sieve [mm],cumulative retained weight [kg]\n4.75,0\n2.00,0.125\n1.00,0.325\n0.50,0.725\n0.25,0.925\n0.125,1.0\n";
    std::fs::write(&path, sheet).unwrap();
    let sizes = requested(&format!("{{ file = '{}' }}", path.display())).unwrap();
    let median = 1e-3 * (0.5_f64.powi(4) + 0.5625 * (1.0 - 0.5_f64.powi(4))).powf(0.25);
    assert!((sizes.quantile(0.5) / median - 1.0).abs() < 1e-12);
}

#[test]
fn requests_of_a_scene_become_laws() {
    let uniform = requested(
        r#"{ kind = "uniform", min_diameter = 2, max_diameter = 2, weighting = "area" }"#,
    )
    .expect("one size");
    assert!(uniform.has_single_sizes());
    let phi =
        requested(r#"{ kind = "phi-normal", median_diameter = 1e-3, sigma_phi = 0.5, weighting = "volume", cut = [0.1, 0.9] }"#)
            .expect("a lognormal law");
    // One phi is a factor of 2 in diameter; the cut medians coincide.
    let Form::Law(law) = &phi.form else {
        panic!("no law")
    };
    assert_eq!(
        law.law,
        Law::Lognormal {
            median: 1e-3,
            sigma: 0.5 * 2.0_f64.ln()
        }
    );
    assert!((phi.quantile(0.5) / 1e-3 - 1.0).abs() < 1e-15 * 4.0);
    assert_eq!(phi.weighting(), Weighting::Volume);
}

#[test]
fn requests_that_cannot_be_drawn_say_why() {
    let file = requested(r#"{ file = "no-such.psd.csv" }"#).expect_err("a file");
    let message = file.to_string();
    assert!(
        message.starts_with("no-such.psd.csv: the file cannot be read"),
        "{message}"
    );
    let psd = r#"{ kind = "ggs", max_diameter = 1, exponent = 2, weighting = "volume" }"#;
    let improper = requested(psd).expect_err("no number");
    let carets = "^".repeat(psd.len());
    assert_eq!(
        improper.to_string(),
        format!(
            "feed.toml:17:7: insertions.feed.psd: the distribution holds infinitely many particles \
             near d = 0: the exponent is <= 3\n    psd = {psd}\n          {carets}\n\
             help: cut it at quantiles of its weighting, for example cut = [0.01, 0.99]"
        )
    );
}

#[test]
fn laws_in_files_say_what_is_wrong() {
    for (text, message) in [
        ("", "law.toml:1:1: kind: is missing"),
        (
            "kind = \"lognormal\"",
            "law.toml:1:1: weighting: is missing",
        ),
        (
            "kind = \"lognormal\"\nweighting = \"volume\"\nmedian_diameter = -1\nsigma = 1",
            "law.toml:3:19: median_diameter: must be > 0, got -1",
        ),
        (
            "kind = \"mixture\"\nweighting = \"volume\"\nof = []",
            "law.toml:3:6: of: must list at least one distribution",
        ),
        (
            "kind = \"mixture\"\nweighting = \"volume\"\nof = [{ share = 0, kind = \"monodisperse\", diameter = 1 }]",
            "law.toml:3:6: of: the shares must have a sum > 0, it is 0",
        ),
        (
            "kind = \"classes\"\nweighting = \"volume\"\ndiameters = [1, 2]\nshares = [1]\nmodel = \"flat\"",
            "law.toml:5:9: model: there is no model of a class \"flat\"",
        ),
    ] {
        let error = parse_psd("law.toml", text, None).expect_err(text);
        assert!(error.to_string().contains(message), "{error}");
    }
    let text = "kind = \"classes\"\nweighting = \"volume\"\ndiameters = [1, 1]\nshares = [1]";
    let psd = parse_psd("law.toml", text, None).expect("numbers");
    let error = SizeDistribution::from_scene(&psd).expect_err("no class");
    assert!(
        error.to_string().contains("diameter 2 of the list is 1"),
        "{error}"
    );
}

const PART: &str = "{ share = 1, kind = \"monodisperse\", diameter = 1e-3 }";

/// A mixture of grains of 1 mm and of what these files hold.
fn mixture_of(files: &[&str]) -> String {
    let parts = files
        .iter()
        .map(|file| format!(", {{ share = 1, file = \"{file}\" }}"));
    format!(
        "kind = \"mixture\"\nweighting = \"volume\"\nof = [{PART}{}]\n",
        parts.collect::<String>()
    )
}

/// The law `a.toml` of these files.
fn law_of_files(files: &[(&str, String)]) -> Result<SizeDistribution, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let psd = crate::scene::read_psd(&folder.path().join("a.toml")).unwrap();
    let error = |error: SizeError| {
        error
            .to_string()
            .replace(folder.path().to_str().unwrap(), "")
    };
    SizeDistribution::from_scene(&psd).map_err(error)
}

#[test]
fn laws_that_are_made_of_themselves_are_refused_with_the_chain() {
    let chain = |files: &[(&str, String)]| law_of_files(files).expect_err("no end");
    let error = chain(&[("a.toml", mixture_of(&["a.toml"]))]);
    assert!(
        error.starts_with("/a.toml:3:")
            && error.contains("of[1].file: a law of sizes includes itself: a.toml -> a.toml\n"),
        "{error}"
    );
    let error = chain(&[
        ("a.toml", mixture_of(&["b.toml"])),
        ("b.toml", mixture_of(&["./c.toml"])),
        ("c.toml", mixture_of(&["././b.toml"])),
    ]);
    assert!(
        error.starts_with("/./c.toml:3:") && error.contains("b.toml -> c.toml -> b.toml\n"),
        "{error}"
    );
    // Without an end, though no file comes twice.
    let names = ["a.toml", "b.toml", "c.toml", "d.toml", "e.toml", "f.toml"];
    let mut files: Vec<(&str, String)> = (names.windows(2))
        .map(|pair| (pair[0], mixture_of(&[pair[1]])))
        .collect();
    files.push(("f.toml", mixture_of(&[])));
    let error = chain(&files);
    assert!(
        error.contains(
            "more than 4 files deep: a.toml -> b.toml -> c.toml -> d.toml -> e.toml -> f.toml\n"
        ),
        "{error}"
    );
    // Two mixtures of one file, side by side, are no circle.
    let files = [
        ("a.toml", mixture_of(&["b.toml", "b.toml"])),
        ("b.toml", mixture_of(&[])),
    ];
    assert_eq!(law_of_files(&files).unwrap().largest(), 1e-3);
    let many = vec!["c.toml"; 40];
    let files = [
        ("a.toml", mixture_of(&["b.toml"; 40])),
        ("b.toml", mixture_of(&many)),
        ("c.toml", mixture_of(&[])),
    ];
    let error = law_of_files(&files).expect_err("1640 files");
    assert!(
        error.contains("one distribution of more than 1000 files"),
        "{error}"
    );
}

proptest! {
    /// Any classes, in any model: a distribution that ascends, whose quantiles and shares invert each other.
    #[test]
    fn random_classes_are_distributions(
        widths in prop::collection::vec(0.01_f64..1.0, 1..12),
        shares in prop::collection::vec(0.0_f64..1.0, 12),
        model in 0..8_usize,
        measured in 0..4_usize,
        u in 0.0_f64..1.0,
    ) {
        let mut edges = vec![1e-4];
        for width in &widths {
            edges.push(edges[edges.len() - 1] * (1.0 + width));
        }
        let shares = &shares[..widths.len()];
        prop_assume!(shares.iter().any(|&share| share > 1e-3));
        let (_, model) = ClassModel::all().nth(model).unwrap();
        let measured = Weighting::ALL[measured];
        let classes = Classes::new(&edges, shares, measured, model).unwrap();
        // Round trip over all weightings.
        let sum: f64 = shares.iter().sum();
        let back = classes.shares(measured);
        let first = shares.iter().position(|&s| s > 0.0).unwrap();
        for (index, share) in back.iter().enumerate() {
            prop_assert!((share - shares[first + index] / sum).abs() < 1e-13);
        }
        for other in Weighting::ALL {
            let again = Classes::new(classes.edges(), &classes.shares(other), other, model).unwrap();
            for (a, b) in again.shares(measured).iter().zip(&back) {
                prop_assert!((a - b).abs() < 1e-12);
            }
            let view = SizeDistribution::from_classes(classes.clone(), measured).by(other);
            let d = view.quantile(u);
            prop_assert!((view.cdf(d) - u).abs() < 1e-11, "{} {}", view.cdf(d), u);
        }
    }
}
