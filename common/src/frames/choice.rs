//! A choice of frames, as command lines take it.

use std::str::FromStr;

/// Choice of frames of an input, by their numbers from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrameChoice {
    /// All of them.
    #[default]
    All,
    /// The last one.
    Last,
    /// From a number on, up to a number or without end, every so many.
    Range {
        /// The first.
        from: usize,
        /// The first that is not used any more.
        to: Option<usize>,
        /// Distance from one to the next.
        every: usize,
    },
}

impl FrameChoice {
    /// Whether a frame is chosen; [`Self::Last`] has to be found otherwise.
    #[must_use]
    pub fn has(&self, number: usize) -> bool {
        match *self {
            Self::All => true,
            Self::Last => false,
            Self::Range { from, to, every } => {
                number >= from
                    && to.is_none_or(|to| number < to)
                    && (number - from).is_multiple_of(every)
            }
        }
    }

    /// Whether no frame from this one on is chosen.
    #[must_use]
    pub fn ends_before(&self, number: usize) -> bool {
        matches!(self, Self::Range { to: Some(to), .. } if number >= *to)
    }
}

impl FromStr for FrameChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "expected all, last, a number, A..B (without B), A.., ..B, \"every N\", or a range with a stride, A..B/N".to_owned()
        };
        let number = |text: &str| text.trim().parse::<usize>().map_err(|_| wrong());
        let text = text.trim();
        match text {
            "all" => return Ok(Self::All),
            "last" => return Ok(Self::Last),
            _ => {}
        }
        let stride = |every: usize| if every > 0 { Ok(every) } else { Err(wrong()) };
        if let Some(every) = text.strip_prefix("every") {
            return Ok(Self::Range {
                from: 0,
                to: None,
                every: stride(number(every)?)?,
            });
        }
        let (range, every) = match text.split_once('/') {
            Some((range, every)) => (range, stride(number(every)?)?),
            None => (text, 1),
        };
        if let Some((from, to)) = range.split_once("..") {
            let from = if from.trim().is_empty() {
                0
            } else {
                number(from)?
            };
            let to = if to.trim().is_empty() {
                None
            } else {
                Some(number(to)?)
            };
            return Ok(Self::Range { from, to, every });
        }
        let one = number(text)?;
        Ok(Self::Range {
            from: one,
            to: Some(one.saturating_add(1)),
            every: 1,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_chosen_in_every_spelling() {
        let chosen = |text: &str| {
            let choice: FrameChoice = text.parse().unwrap();
            (0..8).filter(|&k| choice.has(k)).collect::<Vec<usize>>()
        };
        assert_eq!(chosen("all").len(), 8);
        assert_eq!(chosen("2..5"), [2, 3, 4]);
        assert_eq!(chosen("..3"), [0, 1, 2]);
        assert_eq!(chosen("6.."), [6, 7]);
        assert_eq!(chosen("3"), [3]);
        assert_eq!(chosen("every 3"), [0, 3, 6]);
        assert_eq!(chosen("1..7/2"), [1, 3, 5]);
        assert_eq!(chosen("18446744073709551615"), [0; 0]);
        assert_eq!("last".parse(), Ok(FrameChoice::Last));
        for bad in [
            "", "first", "-1", "every 0", "every", "1..x", "1.5", "1..5/0",
        ] {
            let error = bad.parse::<FrameChoice>().unwrap_err();
            assert!(error.starts_with("expected all, last"), "{bad}: {error}");
        }
        let range: FrameChoice = "2..4".parse().unwrap();
        assert!(range.ends_before(4) && !range.ends_before(3));
    }
}
