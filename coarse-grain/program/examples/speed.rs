//! The cost of evaluation: `cargo run --release -p coarse-grain-program --example speed [-- precision | sizes | frame]`.
//!
//! Without a word: a settled packing of 20,000 spheres (`scenes/bench/dense-20k.csv`) with its contacts onto 20x20x20 and 50x50x50 points,
//! Gaussian of one diameter cut at three widths, on one and two threads: what MercuryCG's standard fields cost per frame, without reading and
//! writing. `precision`: error against time for cut-offs, tolerances and grids, drawn in
//! `docs/pictures/cg-precision.svg`. `sizes`: cost over the number of particles.
//! `frame [POINTS [KERNEL [ROUNDS [THREADS]]]]`: evaluations without clocks, for tools that count instructions.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use mercury_cg::coordinates::{Coordinates, GridAxis, Place};
use mercury_cg::evaluate::{Evaluator, Scratch};
use mercury_cg::fields::{Field, MERCURY_SUMS};
use mercury_cg::kernel::{
    DEFAULT_CUTOFF, DEFAULT_TOLERANCE, FAST_CUTOFF, FAST_TOLERANCE, KernelChoice, KernelShape,
    LineCut,
};
use mercury_cg::state::{Contacts, Particles, Partner, Space, State};
use mercury_cg::sums::{Layout, Sums};
use mercury_common::random::Stream;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Hue, Marker, Series};

const DENSITY: f64 = 2500.0;

/// Spheres of a table, and contacts where they overlap; forces as a spring gives them.
fn packing(copies: usize) -> State {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/bench/dense-20k.csv"
    );
    let text = std::fs::read_to_string(path).expect("scenes/bench/dense-20k.csv");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().expect("a heading").split(',').collect();
    let place = |name: &str| {
        names
            .iter()
            .position(|other| other.trim() == name)
            .unwrap_or_else(|| panic!("no column {name}"))
    };
    let columns = ["x", "y", "z", "radius"].map(place);
    let size = DVec3::new(0.104, 0.104, 0.1552);
    let mut particles = Particles::default();
    let rows: Vec<[f64; 4]> = lines
        .map(|line| {
            let words: Vec<&str> = line.split(',').collect();
            columns.map(|k| words[k].trim().parse().expect("a number"))
        })
        .collect();
    for copy in 0..copies {
        for [x, y, z, r] in &rows {
            let volume = 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
            particles.id.push(particles.len() as u32);
            particles.material.push(0);
            particles.flowing.push(true);
            particles
                .position
                .push(DVec3::new(x + copy as f64 * size.x, *y, *z));
            particles.velocity.push(DVec3::new(0.1 * z, 0.0, 0.01 * x));
            particles.mass.push(DENSITY * volume);
            particles.volume.push(volume);
            particles.radius.push(*r);
            particles.angular_velocity.push(DVec3::ZERO);
            particles.spin.push(DVec3::ZERO);
        }
    }
    let space = Space {
        min: DVec3::ZERO,
        max: DVec3::new(size.x * copies as f64, size.y, size.z),
        ..Space::default()
    };
    let contacts = contacts(&particles, &space);
    State {
        time: 0.0,
        space,
        particles,
        contacts: Some(contacts),
        displacement: None,
    }
}

