use proptest::prelude::*;
use roxmltree::{Document, Node};

use super::*;
use crate::ColourMap;

fn texts(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).expect("well-formed SVG");
    let texts = document
        .descendants()
        .filter(|node| node.has_tag_name("text"));
    texts
        .filter_map(|node| node.text().map(str::to_owned))
        .collect()
}

/// The lines of a colour, as lists of places.
fn lines(svg: &str, hue: Hue) -> Vec<Vec<(f64, f64)>> {
    let document = Document::parse(svg).unwrap();
    let of_colour = |node: &Node| {
        node.has_tag_name("polyline") && node.attribute("stroke") == Some(&hue.colour().hex())
    };
    let places = |node: Node| -> Vec<(f64, f64)> {
        let points = node.attribute("points").unwrap();
        let pairs = points.split(' ').map(|pair| pair.split_once(',').unwrap());
        pairs
            .map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap()))
            .collect()
    };
    document
        .descendants()
        .filter(of_colour)
        .map(places)
        .collect()
}

fn plain(series: Series) -> Chart {
    Chart::new("", Axis::linear("x", ""), Axis::linear("y", "")).with(series)
}

fn svg(chart: Chart) -> String {
    ChartPage::of(chart).svg().unwrap()
}

#[test]
fn a_chart_says_what_it_shows() {
    let line = |factor: f64| {
        (0..5)
            .map(|k| (1e-3 * f64::from(k), factor * f64::from(k)))
            .collect()
    };
    let chart = Chart::new(
        "Fall",
        Axis::linear("time", "s"),
        Axis::linear("height", "m"),
    )
    .with(Series::line("first", line(0.01)))
    .with(Series::line("second", line(0.02)).about("from below"))
    .note("a\nb", Place::LowerRight);
    let text = ChartPage::of(chart.clone()).svg().unwrap();
    let all = texts(&text);
    for expected in [
        "Fall",
        "time (ms)",
        "height (mm)",
        "first",
        "second",
        "from below",
        "a",
        "b",
        "0",
        "4",
        "80",
    ] {
        assert!(
            all.iter().any(|text| text == expected),
            "{expected} in {all:?}"
        );
    }
    // Both lines and their samples in the legend; the second is dashed.
    assert_eq!(lines(&text, Hue::Blue).len(), 2);
    assert_eq!(lines(&text, Hue::Vermillion).len(), 2);
    assert_eq!(text.matches("stroke-dasharray").count(), 2);
    assert_eq!(
        text,
        ChartPage::of(chart).svg().unwrap(),
        "the same data, the same bytes"
    );
}

#[test]
fn pixels_are_two_to_a_point() {
    let page =
        ChartPage::of(plain(Series::line("", vec![(0.0, 0.0), (1.0, 1.0)]))).size(300.5, 200.0);
    let image = page.image().unwrap();
    assert_eq!((image.width, image.height), (601, 400));
    assert_eq!(image.pixel(0, 0), [255; 4]);
    assert_eq!(image.rgba, page.image().unwrap().rgba);
}

#[test]
fn writes_both_files_beside_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let page = ChartPage::of(plain(Series::line("", vec![(0.0, 0.0), (1.0, 1.0)])));
    // The stem has a dot that no ending may eat.
    page.write(&folder.path().join("run.energy")).unwrap();
    for ending in ["svg", "png"] {
        assert!(folder.path().join(format!("run.energy.{ending}")).exists());
    }
    let error = page
        .write_svg(&folder.path().join("no/such.svg"))
        .unwrap_err();
    assert!(error.to_string().contains("such.svg"), "{error}");
}

#[test]
fn logarithmic_numbers() {
    let labels = |low: f64, high: f64| {
        let x = Axis::log("x", "").within(low, high);
        let chart = Chart::new("", x, Axis::linear("", "").within(0.1, 0.2));
        // The numbers of x come first.
        let all = texts(&svg(
            chart.with(Series::line("", vec![(low, 0.15), (high, 0.15)]))
        ));
        all.into_iter()
            .filter(|text| !text.starts_with("0.") && text != "x")
            .collect::<Vec<_>>()
    };
    assert_eq!(labels(1.0, 1000.0)[..4], ["1", "10", "100", "1000"]);
    assert_eq!(
        labels(1e-12, 1e-8)[..5],
        ["10⁻¹²", "10⁻¹¹", "10⁻¹⁰", "10⁻⁹", "10⁻⁸"]
    );
    assert_eq!(labels(1.0, 20.0)[..6], ["1", "2", "3", "5", "10", "20"]);
    assert_eq!(labels(1.0, 1.4)[..3], ["1.0", "1.1", "1.2"]);
}

