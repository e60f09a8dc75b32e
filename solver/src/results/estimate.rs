//! A result and its error from the rows of one run.

use mercury_common::readable::significant;
use mercury_common::statistics::{Batches, FEWEST_BATCHES, Record, start_up};

use super::values::Row;
use crate::output::summary::ResultEstimate;

/// A value, how well it is known, and a remark on it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measured {
    pub(super) value: f64,
    pub(super) estimate: ResultEstimate,
    pub(super) note: Option<String>,
    /// Difference of the means of both halves of the batches; not a number without an error.
    pub(super) difference: f64,
}

impl Measured {
    /// A value of the last state alone.
    pub(super) fn of_one_state(value: f64) -> Self {
        Self::without_error(
            value,
            "it is of one state: a study with several seeds gives its error",
        )
    }

    /// A value of which one run gives no error, and why.
    pub(super) fn without_error(value: f64, why: &str) -> Self {
        Self {
            value,
            estimate: ResultEstimate {
                why_no_error: Some(why.to_owned()),
                ..ResultEstimate::default()
            },
            note: None,
            difference: f64::NAN,
        }
    }

    /// This error about another value, that of all rows.
    pub(super) fn with_value(mut self, value: f64) -> Self {
        if let Some(interval) = &mut self.estimate.interval {
            *interval = interval.map(|end| end - self.value + value);
        }
        self.value = value;
        self
    }
}

/// A function of means over the rows of a window.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Of {
    /// m0
    Mean,
    /// Of a sample with so many rows, about the value x0: sqrt((m1 - m0^2) n/(n - 1)), m0 of x - x0, m1 of its square.
    Deviation,
    /// m0/m1
    Ratio,
    /// atan2(m1, m0) in degrees.
    Angle,
}

/// Rows of a window, reduced to the records that a function needs.
#[derive(Debug, Clone)]
pub(super) struct Course {
    of: Of,
    records: [Record; 2],
    /// Times of the first and the last row, s.
    times: Option<[f64; 2]>,
}

impl Course {
    fn new(of: Of, rows: impl Iterator<Item = (f64, [f64; 2])>) -> Self {
        let mut course = Self {
            of,
            records: Default::default(),
            times: None,
        };
        for (time, values) in rows {
            for (record, value) in course.records.iter_mut().zip(values) {
                record.add(value);
            }
            course.times = Some([course.times.map_or(time, |[first, _]| first), time]);
        }
        course
    }

