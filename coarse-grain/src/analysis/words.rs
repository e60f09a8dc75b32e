//! Numbers as words of 64 bits and back, bit by bit: the state of a course in a form that can be stored.

use glam::DVec3;

/// Words in the making.
#[derive(Debug, Default)]
pub(crate) struct Words(pub(crate) Vec<u64>);

impl Words {
    pub(crate) fn count(&mut self, count: usize) {
        self.0.push(count as u64);
    }

    pub(crate) fn flag(&mut self, flag: bool) {
        self.0.push(u64::from(flag));
    }

    pub(crate) fn number(&mut self, number: f64) {
        self.0.push(number.to_bits());
    }

    pub(crate) fn numbers(&mut self, numbers: &[f64]) {
        self.0.extend(numbers.iter().map(|number| number.to_bits()));
    }

    pub(crate) fn vector(&mut self, vector: DVec3) {
        self.numbers(&vector.to_array());
    }
}

/// Words that are still to be read. All that is taken is `None` where they end, or hold an impossible value.
#[derive(Debug)]
pub(crate) struct Reader<'a>(pub(crate) &'a [u64]);

impl Reader<'_> {
    fn words(&mut self, count: usize) -> Option<&[u64]> {
        let (front, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(front)
    }

    pub(crate) fn word(&mut self) -> Option<u64> {
        self.words(1).map(|words| words[0])
    }

    pub(crate) fn count(&mut self) -> Option<usize> {
        self.word()?.try_into().ok()
    }

    pub(crate) fn flag(&mut self) -> Option<bool> {
        match self.word()? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }

    pub(crate) fn number(&mut self) -> Option<f64> {
        self.word().map(f64::from_bits)
    }

    pub(crate) fn numbers(&mut self, count: usize) -> Option<Vec<f64>> {
        let words = self.words(count)?;
        Some(words.iter().map(|&word| f64::from_bits(word)).collect())
    }

    pub(crate) fn vector(&mut self) -> Option<DVec3> {
        self.numbers(3).map(|v| DVec3::new(v[0], v[1], v[2]))
    }
}
