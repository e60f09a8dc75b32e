//! A course as words and back, so that a run that is interrupted goes on with its means.

use std::collections::{HashMap, VecDeque};

use mercury_common::statistics::{BATCH_BINS, Record};

use super::{Course, Open, Way};
use crate::analysis::words::{Reader, Words};
use crate::analysis::{Analysis, TimeMode};
use crate::state::Space;
use crate::sums::{SPREADS, Sums};

impl Course {
    /// All that it remembers; [`Course::remembering`] goes on from there to the same bits.
    #[must_use]
    pub fn memory(&self) -> Vec<u64> {
        let mut words = Words::default();
        words.count(self.frames);
        words.count(self.dimensions.map_or(0, usize::from));
        words.flag(self.before.is_some());
        if let Some(before) = &self.before {
            let mut before: Vec<_> = before.iter().collect();
            // Sorted, so that equal memories have equal words.
            before.sort_unstable_by_key(|(id, _)| **id);
            words.count(before.len());
            for (&id, way) in before {
                words.count(id as usize);
                words.vector(way.at);
                words.vector(way.come);
            }
        }
        words.count(self.open.len());
        for open in &self.open {
            open.put(&mut words);
        }
        words.flag(self.next_time.is_some());
        if let Some((first, next)) = self.next_time {
            words.number(first);
            words.count(next);
        }
        words.flag(self.last_time.is_some());
        words.number(self.last_time.unwrap_or(0.0));
        words.count(self.records.len());
        for record in &self.records {
            let numbers = record.numbers();
            words.count(numbers.len());
            words.numbers(&numbers);
        }
        words.0
    }

    /// Course from the words that a course of the same analysis gave; nothing if they cannot be from one of the same.
    #[must_use]
    pub fn remembering(analysis: &Analysis, memory: &[u64]) -> Option<Self> {
        let mut words = Reader(memory);
        let frames = words.count()?;
        let dimensions = match words.count()? {
            0 => None,
            dimensions @ 2..=3 => Some(dimensions as u8),
            _ => return None,
        };
        let before = if words.flag()? {
            let count = words.count()?;
            let entry = |_| {
                let id = words.word()?.try_into().ok()?;
                let (at, come) = (words.vector()?, words.vector()?);
                Some((id, Way { at, come }))
            };
            Some((0..count).map(entry).collect::<Option<HashMap<_, _>>>()?)
        } else {
            None
        };
        let count = words.count()?;
        let open = (0..count).map(|_| Open::take(&mut words, analysis));
        let open: VecDeque<Open> = open.collect::<Option<_>>()?;
        let next_time = if words.flag()? {
            Some((words.number()?, words.count()?))
        } else {
            None
        };
        let (is_known, time) = (words.flag()?, words.number()?);
        let last_time = is_known.then_some(time);
        // One word at least of each: a wrong number ends with the words.
        let count = words.count()?;
        let record = |_| {
            let numbers = words.count()?;
            Record::from_numbers(BATCH_BINS, &words.numbers(numbers)?)
        };
        let records = (0..count).map(record).collect::<Option<Vec<Record>>>()?;
        let values = analysis.numbers() * analysis.evaluator.place.len();
        let has_records = records.is_empty() || records.len() == values;
        let is_mean = analysis.time == TimeMode::Average;
        let fits =
            words.0.is_empty() && has_records && (!is_mean || (frames == 0) == open.is_empty());
        fits.then_some(Self {
            frames,
            dimensions,
            before,
            open,
            next_time,
            last_time,
            records,
            ..Self::default()
        })
    }
}

impl Open {
    fn put(&self, words: &mut Words) {
        words.numbers(&[self.time, self.weight]);
        words.count(self.frames);
        words.numbers(&[self.span.0, self.span.1]);
        words.vector(self.space.min);
        words.vector(self.space.max);
        for periodic in self.space.periodic {
            words.flag(periodic);
        }
        words.count(self.space.dimensions.into());
        for values in self.parts.iter().flat_map(|sums| &sums.values) {
            words.numbers(values);
        }
    }

    fn take(words: &mut Reader<'_>, analysis: &Analysis) -> Option<Self> {
        let (time, weight) = (words.number()?, words.number()?);
        let frames = words.count()?;
        let span = (words.number()?, words.number()?);
        let (min, max) = (words.vector()?, words.vector()?);
        let periodic = [words.flag()?, words.flag()?, words.flag()?];
        let dimensions = words.count()?.try_into().ok()?;
        let (layout, points) = (analysis.layout(), analysis.evaluator.place.len());
        let sums = |_| {
            let mut sums = Sums {
                layout: layout.clone(),
                points,
                values: Default::default(),
            };
            for (values, spread) in sums.values.iter_mut().zip(SPREADS) {
                *values = words.numbers(points * layout.stride(spread))?;
            }
            Some(sums)
        };
        let parts = analysis.parts.iter().map(sums).collect::<Option<_>>()?;
        let space = Space {
            min,
            max,
            periodic,
            dimensions,
        };
        Some(Self {
            time,
            weight,
            frames,
            span,
            space,
            parts,
        })
    }
}