fn contacts(p: &Particles, space: &Space) -> Contacts {
    let cell = 2.0 * p.radius.iter().fold(0.0f64, |a, b| a.max(*b));
    let counts = [0, 1, 2].map(|a| (space.max[a] / cell) as usize + 1);
    let at = |x: DVec3| [0, 1, 2].map(|a| ((x[a] / cell).max(0.0) as usize).min(counts[a] - 1));
    let index = |c: [usize; 3]| (c[0] * counts[1] + c[1]) * counts[2] + c[2];
    let mut members = vec![Vec::new(); counts.iter().product()];
    for (k, &x) in p.position.iter().enumerate() {
        members[index(at(x))].push(k);
    }
    let mut c = Contacts::default();
    let mut push = |i: usize, partner: Partner, n: DVec3, overlap: f64, distance: f64| {
        let arm = (p.radius[i] - 0.5 * overlap) * n;
        c.particle.push(i as u32);
        c.partner.push(partner);
        c.point.push(p.position[i] - arm);
        c.arm.push(arm);
        c.partner_arm.push(if distance > 0.0 {
            arm - distance * n
        } else {
            DVec3::ZERO
        });
        c.normal.push(n);
        c.force
            .push(1e3 * overlap * (n + 0.1 * n.any_orthonormal_vector()));
    };
    for (i, &x) in p.position.iter().enumerate() {
        let own = at(x);
        let around = |a: usize| own[a].saturating_sub(1)..(own[a] + 2).min(counts[a]);
        for a in around(0) {
            for b in around(1) {
                for d in around(2) {
                    for &j in members[index([a, b, d])].iter().filter(|&&j| j > i) {
                        let between = x - p.position[j];
                        let overlap = p.radius[i] + p.radius[j] - between.length();
                        if overlap > 0.0 {
                            push(
                                i,
                                Partner::Particle(j as u32),
                                between.normalize(),
                                overlap,
                                between.length(),
                            );
                        }
                    }
                }
            }
        }
        for (wall, n, distance) in [
            (0, DVec3::X, x.x),
            (1, -DVec3::X, space.max.x - x.x),
            (2, DVec3::Y, x.y),
            (3, -DVec3::Y, space.max.y - x.y),
            (4, DVec3::Z, x.z),
        ] {
            if distance < p.radius[i] {
                push(i, Partner::Wall(wall), n, p.radius[i] - distance, 0.0);
            }
        }
    }
    c
}

fn evaluator(state: &State, count: usize, kernel: KernelChoice) -> Evaluator {
    let axis = |a: usize| GridAxis {
        min: state.space.min[a],
        max: state.space.max[a],
        count,
    };
    Evaluator::new(
        Coordinates::default(),
        Place::Grid(vec![axis(0), axis(1), axis(2)]),
        kernel,
    )
}

/// Evaluations of which the median counts.
const ROUNDS: usize = 9;

/// Times of evaluations, in s.
struct Times {
    /// The median, on one and on two threads; they alternate.
    wall: [f64; 2],
    /// Processor time of one on one thread, mean; where the system does not report it, that of the clock.
    processor: f64,
    /// Processor time of the busier of two threads, mean: what the clock would show if no other program used the processors.
    busier: f64,
    /// Sums of the last evaluation.
    sums: Sums,
}

/// Processor time of each thread so far, by its number, s (Linux).
fn processor() -> Option<BTreeMap<u64, f64>> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let mut found = BTreeMap::new();
    for task in tasks {
        let path = task.ok()?.path();
        let number = path.file_name()?.to_str()?.parse().ok()?;
        let text = std::fs::read_to_string(path.join("schedstat")).ok()?;
        let nanoseconds: u64 = text.split_whitespace().next()?.parse().ok()?;
        found.insert(number, 1e-9 * nanoseconds as f64);
    }
    Some(found)
}

