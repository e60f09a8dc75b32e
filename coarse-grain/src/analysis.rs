//! From states to blocks of fields: which fields, of which materials, averaged how.

mod course;
pub(crate) mod words;

use mercury_common::statistics::BATCH_BINS;

use crate::CgError;
use crate::evaluate::{Evaluator, MOST_GROUPED};
use crate::fields::{Field, MERCURY_SUMS};
use crate::state::{Space, State};
use crate::sums::{Layout, SPREADS, Sum, Sums};
pub use course::Course;

/// How frames are put together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeMode {
    /// A block for each frame.
    Frames,
    /// One block: the mean over all frames.
    Average,
    /// Blocks at equal distances in time: means weighted by a Gaussian, cut at three widths.
    Smooth {
        /// Standard deviation, s.
        width: f64,
        /// From one block to the next, s.
        step: f64,
    },
}

/// Where a Gaussian in time is cut, in widths.
pub const TIME_CUTOFF: f64 = 3.0;

/// State from which displacements are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reference {
    /// The frame before.
    #[default]
    Previous,
    /// The first frame.
    First,
}

/// Part that is summed separately: everything, or one material.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// In front of the names of its columns; nothing for everything.
    pub name: Option<String>,
    /// Index of the material; nothing for all.
    pub material: Option<u32>,
}

impl Part {
    /// All flowing particles.
    #[must_use]
    pub fn everything() -> Self {
        Self {
            name: None,
            material: None,
        }
    }
}

/// Analysis to compute: fields, and where and how they are evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct Analysis {
    /// Where and how.
    pub evaluator: Evaluator,
    /// Fields to compute.
    pub fields: Vec<&'static Field>,
    /// Parts to sum separately.
    pub parts: Vec<Part>,
    /// How frames are put together.
    pub time: TimeMode,
    /// Whether means come with standard errors.
    pub errors: bool,
    /// State from which displacements are counted.
    pub reference: Reference,
    /// Whether the sums of MercuryCG's files are kept beside the fields.
    pub keep_sums: bool,
    /// Whether a mean is given after each frame, as far as it has come, and not only at the end.
    pub running: bool,
}

/// The values of one component of a field at all points.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Field of the column.
    pub field: &'static Field,
    /// In front of the name: the material.
    pub part: Option<String>,
    /// Component of the field.
    pub component: usize,
    /// Name in tables.
    pub name: String,
    /// The values.
    pub values: Vec<f64>,
    /// Standard errors of the mean.
    pub errors: Option<Vec<f64>>,
    /// Density of a quotient: whether there is enough at each point to divide by, at least [`SPARSE`] of the most; empty of other
    /// fields.
    pub dense: Vec<bool>,
}

/// Where the sum that a quotient is divided by (for velocities the density) is a smaller share of its largest value, pictures leave the
/// point blank: there is nothing, or the edge of the kernel of single particles.
pub const SPARSE: f64 = 0.05;

/// Fields of one time, or of an average.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Time of the frame, of the last frame of an average, or of the middle of a smoothed one, s.
    pub time: f64,
    /// Times of the first and last frame in it, s.
    pub span: (f64, f64),
    /// Number of frames in it.
    pub frames: usize,
    /// Where the particles of the last frame live.
    pub space: Space,
    /// The fields.
    pub columns: Vec<Column>,
    /// The sums of everything, if they are kept.
    pub sums: Option<Sums>,
}

impl Analysis {
    /// The sums that the fields need.
    #[must_use]
    pub fn layout(&self) -> Layout {
        let mut wanted: Vec<Sum> = self
            .fields
            .iter()
            .flat_map(|field| field.sums)
            .copied()
            .collect();
        if self.keep_sums {
            wanted.extend(MERCURY_SUMS);
        }
        Layout::new(&wanted)
    }

    /// Numbers at each point: all components of all fields of all parts.
    #[must_use]
    pub fn numbers(&self) -> usize {
        let fields = self.fields.iter();
        let numbers: usize = fields.map(|field| field.components.count()).sum();
        numbers * self.parts.len()
    }