#[test]
fn sizes_on_a_logarithmic_axis_have_the_unit_of_the_lab() {
    let sizes = vec![(6e-5, 0.1), (9e-4, 0.9)];
    let chart = Chart::new("", Axis::log("diameter", "m"), Axis::probability("share"));
    let all = texts(&svg(chart.with(Series::points("", sizes))));
    for expected in ["diameter (µm)", "100", "500", "share (%)", "10", "50", "90"] {
        assert!(
            all.iter().any(|text| text == expected),
            "{expected} in {all:?}"
        );
    }
}

/// The largest distance of a line's places from the straight line through its ends (points).
fn bend(line: &[(f64, f64)]) -> f64 {
    let ((x0, y0), (x1, y1)) = (line[0], line[line.len() - 1]);
    let length = (x1 - x0).hypot(y1 - y0);
    line.iter()
        .map(|(x, y)| ((x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)).abs() / length)
        .fold(0.0, f64::max)
}

#[test]
fn distributions_are_straight_on_their_own_paper() {
    let sizes = || (1..100).map(|k| 1e-5 * f64::from(k));
    let normal = sizes().map(|d| {
        (
            d,
            mercury_common::normal::normal_cdf(libm::log(d / 2e-4) / 0.5),
        )
    });
    let weibull = sizes().map(|d| (d, 1.0 - libm::exp(-libm::pow(d / 2e-4, 1.7))));
    for (points, y) in [
        (
            normal.collect(),
            Axis::probability("share").within(0.001, 0.999),
        ),
        (
            weibull.collect(),
            Axis::rosin_rammler("share").within(0.001, 0.999),
        ),
    ] {
        let chart = Chart::new("", Axis::log("d", "m"), y);
        let text = svg(chart.with(Series::line("", points)));
        let all = lines(&text, Hue::Blue);
        assert_eq!(all.len(), 1);
        // Positions are compared to a fiftieth of a point.
        assert!(bend(&all[0]) < 0.05, "{}", bend(&all[0]));
    }
}

#[test]
fn values_that_are_missing_break_the_line_and_are_counted() {
    let points = (0..10).map(|k| (f64::from(k), if k == 4 { f64::NAN } else { f64::from(k) }));
    let text = svg(plain(Series::line("", points.collect())));
    assert_eq!(lines(&text, Hue::Blue).len(), 2);
    let said = "1 of 10 points not drawn: without a value";
    assert!(
        texts(&text).iter().any(|text| text == said),
        "{:?}",
        texts(&text)
    );
    // Zero has no logarithm.
    let chart = Chart::new("", Axis::linear("t", "s"), Axis::log("E", "J"));
    let text = svg(chart.with(Series::line("", vec![(0.0, 0.0), (1.0, 1.0), (2.0, 1e-3)])));
    assert!(
        texts(&text)
            .iter()
            .any(|text| text == "1 of 3 points not drawn: at 0 or less on a log axis")
    );
    let chart = Chart::new("", Axis::linear("t", "s"), Axis::log("E", "J"));
    let odd = vec![(0.0, -1.0), (1.0, 1.0), (2.0, f64::NAN), (3.0, 0.0)];
    let text = svg(chart.with(Series::line("", odd)));
    let said = "3 of 4 points not drawn: 1 without a value, 2 at 0 or less on a log axis";
    assert!(
        texts(&text).iter().any(|text| text == said),
        "{:?}",
        texts(&text)
    );
    let chart = Chart::new("", Axis::linear("d", "m"), Axis::probability("share"));
    let text = svg(chart.with(Series::line("", vec![(0.0, 0.2), (1.0, 0.5), (2.0, 1.2)])));
    let said = "1 of 3 points not drawn: beyond 0 to 100 %";
    assert!(
        texts(&text).iter().any(|text| text == said),
        "{:?}",
        texts(&text)
    );
}

#[test]
fn a_chart_without_values_says_so() {
    for points in [vec![], vec![(f64::NAN, 1.0)], vec![(1.0, f64::INFINITY)]] {
        for y in [
            Axis::linear("y", "J"),
            Axis::log("y", "J"),
            Axis::probability("y"),
        ] {
            let chart =
                Chart::new("", Axis::linear("x", "m"), y).with(Series::line("a", points.clone()));
            assert!(texts(&svg(chart)).iter().any(|text| text == "no data"));
        }
    }
}

