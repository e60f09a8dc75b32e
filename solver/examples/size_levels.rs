//! The candidate list of a packing of wide sizes: how long it takes to build with the levels of sizes that are chosen and with a single grid, what it
//! holds, and whether it holds the pairs that comparing all particles with all finds.
//!
//!     cargo run --release -p solver --example size_levels -- SCENE.toml            # both ways, alternating, least of seven; what is in the packing
//!     cargo run --release -p solver --example size_levels -- SCENE.toml --check    # and all pairs, compared one by one
//!     cargo run --release -p solver --example size_levels -- SCENE.toml --threads 2    # lists made by two threads
//!     cargo run --release -p solver --example size_levels -- SCENE.toml --levels   # without the single grid, which takes minutes where sizes are wide
//!     valgrind --tool=callgrind target/release/examples/size_levels SCENE.toml single 3    # builds three lists with a single grid, for tools that count
//!
//! `benches/sizes.py` makes such scenes.

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use mercury_engine::cell::Cell;
use mercury_engine::neighbours::{Built, Levels, Margin, Skin, build};
use mercury_engine::state::{Particle, Particles};
use mercury_engine::step::Engine;
use mercury_solver::plan::{plan, read_scene};

const ROUNDS: usize = 7;
/// A packed sphere needs so many contacts to be held without friction.
const HELD_BY: usize = 4;

struct Case {
    particles: Particles,
    cell: Cell,
    skin: f64,
    pool: Option<rayon::ThreadPool>,
}

impl Case {
    fn read(path: &str) -> Result<Self, String> {
        let scene = read_scene(Path::new(path), &[]).map_err(|error| error.to_string())?;
        let plan = plan(&scene).map_err(|error| error.to_string())?;
        let cell = plan.physics().cell;
        let skin = Skin::first(plan.physics().radii(), 0.0, &cell).thickness;
        let engine = Engine::new(Arc::new(plan), 1).map_err(|error| error.to_string())?;
        Ok(Self {
            particles: engine.particles.clone(),
            cell,
            skin,
            pool: None,
        })
    }

    /// All in one level.
    fn single(&self) -> Levels {
        let radii = self.particles.records.iter().map(|record| record.radius);
        Levels {
            largest: vec![radii.fold(0.0, f64::max)],
        }
    }

    fn chosen(&self) -> Levels {
        Levels::choose(&self.particles.records, self.skin)
    }

    fn build(&mut self, levels: &Levels) -> Built {
        let Self {
            particles,
            cell,
            skin,
            pool,
        } = self;
        let mut none = Vec::new();
        let margin = Margin::of_skin(*skin);
        match pool {
            Some(pool) => pool.install(|| build(particles, &mut none, levels, &margin, cell, true)),
            None => build(particles, &mut none, levels, &margin, cell, false),
        }
    }

    /// Whether two particles are closer than this beyond contact (m). In a domain as wide as twice the largest distance of a pair, only the nearest image counts.
    fn are_near(&self, a: &Particle, b: &Particle, gap: f64) -> bool {
        let mut apart = a.position - b.position;
        for axis in 0..3 {
            if self.cell.is_periodic(axis) {
                let period = self.cell.size()[axis];
                apart[axis] -= period * (apart[axis] / period).round();
            }
        }
        let reach = a.radius + b.radius + gap;
        apart.length_squared() < reach * reach
    }

    /// Contacts, and the particles that still bear some after particles with less than four contacts were removed again and again, until none is left.
    fn held(&self, built: &Built) -> [usize; 4] {
        let records = &self.particles.records;
        let mut partners = vec![Vec::new(); records.len()];
        let (mut contacts, mut held) = (0, records.len());
        for (row, ends) in built.list.start.windows(2).enumerate() {
            for entry in &built.list.entries[ends[0] as usize..ends[1] as usize] {
                let partner = entry.partner as usize;
                if self.are_near(&records[row], &records[partner], 0.0) {
                    partners[row].push(partner);
                    partners[partner].push(row);
                    contacts += 1;
                }
            }
        }
        let mut left: Vec<usize> = partners.iter().map(Vec::len).collect();
        let mut is_loose = vec![false; records.len()];
        let mut loose: Vec<usize> = (0..records.len())
            .filter(|&row| left[row] < HELD_BY)
            .collect();
        let mut bearing = contacts;
        while let Some(row) = loose.pop() {
            if std::mem::replace(&mut is_loose[row], true) {
                continue;
            }
            held -= 1;
            for &partner in partners[row].iter().filter(|&&partner| !is_loose[partner]) {
                bearing -= 1;
                left[partner] -= 1;
                if left[partner] < HELD_BY {
                    loose.push(partner);
                }
            }
        }
        [contacts, held, bearing, built.list.entries.len()]
    }

