//! The sizes that a run inserted, and the distribution that its scene sets.
//!
//! Sizes come from the frames, targets from `plan.toml`: both are in the run folder.

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::frames::{BodyReader, FLAG_FIXED, FLAG_PRESCRIBED, ParticleReader};
use mercury_common::readable::{rounded, shortened};
use mercury_common::scene::{SceneErrors, parse_psd};
use mercury_common::sizes::{SizeDistribution, SizeError};
use toml::{Table, Value};

/// Why a folder cannot be checked.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// No run, or not one that can be checked.
    #[error("{}: {what}", .path.display())]
    Folder {
        /// The folder or a file in it.
        path: PathBuf,
        /// Description of the problem, with advice.
        what: String,
    },
    /// A file of the run is damaged.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A distribution in `plan.toml` cannot be read.
    #[error(transparent)]
    Law(#[from] SceneErrors),
    /// A distribution in `plan.toml` cannot be drawn from.
    #[error(transparent)]
    Sizes(#[from] SizeError),
}

/// Selection of particles of a run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Selection {
    /// Time (s) of the particles, by the nearest frame; none: all that were ever inserted.
    pub at: Option<f64>,
    /// Only where all of these hold when they are looked at (all that were ever inserted: when they first appear).
    pub place: Vec<Condition>,
}

/// A half-space: a coordinate below or above a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    axis: usize,
    is_below: bool,
    value: f64,
}

impl Condition {
    /// Reads conditions such as `z<0.05` or `x>=0,z<0.1`.
    ///
    /// # Errors
    /// The text is not a list of conditions.
    pub fn parse_all(text: &str) -> Result<Vec<Self>, String> {
        text.split(',').map(Self::parse).collect()
    }

    fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let wrong = || format!("\"{text}\" is no condition: expected one such as z<0.05 or x>=0");
        let sign = text.find(['<', '>']).ok_or_else(wrong)?;
        let axis = match text[..sign].trim() {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return Err(wrong()),
        };
        let value = text[sign + 1..].trim_start_matches('=').trim();
        let value: f64 = value.parse().map_err(|_| wrong())?;
        if !value.is_finite() {
            return Err(wrong());
        }
        Ok(Self {
            axis,
            is_below: text.as_bytes()[sign] == b'<',
            value,
        })
    }

    fn holds(&self, position: DVec3) -> bool {
        let at = position[self.axis];
        if self.is_below {
            at < self.value
        } else {
            at >= self.value
        }
    }
}

/// Particles of one kind.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Group {
    /// Diameters, m; of clumps that of the sphere of equal volume.
    pub diameters: Vec<f64>,
    /// Their mass, kg.
    pub mass: f64,
}

/// Target of a kind of particles.
#[derive(Debug, Clone)]
pub struct Target {
    /// Its sizes.
    pub sizes: SizeDistribution,
    /// The mass that the scene sets, kg, if it does.
    pub mass: Option<f64>,
    /// Number of quotas that the sizes come by; 0: at random, some or all.
    pub quotas: usize,
}

/// A run folder.
#[derive(Debug)]
pub struct Run {
    folder: PathBuf,
    prefix: PathBuf,
    plan: Table,
}