#[test]
fn a_band_has_the_colour_of_its_line_and_lets_it_show() {
    let along = |shift: f64| {
        (0..5)
            .map(|k| (f64::from(k), shift + f64::from(k)))
            .collect::<Vec<_>>()
    };
    let chart = plain(Series::line("a", along(0.0)))
        .with(Series::line("b", along(4.0)))
        .with(Series::band("b ± 1", along(3.0), along(5.0)));
    let text = svg(chart);
    let document = Document::parse(&text).unwrap();
    let band = document.descendants().find(|node| {
        node.has_tag_name("polygon")
            && node.attribute("fill") == Some(&Hue::Vermillion.colour().hex())
    });
    let band = band.expect("a band in the colour of the second line");
    assert_eq!(band.attribute("fill-opacity"), Some("0.2"));
    // Five points there and five back, none of them cut away.
    assert_eq!(band.attribute("points").unwrap().split(' ').count(), 10);
    let (band, line) = (text.find("<polygon").unwrap(), text.find("<polyline fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\" stroke=\"#d55e00\"").unwrap());
    assert!(band < line, "bands lie below lines");
}

#[test]
fn bars_stand_on_zero() {
    let text = svg(plain(Series::bars("", vec![0.0, 1.0, 3.0], vec![2.0, 1.0])));
    let all = lines(&text, Hue::Blue);
    assert_eq!(all.len(), 2);
    let feet: Vec<f64> = all
        .iter()
        .map(|bar| bar.iter().map(|p| p.1).fold(f64::MIN, f64::max))
        .collect();
    assert!((feet[0] - feet[1]).abs() < 0.05);
    let height = |bar: &[(f64, f64)]| feet[0] - bar.iter().map(|p| p.1).fold(f64::MAX, f64::min);
    let width = |bar: &[(f64, f64)]| (bar[2].0 - bar[0].0).abs();
    assert!((height(&all[0]) - 2.0 * height(&all[1])).abs() < 0.1);
    assert!((2.0 * width(&all[0]) - width(&all[1])).abs() < 0.1);
}

fn grid(values: Vec<f64>) -> HeatMap {
    HeatMap {
        x_edges: vec![0.0, 1.0, 2.0, 3.0],
        y_edges: vec![0.0, 1.0, 2.0],
        values,
        name: "pressure".into(),
        unit: "Pa".into(),
        map: ColourMap::Viridis,
        range: Some((0.0, 4000.0)),
        centred: false,
    }
}

#[test]
fn a_heat_map_has_a_bar_and_leaves_empty_cells_free() {
    let text = svg(plain(Series::heat(grid(vec![
        0.0,
        0.0,
        4e3,
        f64::NAN,
        2e3,
        9e3,
    ]))));
    let document = Document::parse(&text).unwrap();
    let group = document
        .descendants()
        .find(|node| node.attribute("shape-rendering") == Some("crispEdges"));
    let fills: Vec<_> = group
        .unwrap()
        .children()
        .filter_map(|node| node.attribute("fill"))
        .collect();
    let colour = |share| ColourMap::Viridis.colour(share).hex();
    // Two equal neighbours are one rectangle; beyond the bar is its end.
    assert_eq!(fills, [colour(0.0), colour(1.0), colour(0.5), colour(1.0)]);
    let all = texts(&text);
    assert!(all.iter().any(|text| text == "pressure (kPa)"), "{all:?}");
}

