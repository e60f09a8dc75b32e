//! How often the interval of a mean holds the true mean, and which series never end: `cargo run --release -p tests --bin coverage [RUNS]`.
//!
//! Series whose mean is known go through the same record, start-up, batches and looks as the rows of a run that ends when a result is known. Printed: the share of intervals that hold the mean,
//! the length over that of a perfect rule, and the bound of the specification. The exit code is 1 where a share is outside of its bound.

use std::process::ExitCode;

use mercury_common::random::Stream;
use mercury_common::statistics::{Batches, Look, Looks, Record, start_up};

/// A process of known mean.
struct Process {
    name: &'static str,
    /// True mean.
    mean: f64,
    /// Standard deviation of a row.
    deviation: f64,
    /// Rows for each independent one: sum of the correlations over all distances.
    correlation: f64,
    /// Rows before the first look, in units of the correlation.
    at_least: f64,
    /// Bounds of the share of intervals that hold the mean, %; none: it must never end.
    bounds: Option<[f64; 2]>,
    /// The next row from its number, random numbers and the state.
    row: fn(u64, &mut Stream, &mut [f64; 2]) -> f64,
}

/// Autoregressive process of deviation 1 and this correlation of neighbours, from the steady state.
fn autoregressive(k: u64, stream: &mut Stream, y: &mut f64, phi: f64) -> f64 {
    let noise = stream.standard_normal();
    *y = if k == 0 {
        noise
    } else {
        phi * *y + (1.0 - phi * phi).sqrt() * noise
    };
    *y
}

/// sum over k of (exp(phi^|k|) - 1)/(e - 1): that of the exponential of an autoregressive process.
fn correlation_of_exponential(phi: f64) -> f64 {
    let term = |k: i32| phi.powi(k).exp_m1() / 1.0f64.exp_m1();
    1.0 + 2.0 * (1..5_000).map(term).sum::<f64>()
}

fn processes() -> Vec<Process> {
    let most = [91.0, 98.0];
    vec![
        Process {
            name: "independent",
            mean: 0.0,
            deviation: 1.0,
            correlation: 1.0,
            at_least: 10.0,
            bounds: Some(most),
            row: |_, stream, _| stream.standard_normal(),
        },
        Process {
            name: "autoregressive, 0.9",
            mean: 0.0,
            deviation: 1.0,
            correlation: 19.0,
            at_least: 10.0,
            bounds: Some(most),
            row: |k, stream, [y, _]| autoregressive(k, stream, y, 0.9),
        },
        Process {
            name: "autoregressive, 0.99",
            mean: 0.0,
            deviation: 1.0,
            correlation: 199.0,
            at_least: 10.0,
            bounds: Some(most),
            row: |k, stream, [y, _]| autoregressive(k, stream, y, 0.99),
        },
        Process {
            name: "rare switching",
            mean: 0.5,
            deviation: 0.5,
            correlation: 99.0,
            at_least: 20.0,
            bounds: Some(most),
            row: |k, stream, [y, _]| {
                if k == 0 {
                    *y = f64::from(u8::from(stream.uniform() < 0.5));
                } else if stream.uniform() < 0.01 {
                    *y = 1.0 - *y;
                }
                *y
            },
        },
        Process {
            name: "start-up of 5 deviations",
            mean: 0.0,
            deviation: 1.0,
            correlation: 19.0,
            at_least: 10.0,
            bounds: Some([89.0, 100.0]),
            row: |k, stream, [y, _]| {
                autoregressive(k, stream, y, 0.9) + 5.0 * (-(k as f64) / 95.0).exp()
            },
        },
        Process {
            name: "far start",
            mean: 0.0,
            deviation: 1.0,
            correlation: 19.0,
            at_least: 10.0,
            bounds: Some([89.0, 100.0]),
            row: |k, stream, [y, _]| {
                if k == 0 {
                    *y = 20.0;
                }
                autoregressive(k + 1, stream, y, 0.9)
            },
        },
        Process {
            name: "oscillation",
            mean: 0.0,
            deviation: 1.0,
            correlation: 1.0,
            at_least: 150.0,
            bounds: Some([93.0, 100.0]),
            row: |k, stream, [phase, _]| {
                if k == 0 {
                    *phase = stream.uniform();
                }
                let turns = *phase + k as f64 / 50.0;
                stream.standard_normal() + (std::f64::consts::TAU * turns).sin()
            },
        },
        Process {
            name: "skewed: exp of autoregressive, 0.95",
            mean: 0.5f64.exp(),
            // Of a log-normal law.
            deviation: (1.0f64.exp_m1() * 1.0f64.exp()).sqrt(),
            correlation: correlation_of_exponential(0.95),
            at_least: 10.0,
            bounds: Some([84.0, 98.0]),
            row: |k, stream, [y, _]| autoregressive(k, stream, y, 0.95).exp(),
        },
        Process {
            name: "drift of 10 deviations",
            mean: 0.0,
            deviation: 1.0,
            correlation: 19.0,
            at_least: 10.0,
            bounds: None,
            row: |k, stream, [y, _]| autoregressive(k, stream, y, 0.9) + 10.0 * k as f64 / 7_600.0,
        },
        Process {
            name: "random walk",
            mean: 0.0,
            deviation: 1.0,
            correlation: 19.0,
            at_least: 10.0,
            bounds: None,
            row: |_, stream, [y, _]| {
                *y += 0.3 * stream.standard_normal();
                *y
            },
        },
    ]
}