impl Run {
    /// Opens a folder that `mercury-solve` wrote.
    ///
    /// # Errors
    /// [`RunError::Folder`] where it is none.
    pub fn open(folder: &Path) -> Result<Self, RunError> {
        let wrong = |what: String| RunError::Folder {
            path: folder.to_owned(),
            what,
        };
        let entries = std::fs::read_dir(folder)
            .map_err(|e| wrong(format!("the folder cannot be read: {e}")))?;
        let mut found: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                name.ends_with(".particles.arrow")
            })
            .collect();
        found.sort();
        let [frames] = &found[..] else {
            return Err(wrong(match found.len() {
                0 => "no run: there is no file *.particles.arrow in it".to_owned(),
                n => format!("{n} files *.particles.arrow: a run has one"),
            }));
        };
        let name = frames.to_string_lossy();
        let prefix = name.strip_suffix(".particles.arrow").unwrap_or(&name);
        let path = folder.join("plan.toml");
        let plan = match std::fs::read_to_string(&path) {
            Ok(text) => text
                .parse()
                .map_err(|e: toml::de::Error| RunError::Folder {
                    path,
                    what: format!(
                        "the plan cannot be read: {}",
                        shortened(&e.to_string(), 500)
                    ),
                })?,
            // Frames alone can be checked against a target that is given.
            Err(_) => Table::new(),
        };
        Ok(Self {
            folder: folder.to_owned(),
            prefix: PathBuf::from(prefix),
            plan,
        })
    }

    fn wrong(&self, what: impl Into<String>) -> RunError {
        RunError::Folder {
            path: self.folder.clone(),
            what: what.into(),
        }
    }

    /// Sizes of the inserted particles by kind: the material of spheres, the name of clumps.
    ///
    /// Particles that the scene puts at the start, fixed ones, and those whose motion is prescribed are not inserted.
    ///
    /// # Errors
    /// [`RunError::Format`] where a file is damaged, [`RunError::Folder`] where there is no such frame.
    pub fn sizes(&self, selection: &Selection) -> Result<BTreeMap<String, Group>, RunError> {
        let mut groups = BTreeMap::new();
        self.spheres(selection, &mut groups)?;
        self.bodies(selection, &mut groups)?;
        Ok(groups)
    }

    fn with_suffix(&self, suffix: &str) -> PathBuf {
        let mut name = self.prefix.clone().into_os_string();
        name.push(suffix);
        name.into()
    }

    fn number(&self, section: &str, key: &str) -> u32 {
        let value = self.plan.get(section).and_then(|table| table.get(key));
        let number = value.and_then(Value::as_integer).unwrap_or(0);
        u32::try_from(number).unwrap_or(u32::MAX)
    }

    fn spheres(
        &self,
        selection: &Selection,
        groups: &mut BTreeMap<String, Group>,
    ) -> Result<(), RunError> {
        let reader = ParticleReader::open(self.with_suffix(".particles.arrow"))?;
        let first = (self.number("particles", "at_start"))
            .saturating_add(self.number("particles", "pebbles_at_start"));
        let times: Vec<f64> = reader.frames().infos().map(|info| info.time).collect();
        let mut seen = SeenIds::default();
        for k in self.frames(&times, selection)? {
            let frame = reader.frame(k)?;
            for i in 0..frame.len() {
                let body = frame.body.as_ref().and_then(|bodies| bodies[i]);
                let is_driven = frame.flags[i] & (FLAG_FIXED | FLAG_PRESCRIBED) != 0;
                if body.is_some() || is_driven || frame.id[i] < first || !seen.add(frame.id[i]) {
                    continue;
                }
                if !selection.place.iter().all(|c| c.holds(frame.position[i])) {
                    continue;
                }
                let material = frame.material[i] as usize;
                let name = reader.header().materials.get(material).cloned();
                let group = groups
                    .entry(name.unwrap_or_else(|| format!("material {material}")))
                    .or_default();
                group.diameters.push(2.0 * frame.radius[i]);
                group.mass += frame.mass[i];
            }
        }
        Ok(())
    }

    fn bodies(
        &self,
        selection: &Selection,
        groups: &mut BTreeMap<String, Group>,
    ) -> Result<(), RunError> {
        let path = self.with_suffix(".bodies.arrow");
        if !path.exists() {
            return Ok(());
        }
        let reader = BodyReader::open_alone(&path)?;
        let first = self.number("particles", "bodies_at_start");
        let times: Vec<f64> = reader.frames().infos().map(|info| info.time).collect();
        let mut seen = SeenIds::default();
        for k in self.frames(&times, selection)? {
            let frame = reader.frame(k)?;
            for i in 0..frame.len() {
                let is_driven = frame.flags[i] & (FLAG_FIXED | FLAG_PRESCRIBED) != 0;
                if is_driven || frame.id[i] < first || !seen.add(frame.id[i]) {
                    continue;
                }
                if !selection.place.iter().all(|c| c.holds(frame.position[i])) {
                    continue;
                }
                let clump = frame.clump[i] as usize;
                let name = reader.kinds().get(clump).map(|kind| kind.name.clone());
                let group = groups
                    .entry(name.unwrap_or_else(|| format!("clump {clump}")))
                    .or_default();
                group.diameters.push(libm::cbrt(6.0 * frame.volume[i] / PI));
                group.mass += frame.mass[i];
            }
        }
        Ok(())
    }

    /// The frames to look at.
    fn frames(&self, times: &[f64], selection: &Selection) -> Result<Vec<usize>, RunError> {
        let Some(at) = selection.at else {
            return Ok((0..times.len()).collect());
        };
        let nearest = (0..times.len())
            .min_by(|&a, &b| (times[a] - at).abs().total_cmp(&(times[b] - at).abs()));
        let (Some(nearest), Some(last)) = (nearest, times.last()) else {
            return Err(self.wrong("the run has no frames"));
        };
        if at < 0.0 || at > last * (1.0 + 1e-6) {
            return Err(self.wrong(format!(
                "no frame at {at} s: the run goes from 0 to {} s",
                rounded(*last, 6)
            )));
        }
        Ok(vec![nearest])
    }

    /// Target of each kind. A kind that several insertions bring with different distributions has none.
    ///
    /// # Errors
    /// Where the plan has no sizes, or they cannot be read.
    pub fn targets(&self) -> Result<BTreeMap<String, Target>, RunError> {
        let mut targets: BTreeMap<String, (Target, Table)> = BTreeMap::new();
        let mut ambiguous = Vec::new();
        for insertion in tables(&self.plan, "insertions") {
            let parts: Vec<&Table> = tables(insertion, "mixture").collect();
            let mut sizes = Vec::new();
            for part in &parts {
                let Some(psd) = part.get("psd").and_then(Value::as_table) else {
                    return Err(self.wrong(
                        "plan.toml holds no size distributions, as of an older version: give --target FILE",
                    ));
                };
                let place = self.folder.join("plan.toml");
                let law = parse_psd(&place.display().to_string(), &psd.to_string(), None)?;
                sizes.push((SizeDistribution::from_scene(&law)?, psd));
            }
            let masses = self.requested(insertion, &parts, &sizes);
            let method = insertion.get("method").and_then(Value::as_str);
            let quotas = usize::from(method == Some("quota"));
            for (index, (part, (sizes, psd))) in parts.iter().zip(sizes).enumerate() {
                let name = part
                    .get("clump")
                    .or(part.get("material"))
                    .and_then(Value::as_str);
                let name = name.unwrap_or_default().to_owned();
                let mass = masses.as_ref().map(|masses| masses[index]);
                match targets.get_mut(&name) {
                    Some((target, known)) if known == psd => {
                        target.mass = target.mass.zip(mass).map(|(a, b)| a + b);
                        target.quotas = match (target.quotas, quotas) {
                            (0, _) | (_, 0) => 0,
                            (before, these) => before + these,
                        };
                    }
                    Some(_) => ambiguous.push(name),
                    None => {
                        let target = Target {
                            sizes,
                            mass,
                            quotas,
                        };
                        targets.insert(name, (target, psd.clone()));
                    }
                }
            }
        }
        for name in ambiguous {
            targets.remove(&name);
        }
        Ok(targets
            .into_iter()
            .map(|(name, (target, _))| (name, target))
            .collect())
    }

    /// The mass of each part of an insertion (kg), where its total gives it.
    fn requested(
        &self,
        insertion: &Table,
        parts: &[&Table],
        sizes: &[(SizeDistribution, &Table)],
    ) -> Option<Vec<f64>> {
        let total = insertion.get("total")?.as_table()?;
        let density = |name: &str| {
            let material = tables(&self.plan, "materials")
                .find(|material| material.get("name").and_then(Value::as_str) == Some(name))?;
            material.get("density").and_then(Value::as_float)
        };
        let domain = self.plan.get("domain").and_then(Value::as_table);
        let dimensions = domain.and_then(|domain| domain.get("dimensions")?.as_integer());
        let is_flat = dimensions == Some(2);
        let mut volumes = Vec::new();
        let mut masses = Vec::new();
        let mut numbers = Vec::new();
        for (part, (sizes, _)) in parts.iter().zip(sizes) {
            let number = part.get("number_share").and_then(Value::as_float)?;
            // Discs are as thick as 1 m, and their volumes are areas.
            let volume = number
                * if is_flat {
                    0.25 * PI * sizes.moment(2)
                } else {
                    sizes.mean_volume()
                };
            numbers.push(number);
            volumes.push(volume);
            masses.push(volume * density(part.get("material")?.as_str()?)?);
        }
        let (key, value) = total.iter().next()?;
        let value = value.as_float().or(value.as_integer().map(|n| n as f64))?;
        let per_total = match key.as_str() {
            "number" => numbers.iter().sum::<f64>(),
            "volume" => volumes.iter().sum(),
            "mass" => masses.iter().sum(),
            _ => return None,
        };
        Some(masses.iter().map(|mass| value * mass / per_total).collect())
    }
}