    /// Their mean.
    pub(super) fn mean<'a>(rows: impl Iterator<Item = &'a Row>) -> Self {
        Self::new(Of::Mean, rows.map(|row| (row.time, [row.value, 0.0])))
    }

    /// Their standard deviation.
    pub(super) fn deviation<'a>(rows: impl Iterator<Item = &'a Row>) -> Self {
        // About the first value, so that little is lost where the mean is much larger.
        let mut about = None;
        let rows = rows.map(|row| {
            let from_first = row.value - *about.get_or_insert(row.value);
            (row.time, [from_first, from_first * from_first])
        });
        Self::new(Of::Deviation, rows)
    }

    /// The ratio of their mean to that of other rows at the same times.
    pub(super) fn ratio<'a>(rows: impl Iterator<Item = &'a Row>, below: &[Row]) -> Self {
        let both = rows.zip(below);
        let rows = both.map(|(above, below)| (above.time, [above.value, below.value]));
        Self::new(Of::Ratio, rows)
    }

    /// The angle of their mean direction; rows with the components along its zero and at right angles to it.
    pub(super) fn angle<'a>(rows: impl Iterator<Item = &'a (Row, f64)>) -> Self {
        let rows = rows.map(|(along, across)| (along.time, [along.value, *across]));
        Self::new(Of::Angle, rows)
    }

    /// The function of two means over so many rows.
    fn value(&self, [a, b]: [f64; 2], rows: f64) -> f64 {
        match self.of {
            Of::Mean => a,
            Of::Deviation => ((b - a * a).max(0.0) * rows / (rows - 1.0)).sqrt(),
            Of::Ratio => a / b,
            Of::Angle => libm::atan2(b, a).to_degrees(),
        }
    }

    /// The function at each pair of bins, linear about the means of all: the error of the mean of this series is that of the function.
    fn series(&self, bins: [&[f64]; 2], rows: f64) -> Vec<f64> {
        let mean = |bins: &[f64]| bins.iter().sum::<f64>() / bins.len() as f64;
        let [a, b] = bins.map(mean);
        let value = self.value([a, b], rows);
        let both = bins[0].iter().zip(bins[1]);
        let linear = |(x, y): (&f64, &f64)| match self.of {
            Of::Mean => *x,
            // Squares about the mean, over twice the deviation.
            Of::Deviation if value == 0.0 => 0.0,
            Of::Deviation => value + ((y - 2.0 * a * x + a * a) - (b - a * a)) / (2.0 * value),
            Of::Ratio => value + (x - value * y) / b,
            Of::Angle => value + ((a * y - b * x) / (a * a + b * b)).to_degrees(),
        };
        both.map(linear).collect()
    }

    /// Value and error. From a `steady` window the start-up is cut; in one given in numbers it is only reported. `None` without rows.
    pub(super) fn measured(&self, steady: bool) -> Option<Measured> {
        let [begin, end] = self.times?;
        let rows = self.records[0].rows();
        let width = self.records[0].width();
        let bins = self.records.each_ref().map(Record::bins);
        let count = |bins: usize| bins as f64 * width as f64;
        let whole = self.series(bins, count(bins[0].len()));
        let start = start_up(&whole);
        let cut = start.filter(|_| steady).map_or(0, |start| start.cut);
        let kept = bins.map(|bins| &bins[cut..]);
        let kept_rows = count(kept[0].len());
        let mean = |bins: &[f64]| bins.iter().sum::<f64>() / bins.len() as f64;
        let value = self.value(kept.map(mean), kept_rows);
        // Rows are evenly spaced in time.
        let spacing = (end - begin) / (rows.saturating_sub(1).max(1)) as f64;
        let from = begin + count(cut) * spacing;
        let mut estimate = ResultEstimate {
            window: Some([from, end]),
            warm_up: steady.then_some(from - begin),
            steady: start.map(|start| match steady {
                true => start.is_steady,
                false => start.cut == 0,
            }),
            ..ResultEstimate::default()
        };
        let note = start.and_then(|start| match (steady, start.is_steady, start.cut) {
            (_, false, _) => {
                Some("not steady: its rows go one way for more than half of the window".to_owned())
            }
            (false, true, 1..) => Some(format!(
                "the first {} s of the window are start-up: steady.. would leave them out",
                significant(count(start.cut) * spacing, 2)
            )),
            _ => None,
        });
        let mut difference = f64::NAN;
        match Batches::of(&self.series(kept, kept_rows)) {
            Some(batches) => {
                difference = batches.difference_of_halves();
                let known = batches.estimate();
                estimate.error = Some(known.error);
                estimate.interval = Some([value - known.half_width, value + known.half_width]);
                estimate.batches = Some(known.independent);
                if known.error == 0.0 {
                    estimate.why_no_error = Some("the value never changes".to_owned());
                }
            }
            None => {
                let rows = kept[0].len();
                estimate.why_no_error = Some(format!(
                    "{rows} rows lie in its window, and an error needs {FEWEST_BATCHES}"
                ));
            }
        }
        Some(Measured {
            value,
            estimate,
            note,
            difference,
        })
    }
}

#[cfg(test)]
mod tests {
    use mercury_common::random::Stream;

    use super::*;

    /// Correlated rows about a mean of 0 with deviation 1, 0.9 from one to the next.
    fn noise(name: &str, count: usize) -> Vec<f64> {
        let mut stream = Stream::new(7, name, 0);
        let mut y = 0.0;
        let mut next = || {
            y = 0.9 * y + (1.0f64 - 0.81).sqrt() * stream.standard_normal();
            y
        };
        (0..count).map(|_| next()).collect()
    }

