//! Sizes that reach down to 0: what falls through the finest sieve.

use super::distribution::Form;
use super::{SizeDistribution, Weighting};
use crate::readable::rounded;

impl SizeDistribution {
    /// Warning of a distribution that reaches down to d = 0, as a table with a pan does: its smallest particles have no size.
    /// Nothing where it has a smallest one.
    #[must_use]
    pub fn warning_of_fines(&self) -> Option<String> {
        if self.smallest() > 0.0 {
            return None;
        }
        match self.form() {
            Form::Mixture(parts) => parts.iter().find_map(|(_, part)| part.warning_of_fines()),
            Form::Law(_) => Some(format!(
                "its sizes reach down to 0, so that the smallest can be as small as one likes: {HELP}"
            )),
            Form::Classes(classes) => {
                let high = classes.edges().get(1).copied().unwrap_or_default();
                let share = |by: Weighting| {
                    let share = classes.shares(by).first().copied().unwrap_or_default();
                    format!("{} % by {}", rounded(100.0 * share, 3), by.word())
                };
                let mut shares = share(self.weighting());
                if self.weighting() != Weighting::Number {
                    shares += &format!(", {}", share(Weighting::Number));
                }
                Some(format!(
                    "the class below {} m (the pan, where sieves were used) holds {shares}, of sizes down to 0, so that the smallest can be as small as one likes: give its row the size at which the fines begin instead of `pan` or 0, or {HELP}",
                    rounded(high, 6)
                ))
            }
        }
    }
}

const HELP: &str = "cut them off (mercury-psd convert --cut 0.01,1 by what was measured, cut = [0.01, 1] in a scene)";

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::table::{Content, Options, parse};
    use super::*;

    #[test]
    fn a_pan_is_named_with_its_shares() {
        let sizes = |text: &str| match parse(Path::new("t.csv"), text, &Options::default()) {
            Ok(Content::Table(table)) => {
                SizeDistribution::from_classes(table.classes, table.weighting)
            }
            other => panic!("{other:?}"),
        };
        let pan = sizes("sieve [mm],retained [g]\n2,0\n1,30\npan,10\n");
        let message = pan.warning_of_fines().expect("a warning");
        // 10 of 40 g below 1 mm; uniform by number inside, the mean of d^3 is 1/4 there and 15/4 above: numbers like 1 to 3/15.
        assert!(
            message.starts_with("the class below 0.001 m (the pan, where sieves were used) holds 25 % by volume, 83.3 % by number,"),
            "{message}"
        );
        assert!(message.contains("--cut 0.01,1"), "{message}");
        let begun = sizes("sieve [mm],retained [g]\n2,0\n1,30\n0.2,10\n");
        assert_eq!(begun.warning_of_fines(), None);
    }
}