/// Rows of a run until its mean is known to `error`, and whether the interval holds the true mean; `None` if it never is within `most` rows.
fn length(process: &Process, error: f64, most: u64, run: u64) -> Option<(u64, bool)> {
    let mut stream = Stream::new(run, process.name, 0);
    let (mut state, mut record) = ([0.0; 2], Record::default());
    let mut looks = Looks::from_row((process.at_least * process.correlation) as u64);
    for k in 0..most {
        record.add((process.row)(k, &mut stream, &mut state));
        let rows = k + 1;
        if !looks.is_due(rows) {
            continue;
        }
        let bins = record.bins();
        let start = start_up(bins)?;
        let kept = &bins[start.cut..];
        let known = Batches::of(kept).map(|batches| {
            let known = batches.estimate();
            let look = Look {
                error: known.error,
                half_width: known.half_width,
                independent: known.independent,
                difference: batches.difference_of_halves(),
                is_steady: start.is_steady,
            };
            (known, look.is_known_to(error))
        });
        let is_known = known.is_some_and(|(_, is_known)| is_known);
        if looks.note(rows, is_known)
            && let Some((known, _)) = known
        {
            let holds = (known.value - process.mean).abs() <= known.half_width;
            return Some((rows, holds));
        }
    }
    None
}

fn main() -> ExitCode {
    let runs: u64 = match std::env::args().nth(1).map(|text| text.parse()) {
        None => 1000,
        Some(Ok(runs)) if runs > 0 => runs,
        Some(_) => {
            eprintln!("expected the number of runs of each process, above 0; for example 1000");
            return ExitCode::from(2);
        }
    };
    let mut right = true;
    println!("process                                  n  ended  inside, %  length  bound");
    for process in processes() {
        for n in [100.0f64, 400.0] {
            let error = process.deviation / n.sqrt();
            let (runs, most) = match process.bounds {
                Some(_) => (runs, 20.0 * n * process.correlation + 20_000.0),
                // Long enough to end if it were steady.
                None => (runs.min(300), 4.0 * n * process.correlation),
            };
            let ended: Vec<(u64, bool)> = (0..runs)
                .filter_map(|run| length(&process, error, most as u64, run))
                .collect();
            let inside = ended.iter().filter(|(_, holds)| *holds).count() as f64;
            let share = 100.0 * inside / ended.len() as f64;
            let rows: u64 = ended.iter().map(|(rows, _)| rows).sum();
            let ideal = n * process.correlation * ended.len() as f64;
            let (is_right, bound) = match process.bounds {
                // Three deviations of the share of fewer runs than 1,000.
                Some([low, high]) => {
                    let slack = match runs {
                        1000.. => 0.0,
                        runs => 300.0 * (0.05 * 0.95 / runs as f64).sqrt(),
                    };
                    let all = ended.len() as u64 == runs;
                    let inside = (low - slack..=high + slack).contains(&share);
                    (all && inside, format!("{low} to {high} %"))
                }
                None => (ended.is_empty(), "none ends".to_owned()),
            };
            right &= is_right;
            println!(
                "{:<38} {n:>3}  {:>5}  {share:>9.1}  {:>6.2}  {bound}{}",
                process.name,
                ended.len(),
                rows as f64 / ideal,
                if is_right { "" } else { "  MISSED" },
            );
        }
    }
    if right {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