    fn rows(values: &[f64]) -> Vec<Row> {
        let row = |(k, value): (usize, &f64)| Row {
            time: 0.5 * k as f64,
            value: *value,
        };
        values.iter().enumerate().map(row).collect()
    }

    /// Errors of functions of means against those of their derivatives. With x = 10 + a and y = 5 + b the errors of the means of a and b, which are independent,
    /// give that of the ratio: R sqrt((e_a/10)^2 + (e_b/5)^2); correlations of one record of 64 batches are of order 1/8, so half of it is the tolerance.
    #[test]
    fn errors_of_functions_follow_from_those_of_means() {
        let [a, b] = ["a", "b"].map(|name| noise(name, 20_000));
        let x = rows(&a.iter().map(|a| 10.0 + a).collect::<Vec<f64>>());
        let y = rows(&b.iter().map(|b| 5.0 + b).collect::<Vec<f64>>());
        let error = |course: Course| course.measured(false).unwrap().estimate.error.unwrap();
        let (e_a, e_b) = (error(Course::mean(x.iter())), error(Course::mean(y.iter())));
        // The error of the mean of n rows of an autoregressive process: sqrt((1 + 0.9)/(1 - 0.9)/n).
        let exact = (19.0f64 / 20_000.0).sqrt();
        assert!((0.5..1.5).contains(&(e_a / exact)), "{e_a} {exact}");
        let expected = 2.0 * (e_a / 10.0).hypot(e_b / 5.0);
        let ratio = Course::ratio(x.iter(), &y);
        let found = error(ratio.clone()) / expected;
        assert!((0.5..1.5).contains(&found), "{found}");
        let value = ratio.measured(false).unwrap().value;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        // Rows that fill no bin are left out: below 32 of 20,000.
        assert!((value - (10.0 + mean(&a)) / (5.0 + mean(&b))).abs() < 1e-2);

        let both: Vec<(Row, f64)> = x.iter().zip(&y).map(|(x, y)| (*x, y.value)).collect();
        let angle = Course::angle(both.iter());
        let expected = ((10.0 * e_b).hypot(5.0 * e_a) / 125.0).to_degrees();
        let found = error(angle.clone()) / expected;
        assert!((0.5..1.5).contains(&found), "{found}");
        let value = angle.measured(false).unwrap().value;
        assert!(
            (value - 0.5f64.atan().to_degrees()).abs() < 5.0 * expected,
            "{value}"
        );

        // Of x^2 of this process, whose correlation falls by 0.81: variance 2, so e(var) = sqrt(2 (1.81/0.19)/n), and half of it for the deviation.
        let deviation = Course::deviation(x.iter()).measured(false).unwrap();
        let exact = 0.5 * (2.0 * 1.81 / 0.19 / 20_000.0f64).sqrt();
        let found = deviation.estimate.error.unwrap() / exact;
        assert!((0.5..1.5).contains(&found), "{found}");
        assert!(
            (deviation.value - 1.0).abs() < 5.0 * exact,
            "{}",
            deviation.value
        );
    }

