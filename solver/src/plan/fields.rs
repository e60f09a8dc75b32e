//! `[[fields]]` as requests to coarse-graining.

use glam::DVec3;
use mercury_cg::CgError;
use mercury_cg::analysis::{Analysis, Reference, TimeMode};
use mercury_cg::input::equal_ball;
use mercury_cg::kernel::KernelShape;
use mercury_cg::options::{Cells, Limits, Spacing, Width, mirrors};
use mercury_cg::setup::Wanted;
use mercury_cg::state::{Particles, Space, State};
use mercury_common::scene::{Dimensions, FieldTable, FieldWidth, Scene, SceneError};

use super::particles::StartingParticles;
use mercury_engine::bodies::Clump;
use mercury_engine::boundaries::InsertionPlan;
use mercury_engine::state::{FIXED, PRESCRIBED};

/// The largest number of field tables of a scene: the schedule has one bit for each.
pub const MOST_FIELDS: usize = 64;

/// Most smoothed means.
const MOST_MEANS: f64 = 1e7;

/// Fields that a run computes as it goes, and when.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldPlan {
    /// Part of the file's name.
    pub name: String,
    /// Where, how and of what; limits and widths that are not given are those of the start.
    pub analysis: Analysis,
    /// Between two looks, s.
    pub interval: f64,
    /// No look before, s.
    pub from: f64,
    /// No look after, s.
    pub until: f64,
}

impl FieldPlan {
    /// Whether all samples make one mean, instead of a block each.
    #[must_use]
    pub fn is_mean(&self) -> bool {
        self.analysis.time == TimeMode::Average
    }

    /// Whether its fields follow from contacts, which are recorded for it then.
    #[must_use]
    pub fn needs_contacts(&self) -> bool {
        let mut fields = self.analysis.fields.iter();
        fields.any(|field| field.needs_contacts())
    }

    /// Whether it takes a sample at this time (s). Times are multiples of the step up to round-off, which a slack of 1e-6 of a
    /// step takes.
    #[must_use]
    pub fn looks_at(&self, time: f64, time_step: f64) -> bool {
        let slack = 1e-6 * time_step;
        (self.from - slack..=self.until + slack).contains(&time)
    }

    /// Samples of a run that ends at `end` (s), at most.
    #[must_use]
    pub fn looks(&self, end: f64) -> f64 {
        (self.until.min(end) - self.from).max(0.0) / self.interval + 2.0
    }

    /// Numbers in its table at the end of a run that ends at `end` (s), at most.
    #[must_use]
    pub fn numbers(&self, end: f64) -> f64 {
        let analysis = &self.analysis;
        let (blocks, each) = match analysis.time {
            TimeMode::Frames => (self.looks(end), 1),
            TimeMode::Average => (1.0, 2),
            TimeMode::Smooth { step, .. } => {
                let looks = self.looks(end) * self.interval;
                (looks.min(end + self.interval) / step + 1.0, 1)
            }
        };
        let columns = 1 + analysis.evaluator.coordinates.names().len() + each * analysis.numbers();
        blocks * analysis.evaluator.place.len() as f64 * columns as f64
    }
}

