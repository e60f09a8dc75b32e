//! The calls of an engine that all ranks make together: those of the first rank, which the others follow.

use crate::forces::Watch;
use crate::ranks::END;
use crate::state::Plain;

/// How the engines of all ranks begin.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Beginning {
    /// From the plan; the contacts of the start are recorded one by one or not.
    Start {
        /// Whether they are.
        records: bool,
    },
    /// From an encoded state.
    Resume(Vec<u8>),
    /// They do not: the first rank has found a reason.
    Never,
}

/// A call that the first rank makes, and all others with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Call {
    /// [`Engine::steps_at_once`](crate::step::Engine::steps_at_once).
    Steps {
        /// Their number.
        count: u64,
        /// Observation to make in the last one.
        watch: Option<Watch>,
    },
    /// [`Engine::complete_step`](crate::step::Engine::complete_step).
    CompleteStep,
    /// [`Engine::collect`](crate::step::Engine::collect).
    Collect {
        /// Also the contacts.
        contacts: bool,
    },
    /// [`Core::take_feature_loads`](crate::step::Core::take_feature_loads).
    TakeFeatureLoads,
    /// The run is over.
    End,
}

impl Plain for Beginning {
    fn put(&self, bytes: &mut Vec<u8>) {
        match self {
            Self::Never => END.put(bytes),
            Self::Start { records } => (1u8, *records).put(bytes),
            Self::Resume(state) => {
                2u8.put(bytes);
                bytes.extend_from_slice(state);
            }
        }
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        match u8::take(bytes)? {
            1 => Ok(Self::Start {
                records: bool::take(bytes)?,
            }),
            2 => Ok(Self::Resume(std::mem::take(bytes).to_vec())),
            _ => Ok(Self::Never),
        }
    }
}

impl Plain for Call {
    fn put(&self, bytes: &mut Vec<u8>) {
        match *self {
            Self::End => END.put(bytes),
            Self::Steps { count, watch } => {
                let watched = watch.map(|watch| (watch.records, watch.audit));
                (1u8, count).put(bytes);
                watched.put(bytes);
            }
            Self::CompleteStep => 2u8.put(bytes),
            Self::Collect { contacts } => (3u8, contacts).put(bytes),
            Self::TakeFeatureLoads => 4u8.put(bytes),
        }
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        match u8::take(bytes)? {
            1 => {
                let count = u64::take(bytes)?;
                let watched: Option<(bool, Option<f64>)> = Plain::take(bytes)?;
                let watch = watched.map(|(records, audit)| Watch { records, audit });
                Ok(Self::Steps { count, watch })
            }
            2 => Ok(Self::CompleteStep),
            3 => Ok(Self::Collect {
                contacts: bool::take(bytes)?,
            }),
            4 => Ok(Self::TakeFeatureLoads),
            _ => Ok(Self::End),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_and_beginnings_come_back_as_they_were() {
        let watch = |records, audit| Some(Watch { records, audit });
        let steps = |count, watch| Call::Steps { count, watch };
        for call in [
            steps(7, None),
            steps(u64::MAX, watch(true, Some(1e-5))),
            steps(1, watch(false, None)),
            Call::CompleteStep,
            Call::Collect { contacts: true },
            Call::Collect { contacts: false },
            Call::TakeFeatureLoads,
            Call::End,
        ] {
            let mut bytes = Vec::new();
            call.put(&mut bytes);
            assert_eq!(Call::take(&mut &bytes[..]), Ok(call));
        }
        for beginning in [
            Beginning::Start { records: true },
            Beginning::Start { records: false },
            Beginning::Resume(vec![1, 2, 3]),
            Beginning::Never,
        ] {
            let mut bytes = Vec::new();
            beginning.put(&mut bytes);
            assert_eq!(Beginning::take(&mut &bytes[..]), Ok(beginning));
        }
    }
}