    /// All pairs within the skin, counted by comparing all with all, and those of them that the list has.
    fn compared(&self, built: &Built) -> [usize; 2] {
        let records = &self.particles.records;
        let (mut near, mut listed) = (0, 0);
        for row in 0..records.len() {
            let ends = [row, row + 1].map(|row| built.list.start[row] as usize);
            let mut entries: Vec<usize> = built.list.entries[ends[0]..ends[1]]
                .iter()
                .map(|entry| entry.partner as usize)
                .collect();
            entries.sort_unstable();
            for partner in row + 1..records.len() {
                if self.are_near(&records[row], &records[partner], self.skin) {
                    near += 1;
                    listed += usize::from(entries.binary_search(&partner).is_ok());
                }
            }
        }
        [near, listed]
    }
}

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (path, more) = arguments.split_first().ok_or("which scene?")?;
    let mut case = Case::read(path)?;
    let after = |word: &str| more.iter().skip_while(|&other| other != word).nth(1);
    if let Some(threads) = after("--threads") {
        let threads = threads
            .parse()
            .map_err(|_| "how many threads?".to_owned())?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        case.pool = Some(pool.build().map_err(|error| error.to_string())?);
    }
    let ways = [case.chosen(), case.single()];
    if let ([way, count], None) = (more, &case.pool) {
        let levels = &ways[usize::from(way == "single")];
        let count: usize = count.parse().map_err(|_| "how often?".to_owned())?;
        for _ in 0..count {
            black_box(case.build(levels));
        }
        return Ok(());
    }
    let built = case.build(&ways[0]);
    let count = case.particles.len();
    let radii = case.particles.records.iter().map(|record| record.radius);
    let solid: f64 = radii
        .map(|radius| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3))
        .sum();
    let [contacts, held, bearing, listed] = case.held(&built);
    println!("particles {count}");
    println!(
        "solid_fraction {:.4}",
        solid / case.cell.size().element_product()
    );
    println!(
        "contacts_per_particle {:.3}",
        contacts as f64 / count as f64
    );
    println!("held {:.4}", held as f64 / count as f64);
    println!(
        "coordination_of_held {:.3}",
        2.0 * bearing as f64 / held.max(1) as f64
    );
    println!("skin {:.4e}", case.skin);
    println!("listed_per_particle {:.3}", listed as f64 / count as f64);
    println!("levels {}", ways[0].largest.len());
    let largest: Vec<String> = ways[0]
        .largest
        .iter()
        .map(|radius| format!("{radius:.4e}"))
        .collect();
    println!("largest_of_levels {}", largest.join(" "));
    if more.iter().any(|word| word == "--check") {
        for (name, levels) in ["levels", "single"].into_iter().zip(&ways) {
            let built = case.build(levels);
            let [near, found] = case.compared(&built);
            let entries = built.list.entries.len();
            println!("compared_{name} near {near} listed {entries} both {found}");
            if [entries, found] != [near, near] {
                return Err("the list is not that of all pairs".to_owned());
            }
        }
    }
    let is_single_left_out = more.iter().any(|word| word == "--levels");
    let mut least = vec![f64::INFINITY; if is_single_left_out { 1 } else { 2 }];
    for _ in 0..ROUNDS {
        for (least, levels) in least.iter_mut().zip(&ways) {
            let since = Instant::now();
            black_box(case.build(levels));
            *least = least.min(since.elapsed().as_secs_f64());
        }
    }
    for (name, seconds) in ["levels", "single"].into_iter().zip(least) {
        println!("ns_per_particle_{name} {:.1}", 1e9 * seconds / count as f64);
    }
    Ok(())
}