/// All field tables, in the order of the file; each is tried on the state of the start.
pub(super) fn fields(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Vec<FieldPlan> {
    if let Some(one_more) = scene.fields.get(MOST_FIELDS) {
        let message = format!("there are more than {MOST_FIELDS} tables of fields");
        errors.push(one_more.place.error(message));
        return Vec::new();
    }
    if scene.fields.is_empty() {
        return Vec::new();
    }
    let materials = scene.materials.iter();
    let materials: Vec<String> = materials.map(|one| one.name.value.clone()).collect();
    let first = first_state(scene, start, clumps);
    // Where nothing flows yet, widths are in diameters of inserted particles.
    let flows = first.particles.flowing.contains(&true);
    let coming = if flows {
        None
    } else {
        mean_diameter(insertions)
    };
    let mut planned = Vec::new();
    for table in &scene.fields {
        let from = table.from.as_deref().copied().unwrap_or(0.0);
        let until = table.until.as_deref().copied().unwrap_or(f64::INFINITY);
        if let Some(end) = table.until.as_ref().filter(|_| until < from) {
            let message = format!("must not be before `from` = {from} s, got {until}");
            errors.push(end.error(message));
        }
        if from > *scene.time.end {
            let end = *scene.time.end;
            warnings.push(format!(
                "{}: `{}` takes no sample: the run ends at {end} s, `from` is {from} s",
                table.place.key(),
                table.name.value
            ));
        }
        if let Some(smooth) = &table.smooth {
            let interval = **table.interval.as_ref().unwrap_or(&scene.output.interval);
            if let Some(found) = smoothing(smooth.value, interval, *scene.time.end) {
                errors.push(smooth.place.error(found));
            }
        }
        match analysis(table, &materials, &first, coming) {
            Ok(analysis) => planned.push(FieldPlan {
                name: table.name.value.clone(),
                analysis,
                interval: **table.interval.as_ref().unwrap_or(&scene.output.interval),
                from,
                until,
            }),
            Err(error) => errors.push(refused(table, &error)),
        }
    }
    planned
}

/// The error in a width and a step (s) of smoothing over samples every `interval` (s) until `end` (s).
fn smoothing([width, step]: [f64; 2], interval: f64, end: f64) -> Option<String> {
    if end / step > MOST_MEANS {
        return Some(format!("means every {step} s are more than {MOST_MEANS:e}"));
    }
    (width < 0.5 * interval).then(|| {
        format!(
            "a width of {width} s smooths nothing: samples are {interval} s apart; at least half of that"
        )
    })
}

/// The error of coarse-graining in the terms of a scene: its options are the keys of the table.
fn refused(table: &FieldTable, error: &CgError) -> SceneError {
    if let CgError::Format(error) = error {
        // The one file that is read here.
        return table.place_of("points").error(error.to_string());
    }
    let text = error.to_string();
    let (found, help) = match text.split_once("\nhelp: ") {
        Some((found, help)) => (found, Some(help)),
        None => (&text[..], None),
    };
    let (place, found) = match found
        .strip_prefix("--")
        .and_then(|rest| rest.split_once(": "))
    {
        // The place names the key.
        Some((key, rest)) if !key.contains(' ') => (table.place_of(key), rest),
        Some((option, _)) => {
            let (key, value) = option.split_once(' ').unwrap_or((option, ""));
            let named = table
                .fields
                .iter()
                .find(|name| name.to_lowercase() == value);
            let place = named.map_or(table.place_of(key), |name| &name.place);
            (place, found)
        }
        None if found.contains("width") => (table.place_of("width"), found),
        None => (&table.name.place, found),
    };
    let named = found.rsplit(' ').next().unwrap_or_default();
    let named = table
        .fields
        .iter()
        .find(|name| name.to_lowercase() == named);
    let place = named.map_or(place, |name| &name.place);
    let error = place.error(with_keys(found));
    match help {
        Some(help) => error.with_help(with_keys(help)),
        None => error,
    }
}

/// Options of the command line as keys of a scene: `--by-material` is `by_material`.
fn with_keys(text: &str) -> String {
    let mut pieces = text.split("--");
    let mut out = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let is_part = |c: char| c.is_ascii_lowercase() || c == '-';
        let end = piece.find(|c| !is_part(c)).unwrap_or(piece.len());
        let (option, rest) = piece.split_at(end);
        out += &format!("`{}`{rest}", option.replace('-', "_"));
    }
    out
}

/// Mean diameter by number of inserted particles, m; of clumps that of a sphere of equal volume.
fn mean_diameter(insertions: &[InsertionPlan]) -> Option<f64> {
    let parts = insertions.iter().flat_map(|insertion| &insertion.mixture);
    let (mut sum, mut shares) = (0.0, 0.0);
    for part in parts {
        sum += part.share * part.sizes.mean_diameter();
        shares += part.share;
    }
    (sum > 0.0).then(|| sum / shares)
}