fn time(evaluator: &Evaluator, state: &State, layout: &Layout) -> Times {
    let pools = [1, 2].map(|threads| {
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        builder.build().expect("threads")
    });
    // As for the frames of a series.
    let mut scratch = Scratch::default();
    let mut times = Times {
        wall: [0.0; 2],
        processor: 0.0,
        busier: 0.0,
        sums: evaluator.sums_with(state, layout, None, &mut scratch),
    };
    let mut walls = [const { Vec::new() }; 2];
    for _ in 0..ROUNDS {
        for (pool, walls) in pools.iter().zip(&mut walls) {
            let (begin, before) = (Instant::now(), processor());
            let sums = pool.install(|| evaluator.sums_with(state, layout, None, &mut scratch));
            let elapsed = begin.elapsed().as_secs_f64();
            scratch.take_back(std::mem::replace(&mut times.sums, sums));
            walls.push(elapsed);
            let each: Vec<f64> = match before.zip(processor()) {
                Some((before, after)) => after
                    .into_iter()
                    .map(|(thread, seconds)| seconds - before.get(&thread).unwrap_or(&0.0))
                    .collect(),
                None => vec![elapsed],
            };
            if pool.current_num_threads() == 1 {
                times.processor += each.iter().sum::<f64>() / ROUNDS as f64;
            } else {
                times.busier += each.iter().fold(0.0, |a: f64, &b| a.max(b)) / ROUNDS as f64;
            }
        }
    }
    for (wall, mut walls) in times.wall.iter_mut().zip(walls) {
        walls.sort_by(f64::total_cmp);
        *wall = walls[ROUNDS / 2];
    }
    times
}

/// Processor time of an evaluation on one thread, the least of three, s; and what it gave.
fn cost(evaluator: &Evaluator, state: &State, layout: &Layout) -> (f64, Sums) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.expect("threads");
    let mut scratch = Scratch::default();
    let mut evaluate = || {
        let (begin, before) = (Instant::now(), processor());
        let sums = pool.install(|| evaluator.sums_with(state, layout, None, &mut scratch));
        let elapsed = begin.elapsed().as_secs_f64();
        // Threads of pools that are gone end when they like: only those that are there count.
        let seconds = before.zip(processor()).map(|(before, after)| {
            let spent = after
                .iter()
                .map(|(thread, seconds)| seconds - before.get(thread).unwrap_or(&0.0));
            spent.sum::<f64>()
        });
        (seconds.unwrap_or(elapsed), sums)
    };
    let mut least = evaluate();
    for _ in 0..2 {
        let next = evaluate();
        if next.0 < least.0 {
            least = next;
        }
    }
    least
}

fn gaussian(width: f64, cutoff: f64, tolerance: f64) -> KernelChoice {
    KernelChoice {
        cutoff,
        tolerance,
        ..KernelChoice::new(KernelShape::Gaussian, width)
    }
}

fn speed() {
    let state = packing(1);
    let layout = Layout::new(&MERCURY_SUMS);
    let d = 2.0 * state.particles.radius[0];
    let count = state.contacts.as_ref().map_or(0, Contacts::len);
    println!(
        "{} particles, {count} contacts, w = d = {d} m",
        state.particles.len()
    );
    println!(
        "{:<34}{:>12}{:>12}{:>12}{:>14}{:>16}",
        "grid and kernel", "processor", "1 thread", "2 threads", "busier of 2", "processor / it"
    );
    for (name, kernel) in kernels(d) {
        for count in [20, 50] {
            let evaluator = evaluator(&state, count, kernel);
            let Times {
                wall: [one, two],
                processor,
                busier,
                ..
            } = time(&evaluator, &state, &layout);
            println!(
                "{:<34}{:>10.1}ms{:>10.1}ms{:>10.1}ms{:>12.1}ms{:>15.2}x",
                format!("{count}^3 {name}"),
                1e3 * processor,
                1e3 * one,
                1e3 * two,
                1e3 * busier,
                processor / busier
            );
        }
    }
}