/// The cells of a chart to scale are squares at their edges, whichever side has space to spare.
#[test]
fn a_chart_to_scale_has_equal_lengths() {
    for (width, height) in [(700.0, 300.0), (300.0, 700.0)] {
        for to_scale in [false, true] {
            let heat = grid(vec![1e3, 2e3, 3e3, 3e2, 2e2, 1e2]);
            let chart = Chart {
                to_scale,
                ..Chart::new("", Axis::linear("x", "m"), Axis::linear("z", "m"))
            };
            let page = ChartPage::of(chart.with(Series::heat(heat))).size(width, height);
            let text = page.svg().unwrap();
            let document = Document::parse(&text).unwrap();
            let group = document
                .descendants()
                .find(|node| node.attribute("shape-rendering") == Some("crispEdges"));
            let cells: Vec<_> = group.unwrap().children().collect();
            let first = cells.iter().find(|node| node.is_element()).unwrap();
            let side = |name: &str| first.attribute(name).unwrap().parse::<f64>().unwrap();
            let (wide, high) = (side("width"), side("height"));
            assert_eq!((wide - high).abs() < 0.2, to_scale, "{wide} x {high}");
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_an_error_that_says_why() {
    let two = vec![(0.0, 0.0), (1.0, 1.0)];
    let page = |series| ChartPage::of(plain(series));
    let with_x = |x: Axis| ChartPage::of(Chart::new("", x, Axis::linear("y", "")));
    let heat = |values| page(Series::heat(grid(values)));
    for (page, said) in [
        (
            page(Series::points_with_errors(
                "a",
                two.clone(),
                vec![(0.0, 0.0)],
            )),
            "series \"a\" has 2 points and 1 errors",
        ),
        (
            page(Series::band("b", two.clone(), vec![])),
            "2 points on one side of the band and 0 on the other",
        ),
        (
            page(Series::bars("c", vec![0.0, 1.0], vec![1.0, 2.0])),
            "2 edges for 2 bars, expected one more",
        ),
        (
            page(Series::bars("c", vec![1.0, 0.0], vec![1.0])),
            "edges of bars that do not rise",
        ),
        (
            page(Series::line("d", two.clone()).width(0.0)),
            "lines 0 points wide",
        ),
        (heat(vec![1.0]), "1 values for 3 x 2 cells"),
        (
            with_x(Axis::linear("x", "m").within(1.0, 1.0)),
            "\"x\" cannot go from 1 to 1: expected two rising numbers",
        ),
        (
            with_x(Axis::log("x", "m").within(0.0, 1.0)),
            "expected two rising positive numbers",
        ),
        (
            with_x(Axis::probability("x").within(0.0, 0.5)),
            "expected two rising shares between 0 and 1",
        ),
        (
            page(Series::line("", two.clone())).size(f64::NAN, 200.0),
            "NaN x 200 points large",
        ),
        (
            page(Series::line("", two.clone())).size(100.0, 100.0),
            "make it larger",
        ),
        (ChartPage::new("", 1, vec![]), "has no charts"),
        (
            ChartPage {
                row_shares: vec![1.0, 0.0],
                ..page(Series::line("", two))
            },
            "needs 1 positive row_shares",
        ),
    ] {
        let error = page.svg().unwrap_err().to_string();
        assert!(error.contains(said), "{error:?} should say {said:?}");
    }
}

#[test]
fn the_legend_keeps_off_the_lines() {
    // Full in all corners: beside the chart.
    let cross = vec![(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)];
    let crossed = svg(plain(Series::line("crossed", cross)));
    let rising = svg(plain(Series::line("rising", vec![(0.0, 0.0), (1.0, 1.0)])));
    let place = |svg: &str, name: &str| {
        let document = Document::parse(svg).unwrap();
        let text = document
            .descendants()
            .find(|node| node.text() == Some(name) && node.has_tag_name("text"));
        let text = text.unwrap();
        let at = |key| text.attribute(key).unwrap().parse::<f64>().unwrap();
        (at("x"), at("y"))
    };
    assert!(place(&crossed, "crossed").0 > 500.0);
    let (x, y) = place(&rising, "rising");
    assert!(
        x < 200.0 && y < 100.0,
        "{x} {y}: the upper left corner is free"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn no_number_panics(bits in prop::collection::vec(any::<(u64, u64)>(), 0..20), scales in (0usize..4, 0usize..4)) {
        let points: Vec<(f64, f64)> = bits.iter().map(|(x, y)| (f64::from_bits(*x), f64::from_bits(*y))).collect();
        let scale = [Scale::Linear, Scale::Log, Scale::Probability, Scale::RosinRammler];
        let axis = |k: usize| Axis { scale: scale[k], ..Axis::linear("a", "m") };
        let upper = points.iter().map(|(x, y)| (*x, 2.0 * y)).collect();
        let chart = Chart::new("", axis(scales.0), axis(scales.1))
            .with(Series::marked_line("l", points.clone()))
            .with(Series::steps("s", points.clone()))
            .with(Series::points_with_errors("p", points.clone(), points.clone()))
            .with(Series::band("b", points, upper));
        let text = ChartPage::of(chart).svg().unwrap();
        prop_assert!(!text.contains("NaN") && !text.contains("inf"));
        Document::parse(&text).unwrap();
    }

    #[test]
    fn numbers_on_an_axis_rise_and_keep_apart(low in 1e-6..0.4f64, factor in 1.01..1e9f64, k in 0usize..4) {
        let scale = [Scale::Linear, Scale::Log, Scale::Probability, Scale::RosinRammler][k];
        let high = if scale.is_share() { (low * factor).min(1.0 - 1e-6) } else { low * factor };
        for across in [true, false] {
            let stretch = super::ticks::Stretch { scale, low, high, length: 300.0, across, lettering: 11.5 };
            let ticks = stretch.ticks();
            let spot = |place: f64| {
                let (a, b) = (scale.place(low).unwrap(), scale.place(high).unwrap());
                300.0 * (place - a) / (b - a)
            };
            let named: Vec<_> = ticks.iter().filter(|tick| !tick.label.is_empty()).collect();
            prop_assert!(named.len() >= 2, "{ticks:?}");
            for pair in named.windows(2) {
                let half = |label: &str| if across { 0.5 * crate::font::width(label, 11.5) } else { 4.2 };
                let gap = spot(pair[1].place) - spot(pair[0].place) - half(&pair[0].label) - half(&pair[1].label);
                prop_assert!(gap > 0.0, "{pair:?} touch by {gap}");
            }
            prop_assert!(ticks.iter().all(|tick| (-0.01..300.01).contains(&spot(tick.place))), "{ticks:?}");
        }
    }
}