/// The request of a table; `coming`: the diameter in which widths are given if not that of the first particles, m.
fn analysis(
    table: &FieldTable,
    materials: &[String],
    first: &State,
    coming: Option<f64>,
) -> Result<Analysis, CgError> {
    let wrong = |key: &str, found: String| CgError::Input(format!("--{key}: {found}"));
    let coordinates = match &table.coordinates {
        Some(word) => Some(word.parse().map_err(|found| wrong("coordinates", found))?),
        None => None,
    };
    let faces: Vec<&str> = table.mirror.iter().map(|face| face.as_str()).collect();
    let mirrors = if faces.is_empty() {
        Ok(Default::default())
    } else {
        mirrors(&faces.join(","))
    };
    let cells = |grid: &Vec<u64>| Cells(grid.iter().map(|&n| n as usize).collect());
    let width = table.width.as_deref().map(|width| match *width {
        FieldWidth::Metres(width) => Width::Metres(width),
        FieldWidth::Diameters(times) => Width::Diameters(times),
    });
    let limits = table.limits.iter();
    let limits = limits.map(|(name, range)| ((*name).to_owned(), range[0], range[1]));
    let wanted = Wanted {
        fields: table
            .fields
            .iter()
            .map(|name| name.to_lowercase())
            .collect(),
        coordinates,
        grid: table.grid.as_deref().map(cells),
        spacing: table.spacing.as_deref().map(|sizes| Spacing(sizes.clone())),
        limits: Limits(limits.collect()),
        points: table.points.as_deref().cloned(),
        shape: match table.kernel {
            "lucy" => KernelShape::Lucy,
            "linear" => KernelShape::Linear,
            "heaviside" => KernelShape::Heaviside,
            _ => KernelShape::Gaussian,
        },
        width: match coming {
            Some(diameter) => {
                let width = width.unwrap_or(Width::Diameters(1.0));
                Some(Width::Metres(width.metres(diameter)))
            }
            None => width,
        },
        cutoff: table.cutoff.as_deref().copied(),
        tolerance: table.tolerance.as_deref().copied(),
        mirrors: mirrors.map_err(|found| wrong("mirror", found))?,
        axis: table.axis,
        through: table.through.as_deref().copied(),
        materials: (table.materials.iter())
            .map(|index| materials[index.value.0].clone())
            .collect(),
        by_material: table.by_material,
        time: match (table.average, table.smooth.as_deref()) {
            (true, _) => Some(TimeMode::Average),
            (false, Some(&[width, step])) => Some(TimeMode::Smooth { width, step }),
            (false, None) => None,
        },
        reference: if table.since_first {
            Reference::First
        } else {
            Reference::Previous
        },
        errors: true,
        ..Wanted::default()
    };
    wanted.analysis(materials, first, wanted.chosen(true)?)
}

/// The particles of the start, as far as limits, widths and materials follow from them.
fn first_state(scene: &Scene, start: &StartingParticles, clumps: &[Clump]) -> State {
    let dimensions = match scene.domain.dimensions {
        Dimensions::Two => 2,
        Dimensions::Three => 3,
    };
    let mut particles = Particles::default();
    let mut push = |material: u32, flows: bool, position: DVec3, radius: f64| {
        particles.material.push(material);
        particles.flowing.push(flows);
        particles.position.push(position);
        particles.radius.push(radius);
    };
    for new in &start.particles {
        let flows = !new.fixed && !new.is_prescribed();
        push(new.material.number(), flows, new.position, new.radius);
    }
    for new in &start.bodies {
        let body = new.body(clumps);
        let flows = body.flags & (FIXED | PRESCRIBED) == 0;
        let radius = equal_ball(body.volume, dimensions);
        push(body.material.number(), flows, body.position, radius);
    }
    State {
        space: Space {
            min: *scene.domain.min,
            max: *scene.domain.max,
            periodic: scene.domain.periodic,
            dimensions,
        },
        particles,
        ..State::default()
    }
}