/// The kernels that are compared.
fn kernels(d: f64) -> [(&'static str, KernelChoice); 7] {
    let mercury = |tolerance| KernelChoice {
        line_cut: LineCut::Cylinder,
        ..gaussian(d, 3.0, tolerance)
    };
    [
        ("as MercuryCG, to 1e-3", mercury(1e-3)),
        ("as MercuryCG, to 1e-12", mercury(1e-12)),
        ("default", KernelChoice::new(KernelShape::Gaussian, d)),
        ("cut at 3 w, to 1e-5", gaussian(d, 3.0, 1e-5)),
        ("cut at 4 w, to 1e-5", gaussian(d, 4.0, 1e-5)),
        ("--fast", gaussian(d, FAST_CUTOFF, FAST_TOLERANCE)),
        ("lucy of radius d", KernelChoice::new(KernelShape::Lucy, d)),
    ]
}

/// Evaluations without clocks, for tools that count instructions: points per axis, number of the kernel, number of evaluations, threads.
fn frame() {
    let mut numbers = std::env::args()
        .skip(2)
        .map(|word| word.parse::<usize>().expect("a number"));
    let mut next = |usual| numbers.next().unwrap_or(usual);
    let (points, kernel, rounds, threads) = (next(20), next(2), next(1), next(1));
    let state = packing(1);
    let layout = Layout::new(&MERCURY_SUMS);
    let (name, kernel) = kernels(2.0 * state.particles.radius[0])[kernel];
    let evaluator = evaluator(&state, points, kernel);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let mut scratch = Scratch::default();
    let sum: f64 = pool.expect("threads").install(|| {
        (0..rounds)
            .map(|_| {
                let sums = evaluator.sums_with(&state, &layout, None, &mut scratch);
                let one = sums.values[2][0];
                scratch.take_back(sums);
                one
            })
            .sum()
    });
    println!("{points}^3 {name}, {rounds} times: {sum}");
}

/// Largest difference of a sum, relative to its largest value.
fn difference(a: &Sums, b: &Sums) -> (f64, f64) {
    let of = |spread: usize| {
        let largest = b.values[spread].iter().fold(0.0f64, |a, b| a.max(b.abs()));
        let worst = a.values[spread]
            .iter()
            .zip(&b.values[spread])
            .fold(0.0f64, |worst, (a, b)| worst.max((a - b).abs()));
        worst / largest
    };
    (of(0), of(2))
}

fn precision() {
    let state = packing(1);
    let d = 2.0 * state.particles.radius[0];
    let fields = ["density", "contact_stress"].map(|name| Field::by_name(name).expect("a field"));
    let layout = Layout::new(
        &fields
            .iter()
            .flat_map(|field| field.sums)
            .copied()
            .collect::<Vec<_>>(),
    );
    let exact = evaluator(&state, 30, gaussian(d, 8.8, 1e-15)).sums(&state, &layout, None);
    println!(
        "{:>8}{:>11}{:>12}{:>12}{:>10}",
        "cut-off", "tolerance", "density", "stress", "time"
    );
    let cutoffs = [2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0];
    let mut chart = Chart::new(
        "cut-off and quadrature",
        Axis::log("time of a frame", "s"),
        Axis::log("largest error over largest value", ""),
    );
    let mut chosen = Vec::new();
    for (tolerance, name) in [
        (5e-2, "quadrature to 5e-2"),
        (1e-3, "to 1e-3"),
        (1e-5, "to 1e-5"),
        (1e-8, "to 1e-8"),
        (1e-12, "to 1e-12"),
    ] {
        let mut points = Vec::new();
        for cutoff in cutoffs {
            let kernel = gaussian(d, cutoff, tolerance);
            let (seconds, sums) = cost(&evaluator(&state, 30, kernel), &state, &layout);
            let (density, stress) = difference(&sums, &exact);
            println!(
                "{cutoff:>8}{tolerance:>11.0e}{density:>12.1e}{stress:>12.1e}{:>8.0}ms",
                1e3 * seconds
            );
            let point = (seconds, density.max(stress));
            points.push(point);
            if (cutoff, tolerance) == (DEFAULT_CUTOFF, DEFAULT_TOLERANCE) {
                chosen.push(point);
            }
        }
        chart = chart.with(Series::marked_line(name, points));
    }
    let chosen = Series::points("default", chosen).hue(Hue::Ink);
    let chart = chart.with(chosen.marker(Marker::Ring));
    let grids = grids(&state, d, &layout);
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../docs/pictures/cg-precision.svg"
    );
    let page = ChartPage::new("", 2, vec![chart, grids]).size(1000.0, 420.0);
    page.write_svg(Path::new(path)).expect("the picture");
    println!("{path}");
}

