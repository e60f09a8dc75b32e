//! Choice of frames.

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
        if let Some(every) = text.strip_prefix("every ") {
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