    /// Share of 1,000 intervals that hold the true value, from 100 correlation times of rows each: 95 % by theory, and 91 to 98 % by specification.
    #[test]
    fn intervals_of_functions_hold_the_true_values() {
        const RUNS: usize = 1000;
        // Sum of the correlations 0.9^|k| over all distances, in rows.
        let correlated: f64 = (1.0 + 0.9) / (1.0 - 0.9);
        let count = (100.0 * correlated) as usize;
        let about = |mean: f64, noise: Vec<f64>| {
            let noise = noise.into_iter().skip(200);
            rows(&noise.map(|y| mean + y).collect::<Vec<_>>())
        };
        let mut inside = [0; 4];
        for run in 0..RUNS {
            let [a, b] = ["a", "b"].map(|name| noise(&format!("{name}{run}"), count + 200));
            // Amounts that come in bursts, half of the time.
            let bursts = a
                .iter()
                .map(|y| f64::from(u8::from(*y > 0.0)) - 1.0)
                .collect();
            let (bursts, a, b) = (about(1.0, bursts), about(10.0, a), about(5.0, b));
            let directions: Vec<(Row, f64)> =
                a.iter().zip(&b).map(|(a, b)| (*a, b.value)).collect();
            let courses = [
                (Course::ratio(a.iter(), &b), 2.0),
                (Course::angle(directions.iter()), 0.5f64.atan().to_degrees()),
                (Course::mean(bursts.iter()), 0.5),
                (Course::deviation(a.iter()), 1.0),
            ];
            for ((course, value), inside) in courses.into_iter().zip(&mut inside) {
                let [low, high] = course.measured(false).unwrap().estimate.interval.unwrap();
                *inside += usize::from((low..=high).contains(&value));
            }
        }
        let shares = inside.map(|inside| 100.0 * inside as f64 / RUNS as f64);
        println!("inside, % of ratio, tilt, rate, std: {shares:?}");
        assert!(
            shares.iter().all(|share| (91.0..=98.0).contains(share)),
            "{shares:?}"
        );
    }

    /// The deviation of few rows is that of a sample, whatever their mean.
    #[test]
    fn a_deviation_does_not_depend_on_the_mean() {
        for shift in [0.0, 1e6] {
            let values = [1.0, 2.0, 6.0].map(|value| value + shift);
            let course = Course::deviation(rows(&values).iter()).measured(false);
            assert!((course.unwrap().value - 7f64.sqrt()).abs() < 1e-12);
        }
    }

    #[test]
    fn start_up_is_cut_or_reported() {
        let values = noise("c", 4_000);
        let starting = values.iter().enumerate();
        let starting: Vec<f64> = starting
            .map(|(k, value)| value + 30.0 * libm::exp(-(k as f64) / 100.0))
            .collect();
        let starting = rows(&starting);
        let cut = Course::mean(starting.iter()).measured(true).unwrap();
        let left = Course::mean(starting.iter()).measured(false).unwrap();
        let warm_up = cut.estimate.warm_up.unwrap();
        // At least until it is below the noise: ln 30 times 100 rows of 0.5 s; at most half of the window.
        assert!((170.0..1000.0).contains(&warm_up), "{warm_up}");
        assert_eq!(cut.estimate.window, Some([warm_up, 1999.5]));
        assert_eq!(
            (cut.estimate.steady, left.estimate.steady),
            (Some(true), Some(false))
        );
        assert!(left.note.unwrap().contains("are start-up"));
        assert!(cut.value.abs() < 5.0 * cut.estimate.error.unwrap());
        // The start-up adds 30 times 100 of 4,000 rows.
        assert!((left.value - cut.value - 0.75).abs() < 0.2);

        let drift: Vec<f64> = (0..500).map(f64::from).collect();
        let drift = Course::mean(rows(&drift).iter()).measured(true).unwrap();
        assert_eq!(drift.estimate.steady, Some(false));
        assert!(drift.note.unwrap().contains("not steady"));
    }

    #[test]
    fn few_rows_have_no_error_and_say_so() {
        let few = Course::mean(rows(&[1.0; 15]).iter())
            .measured(false)
            .unwrap();
        assert_eq!((few.value, few.estimate.error), (1.0, None));
        assert!(few.estimate.why_no_error.unwrap().contains("15 rows"));
        let same = Course::mean(rows(&[1.0; 16]).iter())
            .measured(false)
            .unwrap();
        assert_eq!(same.estimate.error, Some(0.0));
        assert!(
            same.estimate
                .why_no_error
                .unwrap()
                .contains("never changes")
        );
        assert!(Course::mean([].iter()).measured(true).is_none());
    }
}