fn tables<'a>(table: &'a Table, key: &str) -> impl Iterator<Item = &'a Table> {
    let list = table.get(key).and_then(Value::as_array);
    list.into_iter().flatten().filter_map(Value::as_table)
}

/// Ids that were met: a bit for each, in pages of 512, as a single large number must not take the memory of all below it.
#[derive(Default)]
struct SeenIds(HashMap<u32, [u64; 8]>);

impl SeenIds {
    /// Whether the id is new.
    fn add(&mut self, id: u32) -> bool {
        let page = self.0.entry(id / 512).or_default();
        let (word, bit) = (id as usize % 512 / 64, 1 << (id % 64));
        let is_new = page[word] & bit == 0;
        page[word] |= bit;
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_half_spaces() {
        let all = Condition::parse_all("z<0.05, x >= -1e-2").expect("two");
        assert!(all.iter().all(|c| c.holds(DVec3::new(0.0, 9.0, 0.0))));
        assert!(!all[0].holds(DVec3::new(0.0, 0.0, 0.05)));
        assert!(!all[1].holds(DVec3::new(-0.02, 0.0, 0.0)));
        for text in ["", "z", "r<1", "z<", "z<nan", "z<1,"] {
            assert!(Condition::parse_all(text).is_err(), "{text}");
        }
    }

    #[test]
    fn ids_are_new_once() {
        let mut seen = SeenIds::default();
        assert!(seen.add(1000));
        assert!(seen.add(0));
        assert!(!seen.add(1000));
        for id in [u32::MAX, u32::MAX - 64, 1001, 511, 512] {
            assert!(seen.add(id) && !seen.add(id), "{id}");
        }
    }

    /// 500 discs, or spheres, uniform between 10 and 20 mm: the means of d^2 and d^3 are (a^2 + a b + b^2) / 3 and (a + b) (a^2 + b^2) / 4.
    #[test]
    fn the_mass_that_was_requested_is_that_of_discs_in_the_plane() {
        let run = |dimensions: u8| {
            Run {
            folder: PathBuf::new(),
            prefix: PathBuf::new(),
            plan: format!(
                "[domain]\ndimensions = {dimensions}\n[[materials]]\nname = \"m\"\ndensity = 1000.0\n\
                 [[insertions]]\nname = \"feed\"\ntotal = {{ number = 500 }}\n\
                 [[insertions.mixture]]\nmaterial = \"m\"\nnumber_share = 1.0\n[insertions.mixture.psd]\n\
                 kind = \"uniform\"\nmin_diameter = 0.01\nmax_diameter = 0.02\nweighting = \"number\"\n"
            )
            .parse()
            .expect("TOML"),
        }
        };
        for (dimensions, volume) in [
            (2, PI / 4.0 * 7e-4 / 3.0),
            (3, PI / 6.0 * 0.03 * 5e-4 / 4.0),
        ] {
            let targets = run(dimensions).targets().expect("targets");
            let mass = targets["m"].mass.expect("a mass");
            let expected = 500.0 * 1000.0 * volume;
            assert!((mass / expected - 1.0).abs() < 1e-12, "{mass} {expected}");
        }
    }
}