/// Errors of grids: between their points, where a straight line is drawn, and of the mass by the sum over cells.
fn grids(state: &State, d: f64, layout: &Layout) -> Chart {
    println!(
        "{:>8}{:>10}{:>12}{:>12}{:>12}{:>10}",
        "h / w", "points", "density", "stress", "mass", "time"
    );
    let mut stream = Stream::new(1, "places between points", 0);
    let places: Vec<Vec<f64>> = (0..2000)
        .map(|_| {
            let within = |a: usize, uniform: f64| {
                state.space.min[a] + uniform * (state.space.max[a] - state.space.min[a])
            };
            (0..3)
                .map(|a| within(a, stream.uniform_in(0.0, 1.0)))
                .collect()
        })
        .collect();
    let kernel = gaussian(d, 8.8, 1e-15);
    let exact = Evaluator {
        place: Place::Points(places.clone()),
        ..evaluator(state, 1, kernel)
    }
    .sums(state, layout, None);
    let total: f64 = state.particles.mass.iter().sum();
    let [mut between, mut mass, mut chosen] = [const { Vec::new() }; 3];
    for ratio in [0.5, 0.75, 1.0, 1.5, 2.0, 3.0] {
        let h = ratio * d;
        // Beyond the box as far as a kernel reaches, so that all of the mass is on the grid.
        let margin = 9.0 * d;
        let axes = [0, 1, 2].map(|a| {
            let length = state.space.max[a] - state.space.min[a] + 2.0 * margin;
            let count = (length / h).ceil();
            let min = state.space.min[a] - margin;
            GridAxis {
                min,
                max: min + count * h,
                count: count as usize,
            }
        });
        let on_grid = |kernel| Evaluator {
            place: Place::Grid(axes.to_vec()),
            ..evaluator(state, 1, kernel)
        };
        let usual = on_grid(KernelChoice::new(KernelShape::Gaussian, d));
        let (seconds, _) = cost(&usual, state, layout);
        let sums = on_grid(kernel).sums(state, layout, None);
        let on_cells = h * h * h * sums.values[0].iter().sum::<f64>();
        let missed = (on_cells / total - 1.0).abs();
        let [density, stress] = [0, 2].map(|spread| {
            let stride = exact.values[spread].len() / places.len();
            let largest = exact.values[spread]
                .iter()
                .fold(0.0f64, |a, b| a.max(b.abs()));
            let mut worst = 0.0f64;
            for (place, exact) in places.iter().zip(exact.values[spread].chunks(stride)) {
                let at = interpolated(&axes, &sums.values[spread], stride, place);
                for (at, exact) in at.iter().zip(exact) {
                    worst = worst.max((at - exact).abs());
                }
            }
            worst / largest
        });
        println!(
            "{ratio:>8}{:>10}{density:>12.1e}{stress:>12.1e}{missed:>12.1e}{:>8.0}ms",
            usual.place.len(),
            1e3 * seconds
        );
        between.push((seconds, density.max(stress)));
        // Round-off is no error that a finer grid would mend.
        mass.push((seconds, missed.max(1e-15)));
        if ratio == 1.0 {
            chosen.extend([between[between.len() - 1], mass[mass.len() - 1]]);
        }
    }
    Chart::new(
        "grid: spacing of 3 w to w/2",
        Axis::log("time of a frame", "s"),
        Axis::log("error", ""),
    )
    .with(Series::marked_line("between points", between))
    .with(Series::marked_line("mass as sum over cells", mass))
    .with(
        Series::points("default", chosen)
            .hue(Hue::Ink)
            .marker(Marker::Ring),
    )
}