    /// Bytes that a [`Course`] of this takes at most, beside the states that it is given: the sums and fields of a frame of so many
    /// particles and contacts, and what is remembered of so many frames.
    #[must_use]
    pub fn bytes(&self, particles: f64, contacts: f64, frames: f64) -> f64 {
        const NUMBER: f64 = 8.0;
        let points = self.evaluator.place.len() as f64;
        let layout = self.layout();
        let strides = SPREADS.map(|spread| layout.stride(spread) as f64);
        let sums = points * strides.iter().sum::<f64>() * self.parts.len() as f64;
        let values = points * self.numbers() as f64;
        // Memory of rows: six numbers of a row as it stands, seven as the grid sees it, and as many while these are sorted.
        let row = |stride: &f64| if *stride > 0.0 { stride + 20.0 } else { 0.0 };
        let of_particles: f64 = strides[..2].iter().map(row).sum();
        let of_contacts: f64 = strides[2..].iter().map(row).sum();
        let rows = particles * of_particles + contacts * of_contacts;
        // The sums of one part once more, while they are put in order, and those of parts of the grid: three grids at most.
        let of_part = sums / self.parts.len().max(1) as f64;
        let spreading = of_part + (3.0 * of_part).min(MOST_GROUPED);
        let kept = match self.time {
            TimeMode::Frames => 0.0,
            TimeMode::Average => {
                // A record of each value: bins, which double as they come, and as much as ten numbers beside them.
                let bins = libm::exp2(libm::log2(frames.max(4.0)).ceil());
                let record = bins.min(BATCH_BINS as f64) + 10.0;
                sums + f64::from(u8::from(self.errors)) * values * record
            }
            TimeMode::Smooth { width, step } => sums * (2.0 * TIME_CUTOFF * width / step + 2.0),
        };
        let mut fields = self.fields.iter();
        // In a table that is never full: name and position of each.
        let before = if fields.any(|field| field.needs_displacement()) {
            2.0 * 5.0 * particles
        } else {
            0.0
        };
        NUMBER * (sums + spreading + 2.0 * values + rows + kept + before)
    }

    /// Computes the blocks of all states and gives each to `write` as soon as it is complete; returns the number of frames.
    ///
    /// # Errors
    /// Errors of the states and of `write`; blocks that are complete before are written. An error at the end of the states is
    /// returned after the frames before it have been used.
    pub fn run(
        &self,
        states: impl Iterator<Item = Result<State, CgError>>,
        mut write: impl FnMut(Block) -> Result<(), CgError>,
    ) -> Result<(usize, Option<CgError>), CgError> {
        let mut course = Course::default();
        let mut damage = None;
        for state in states {
            match state {
                Ok(state) => course.add(self, state, &mut write)?,
                Err(error) => {
                    damage = Some(error);
                    break;
                }
            }
        }
        let frames = course.frames();
        course.finish(self, &mut write)?;
        Ok((frames, damage))
    }

    /// All components of all fields of all parts, point by point, one behind the other.
    fn values(&self, parts: &[Sums], dimensions: u8) -> Vec<f64> {
        let mut out = Vec::new();
        for sums in parts {
            for field in &self.fields {
                let count = field.components.count();
                let begin = out.len();
                out.resize(begin + count * sums.points, 0.0);
                for (point, values) in out[begin..].chunks_exact_mut(count).enumerate() {
                    field.compute(sums, point, dimensions, values);
                }
            }
        }
        out
    }

    fn block(
        &self,
        time: f64,
        span: (f64, f64),
        frames: usize,
        space: Space,
        mut parts: Vec<Sums>,
        errors: Option<Vec<f64>>,
    ) -> Block {
        let axes = self.evaluator.axis_names();
        let values = self.values(&parts, space.dimensions);
        let points = self.evaluator.place.len();
        let mut columns = Vec::new();
        let mut begin = 0;
        for (part, sums) in self.parts.iter().zip(&parts) {
            for &field in &self.fields {
                let count = field.components.count();
                let dense = dense(field, sums);
                let pick = |from: &[f64], component: usize| -> Vec<f64> {
                    from[begin..begin + count * points]
                        .iter()
                        .skip(component)
                        .step_by(count)
                        .copied()
                        .collect()
                };
                for (component, suffix) in field.components.suffixes(axes).into_iter().enumerate() {
                    let prefix = part
                        .name
                        .as_ref()
                        .map_or(String::new(), |name| format!("{name}."));
                    columns.push(Column {
                        field,
                        part: part.name.clone(),
                        component,
                        name: format!("{prefix}{}{suffix}", field.name),
                        values: pick(&values, component),
                        errors: errors.as_ref().map(|errors| pick(errors, component)),
                        dense: dense.clone(),
                    });
                }
                begin += count * points;
            }
        }
        let sums = (self.keep_sums && !parts.is_empty()).then(|| parts.swap_remove(0));
        Block {
            time,
            span,
            frames,
            space,
            columns,
            sums,
        }
    }
}

