//! Price of a core for an hour, from a file that the operator keeps. No request is sent to a provider.

use std::collections::BTreeMap;

use serde::Deserialize;

/// Prices of a core for an hour.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prices {
    /// Currency, as it is shown: `USD`, `EUR`.
    pub currency: String,
    /// Price of a core without any discount; savings are against it.
    #[serde(default)]
    pub on_demand: Option<f64>,
    /// By queue on AWS Batch (the last part of its name or ARN), by engine elsewhere: `local` or `slurm`.
    pub core_hour: BTreeMap<String, f64>,
}

/// Cost of an attempt, in the currency of the prices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    pub(crate) spent: Option<f64>,
    pub(crate) saved: Option<f64>,
}

impl Prices {
    /// Checks currency and prices.
    ///
    /// # Errors
    /// The key and what is wrong with its value.
    pub fn check(&self) -> Result<(), String> {
        let name = self.currency.trim();
        if name.is_empty() || name.len() > 10 || name.chars().any(char::is_control) {
            return Err("currency: 1 to 10 characters, such as USD".to_owned());
        }
        let on_demand = self.on_demand.map(|price| ("on_demand", price));
        let queues = (self.core_hour.iter()).map(|(queue, price)| (queue.as_str(), *price));
        for (key, price) in on_demand.into_iter().chain(queues) {
            if !(price.is_finite() && price >= 0.0) {
                return Err(format!("{key}: {price} is no price; 0 or more"));
            }
        }
        Ok(())
    }

    /// The price of a core for an hour in a queue.
    pub(crate) fn core_hour(&self, queue: &str) -> Option<f64> {
        let name = queue.rsplit(['/', ':']).next().unwrap_or(queue);
        self.core_hour
            .get(queue)
            .or_else(|| self.core_hour.get(name))
            .copied()
    }

    /// Cost of so many core seconds in a queue.
    pub(crate) fn cost(&self, queue: &str, core_seconds: f64) -> Cost {
        let Some(price) = self.core_hour(queue) else {
            return Cost::default();
        };
        let hours = core_seconds / 3600.0;
        Cost {
            spent: Some(hours * price),
            saved: self.on_demand.map(|full| hours * (full - price)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prices() -> Prices {
        toml::from_str(
            "currency = \"USD\"\non_demand = 0.04\n[core_hour]\nspot = 0.01\nlocal = 0\n",
        )
        .unwrap()
    }

    #[test]
    fn a_cost_is_hours_times_price_and_savings_are_against_the_full_price() {
        let cost = prices().cost("arn:aws:batch:eu-west-1:1:job-queue/spot", 7200.0);
        assert_eq!(cost.spent, Some(0.02));
        assert_eq!(cost.saved, Some(0.06));
        assert_eq!(prices().cost("local", 7200.0).spent, Some(0.0));
        assert_eq!(prices().cost("slurm", 7200.0), Cost::default());
    }

    #[test]
    fn prices_that_are_none_are_refused_by_their_key() {
        prices().check().unwrap();
        for (from, to, key) in [
            ("0.01", "-0.01", "spot"),
            ("0.04", "nan", "on_demand"),
            ("0.01", "inf", "spot"),
            ("USD", "", "currency"),
        ] {
            let mut text = toml::to_string(&toml::toml! {
                currency = "USD"
                on_demand = 0.04
                [core_hour]
                spot = 0.01
            })
            .unwrap();
            text = text.replace(from, to);
            let wrong = toml::from_str::<Prices>(&text)
                .unwrap()
                .check()
                .unwrap_err();
            assert!(wrong.starts_with(key), "{wrong}");
        }
    }
}