/// Straight lines between the points of a grid, along each axis.
fn interpolated(axes: &[GridAxis; 3], values: &[f64], stride: usize, place: &[f64]) -> Vec<f64> {
    let near = [0, 1, 2].map(|a| {
        let axis = &axes[a];
        let h = (axis.max - axis.min) / axis.count as f64;
        let at = (place[a] - axis.min) / h - 0.5;
        let first = at.floor().clamp(0.0, axis.count as f64 - 2.0);
        (first as usize, at - first)
    });
    let mut out = vec![0.0; stride];
    for corner in 0..8 {
        let (mut weight, mut index) = (1.0, 0);
        for (a, (first, part)) in near.into_iter().enumerate() {
            let upper = corner >> a & 1;
            weight *= if upper == 1 { part } else { 1.0 - part };
            index = index * axes[a].count + first + upper;
        }
        for (out, value) in out.iter_mut().zip(&values[index * stride..]) {
            *out += weight * value;
        }
    }
    out
}

fn sizes() {
    println!(
        "{:>10}{:>10}{:>10}{:>12}{:>22}",
        "particles", "contacts", "points", "time", "ns per (item, point)"
    );
    let layout = Layout::new(&MERCURY_SUMS);
    for count in [1_000, 10_000, 20_000, 100_000, 1_000_000] {
        let mut state = packing(count / 20_000 + usize::from(count % 20_000 != 0));
        if count < state.particles.len() {
            // The lowest ones: a packing as dense as the whole.
            let mut order: Vec<usize> = (0..state.particles.len()).collect();
            order.sort_by(|&a, &b| {
                state.particles.position[a]
                    .z
                    .total_cmp(&state.particles.position[b].z)
            });
            let top = state.particles.position[order[count]].z;
            let keep: Vec<usize> = order[..count].to_vec();
            let p = &state.particles;
            let mut fewer = Particles::default();
            for &k in &keep {
                fewer.id.push(p.id[k]);
                fewer.material.push(0);
                fewer.flowing.push(true);
                fewer.position.push(p.position[k]);
                fewer.velocity.push(p.velocity[k]);
                fewer.mass.push(p.mass[k]);
                fewer.volume.push(p.volume[k]);
                fewer.radius.push(p.radius[k]);
                fewer.angular_velocity.push(DVec3::ZERO);
                fewer.spin.push(DVec3::ZERO);
            }
            state.space.max.z = top;
            state.contacts = Some(contacts(&fewer, &state.space));
            state.particles = fewer;
        }
        let d = 2.0 * state.particles.radius[0];
        let kernel = gaussian(d, 3.0, 1e-5);
        let axis = |a: usize| {
            let count = (state.space.max[a] / d).ceil() as usize;
            GridAxis {
                min: 0.0,
                max: count as f64 * d,
                count,
            }
        };
        let evaluator = Evaluator {
            place: Place::Grid(vec![axis(0), axis(1), axis(2)]),
            ..evaluator(&state, 1, kernel)
        };
        let seconds = time(&evaluator, &state, &layout).processor;
        let contacts = state.contacts.as_ref().map_or(0, Contacts::len);
        // Points in a ball of 3 w and in the ellipsoid around a segment of w, at h = w.
        let (ball, ellipsoid) = (
            4.0 / 3.0 * std::f64::consts::PI * 27.0,
            4.0 / 3.0 * std::f64::consts::PI * 9.0 * 3.5,
        );
        let pairs = state.particles.len() as f64 * ball + contacts as f64 * ellipsoid;
        println!(
            "{:>10}{contacts:>10}{:>10}{:>10.1}ms{:>22.2}",
            state.particles.len(),
            evaluator.place.len(),
            1e3 * seconds,
            1e9 * seconds / pairs
        );
    }
}

fn main() {
    match std::env::args().nth(1).as_deref() {
        None => speed(),
        Some("frame") => frame(),
        Some("precision") => precision(),
        Some("sizes") => sizes(),
        Some(other) => println!("{other}: expected nothing, frame, precision or sizes"),
    }
}