/// See [`Column::dense`].
fn dense(field: &Field, sums: &Sums) -> Vec<bool> {
    let Some(divisor) = field.divisor() else {
        return Vec::new();
    };
    let at = |point| sums.at(divisor, point).first().copied().unwrap_or(0.0);
    let most = (0..sums.points).map(at).fold(0.0, f64::max);
    let enough = |point| at(point) > 0.0 && at(point) >= SPARSE * most;
    (0..sums.points).map(enough).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use mercury_common::statistics::{Batches, Record};

    use super::*;
    use crate::coordinates::{Coordinates, Place};
    use crate::kernel::{KernelChoice, KernelShape};

    /// One particle of 2 kg in a box of 1 m^3, with a velocity.
    fn state(time: f64, vx: f64, x: f64) -> State {
        let mut state = State {
            time,
            ..State::default()
        };
        state.space.max = DVec3::ONE;
        let p = &mut state.particles;
        p.id.push(7);
        p.material.push(0);
        p.flowing.push(true);
        p.position.push(DVec3::new(x, 0.5, 0.5));
        p.velocity.push(DVec3::new(vx, 0.0, 0.0));
        p.mass.push(2.0);
        p.volume.push(0.1);
        p.radius.push(0.1);
        p.angular_velocity.push(DVec3::ZERO);
        p.spin.push(DVec3::ZERO);
        state
    }

    fn analysis(time: TimeMode, fields: &[&str]) -> Analysis {
        let place = Place::Points(vec![Vec::new()]);
        let kernel = KernelChoice::new(KernelShape::Gaussian, 0.1);
        Analysis {
            evaluator: Evaluator::new(Coordinates::Cartesian([false; 3]), place, kernel),
            fields: fields
                .iter()
                .map(|name| Field::by_name(name).unwrap())
                .collect(),
            parts: vec![Part::everything()],
            time,
            errors: true,
            reference: Reference::Previous,
            keep_sums: false,
            running: false,
        }
    }

    fn run(analysis: &Analysis, states: Vec<State>) -> Vec<Block> {
        let mut blocks = Vec::new();
        let (frames, damage) = analysis
            .run(states.iter().cloned().map(Ok), |block| {
                blocks.push(block);
                Ok(())
            })
            .unwrap();
        assert_eq!((frames, damage.is_none()), (states.len(), true));
        blocks
    }

    #[test]
    fn averages_are_of_sums_and_fluctuations_in_time_are_temperature() {
        let analysis = analysis(TimeMode::Average, &["velocity", "granular_temperature"]);
        let blocks = run(&analysis, vec![state(0.0, 1.0, 0.5), state(1.0, 3.0, 0.5)]);
        assert_eq!(blocks.len(), 1);
        let block = &blocks[0];
        assert_eq!((block.time, block.span, block.frames), (1.0, (0.0, 1.0), 2));
        assert_eq!(block.columns[0].name, "velocity_x");
        assert_eq!(block.columns[0].values, [2.0]);
        // Two frames are no 16 batches.
        assert_eq!(block.columns[0].errors, None);
        // <v^2> - <v>^2 = 1, a third of it.
        assert!((block.columns[3].values[0] - 1.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn smoothed_blocks_are_weighted_means_at_equal_distances() {
        let analysis = analysis(
            TimeMode::Smooth {
                width: 1.0,
                step: 2.0,
            },
            &["velocity"],
        );
        let states: Vec<State> = (0..=10)
            .map(|k| state(f64::from(k), f64::from(k), 0.5))
            .collect();
        let blocks = run(&analysis, states);
        let times: Vec<f64> = blocks.iter().map(|block| block.time).collect();
        assert_eq!(times, [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        // Symmetric weights of a linear course.
        for (k, frames) in [(2, 7), (3, 7)] {
            assert!((blocks[k].columns[0].values[0] - blocks[k].time).abs() < 1e-12);
            assert_eq!(blocks[k].frames, frames);
        }
        assert_eq!(blocks[0].frames, 4);
    }

    /// Frames at t = n h with velocities that grow as t^2. With weights w_j = exp(-(j h)^2 / (2 width^2)) of the frames n + j, up to 3 widths
    /// away, the mean at t is t^2 + h^2 sum(w_j j^2) / sum(w_j), and at the first frame, which has neighbours on one side only,
    /// h^2 sum(w_j j^2) / sum(w_j) over j >= 0.
    #[test]
    fn smoothed_blocks_have_the_weights_of_a_gaussian_of_their_width() {
        for (h, in_a_width) in [(0.25, 2), (0.5, 1), (0.125, 5)] {
            let width = h * f64::from(in_a_width);
            let analysis = analysis(TimeMode::Smooth { width, step: width }, &["velocity"]);
            let frames = 10 * in_a_width;
            let states = (0..=frames).map(|n| {
                let time = h * f64::from(n);
                state(time, time * time, 0.5)
            });
            let blocks = run(&analysis, states.collect());
            let reach = 3 * in_a_width;
            let spread = |first: i32| {
                let distance = |j: i32| h * f64::from(j);
                let weight = |j| libm::exp(-distance(j).powi(2) / (2.0 * width * width));
                let all: f64 = (first..=reach).map(weight).sum();
                let squares = (first..=reach).map(|j| weight(j) * distance(j).powi(2));
                squares.sum::<f64>() / all
            };
            // Round-off of a dozen sums.
            let check = |block: &Block, expected: f64| {
                let found = block.columns[0].values[0];
                assert!(
                    (found - expected).abs() < 1e-13 * expected.max(1.0),
                    "{found} {expected}"
                );
            };
            check(&blocks[0], spread(0));
            for block in &blocks[3..=7] {
                check(block, block.time * block.time + spread(-reach));
            }
            // An infinite fine sum has a spread of the variance width^2, less what is cut off at three widths.
            let cut = 1.0 - spread(-reach) / (width * width);
            assert!((0.0..0.05).contains(&cut), "{cut}");
        }
    }

    #[test]
    fn times_of_smoothed_blocks_are_multiples_without_the_round_off_of_a_sum() {
        let analysis = analysis(
            TimeMode::Smooth {
                width: 0.02,
                step: 0.02,
            },
            &["density"],
        );
        let states = (0..=35).map(|k| state(0.01 * f64::from(k), 1.0, 0.5));
        let times = run(&analysis, states.collect()).into_iter();
        let expected: Vec<f64> = (0..18).map(|k| 0.02 * f64::from(k)).collect();
        assert_eq!(times.map(|block| block.time).collect::<Vec<_>>(), expected);
    }

    #[test]
    fn displacements_are_the_shortest_way_since_the_frame_before() {
        let analysis = Analysis {
            reference: Reference::First,
            ..analysis(TimeMode::Frames, &["displacement"])
        };
        let mut states = vec![
            state(0.0, 0.0, 0.9),
            state(1.0, 0.0, 0.95),
            state(2.0, 0.0, 0.05),
        ];
        for state in &mut states {
            state.space.periodic[0] = true;
        }
        let values = |analysis: &Analysis| -> Vec<f64> {
            run(analysis, states.clone())
                .iter()
                .map(|block| block.columns[0].values[0])
                .collect()
        };
        let since_first = values(&analysis);
        let since_previous = values(&Analysis {
            reference: Reference::Previous,
            ..analysis
        });
        for (found, expected) in since_first
            .iter()
            .zip([0.0, 0.05, 0.15])
            .chain(since_previous.iter().zip([0.0, 0.05, 0.1]))
        {
            assert!(
                (found - expected).abs() < 1e-15,
                "{since_first:?} {since_previous:?}"
            );
        }
    }

    #[test]
    fn displacements_since_the_first_frame_go_round_the_domain() {
        let analysis = Analysis {
            reference: Reference::First,
            ..analysis(TimeMode::Frames, &["displacement"])
        };
        // 0.3 m from frame to frame in a domain of 1 m; a second particle comes in later.
        let states = (0..10u32).map(|k| {
            let mut state = state(f64::from(k), 0.0, (0.5 + 0.3 * f64::from(k)).fract());
            state.space.periodic[0] = true;
            if k >= 4 {
                let p = &mut state.particles;
                p.id.push(8);
                p.material.push(0);
                p.flowing.push(true);
                p.position.push(DVec3::splat(0.5));
                p.velocity.push(DVec3::ZERO);
                p.mass.push(2.0);
                p.volume.push(0.1);
                p.radius.push(0.1);
                p.angular_velocity.push(DVec3::ZERO);
                p.spin.push(DVec3::ZERO);
            }
            state
        });
        for (k, block) in run(&analysis, states.collect()).iter().enumerate() {
            let (found, expected) = (block.columns[0].values[0], 0.3 * k as f64);
            assert!((found - expected).abs() < 1e-14, "{k}: {found} {expected}");
        }
    }

    #[test]
    fn times_without_frames_are_reported() {
        let smooth = TimeMode::Smooth {
            width: 0.1,
            step: 0.5,
        };
        let analysis = analysis(smooth, &["density"]);
        // Means are at 0, 0.5, 1, ...; none of the frames is within 0.3 s of 0.5 s.
        let states = [0.0, 1.0, 2.0].map(|time| Ok(state(time, 1.0, 0.5)));
        let error = analysis.run(states.into_iter(), |_| Ok(())).unwrap_err();
        assert_eq!(
            error.to_string(),
            "--smooth: no frame within 3 widths of 0.1 s of t = 0.5: there are frames at 0 and 1 s\nhelp: a larger width"
        );
    }

    #[test]
    fn a_course_goes_on_from_its_memory() {
        let modes = [
            TimeMode::Frames,
            TimeMode::Average,
            TimeMode::Smooth {
                width: 1.0,
                step: 2.0,
            },
        ];
        for time in modes {
            let analysis = analysis(time, &["velocity", "granular_temperature", "displacement"]);
            let states: Vec<State> = (0..9)
                .map(|k| state(f64::from(k), f64::from(k * k % 7), 0.1 * f64::from(k)))
                .collect();
            let straight = run(&analysis, states.clone());
            for stop in 0..=states.len() {
                let mut blocks = Vec::new();
                let mut push = |block| {
                    blocks.push(block);
                    Ok(())
                };
                let mut course = Course::default();
                for (k, state) in states.iter().enumerate() {
                    if k == stop {
                        let memory = course.memory();
                        course = Course::remembering(&analysis, &memory).unwrap();
                        assert_eq!(course.memory(), memory);
                    }
                    course.add(&analysis, state.clone(), &mut push).unwrap();
                }
                let memory = course.memory();
                for cut in 0..memory.len() {
                    assert_eq!(Course::remembering(&analysis, &memory[..cut]), None);
                }
                course.finish(&analysis, &mut push).unwrap();
                // As text: NaN, where nothing was displaced yet, does not equal itself.
                assert_eq!(format!("{blocks:?}"), format!("{straight:?}"), "{stop}");
            }
        }
    }

    /// Errors are those of the series of each value, wherever a run stops, also once bins hold several frames.
    #[test]
    fn errors_are_those_of_batches_of_frames() {
        let analysis = analysis(TimeMode::Average, &["velocity"]);
        let state = |k: u32| state(f64::from(k), f64::from(k / 2 % 3 + k / 5), 0.5);
        for frames in [15, 16, 20, 300] {
            let mut record = Record::of_bins(BATCH_BINS);
            (0..frames).for_each(|k| record.add(state(k).particles.velocity[0].x));
            let expected = Batches::of(record.bins()).map(|batches| batches.error());
            assert_eq!(expected.is_some(), frames >= 16);
            for stop in (0..frames).step_by(7) {
                let mut course = Course::default();
                for k in 0..frames {
                    if k == stop {
                        course = Course::remembering(&analysis, &course.memory()).unwrap();
                    }
                    course.add(&analysis, state(k), |_| Ok(())).unwrap();
                }
                let block = course.mean(&analysis).unwrap();
                let found = block.columns[0].errors.as_ref().map(|errors| errors[0]);
                // A field is a quotient of sums over the kernel: round-off.
                match (found, expected) {
                    (Some(found), Some(expected)) => {
                        assert!((found / expected - 1.0).abs() < 1e-12, "{frames}, {stop}");
                    }
                    (found, expected) => assert_eq!(found, expected),
                }
            }
        }
    }

    #[test]
    fn what_is_good_is_used_before_what_is_damaged() {
        let analysis = analysis(TimeMode::Average, &["density"]);
        let states = vec![
            Ok(state(0.0, 1.0, 0.5)),
            Err(CgError::Input("cut".to_owned())),
            Ok(state(1.0, 1.0, 0.5)),
        ];
        let mut blocks = 0;
        let (frames, damage) = analysis
            .run(states.into_iter(), |_| {
                blocks += 1;
                Ok(())
            })
            .unwrap();
        assert_eq!((frames, blocks), (1, 1));
        assert_eq!(damage.unwrap().to_string(), "cut");
    }

    #[test]
    fn frames_of_other_dimensions_are_refused() {
        let analysis = analysis(TimeMode::Frames, &["density"]);
        let mut flat = state(1.0, 1.0, 0.5);
        flat.space.dimensions = 2;
        let error = analysis
            .run([Ok(state(0.0, 1.0, 0.5)), Ok(flat)].into_iter(), |_| Ok(()))
            .unwrap_err();
        assert_eq!(
            error.to_string(),
            "the frame at t = 1 has 2 dimensions, those before 3"
        );
    }
}
