//! A sample: the sizes of particles, counted one by one.

use mercury_common::sizes::Weighting;

/// Why sizes are no sample.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SampleError {
    /// There are none.
    #[error("there are no particles")]
    Empty,
    /// A size that no particle has.
    #[error("size {} of the list is {value}: diameters must be finite and above 0", .index + 1)]
    Size {
        /// Its place in the list, from 0.
        index: usize,
        /// The diameter, m.
        value: f64,
    },
}

/// Diameters of particles, m, ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    diameters: Vec<f64>,
    /// Sum of (d / largest)^k below each place, k = 3; one more than diameters.
    volumes: Vec<f64>,
}

impl Sample {
    /// A sample of diameters in m, in any order.
    ///
    /// # Errors
    /// [`SampleError`].
    pub fn new(mut diameters: Vec<f64>) -> Result<Self, SampleError> {
        let is_size = |d: &f64| *d > 0.0 && d.is_finite();
        if let Some(index) = diameters.iter().position(|d| !is_size(d)) {
            let value = diameters[index];
            return Err(SampleError::Size { index, value });
        }
        diameters.sort_unstable_by(f64::total_cmp);
        let Some(&largest) = diameters.last() else {
            return Err(SampleError::Empty);
        };
        let mut volumes = Vec::with_capacity(diameters.len() + 1);
        let mut sum = 0.0;
        volumes.push(sum);
        for d in &diameters {
            let relative = d / largest;
            sum += relative * relative * relative;
            volumes.push(sum);
        }
        Ok(Self { diameters, volumes })
    }

    /// The number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.diameters.len()
    }

    /// Never: a sample has particles.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Diameters, m, ascending.
    #[must_use]
    pub fn diameters(&self) -> &[f64] {
        &self.diameters
    }

    /// Smallest diameter, m.
    #[must_use]
    pub fn smallest(&self) -> f64 {
        self.diameters[0]
    }

    /// Largest diameter, m.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.diameters[self.diameters.len() - 1]
    }

    /// The mean of d^j, m^j.
    #[must_use]
    pub fn moment(&self, j: i32) -> f64 {
        let scale = self.largest();
        let sum: f64 = self.diameters.iter().map(|d| (d / scale).powi(j)).sum();
        sum / self.len() as f64 * scale.powi(j)
    }

    /// The share of the volume of the first `count` particles (of the smallest ones).
    #[must_use]
    pub fn volume_share(&self, count: usize) -> f64 {
        self.volumes[count] / self.volumes[self.len()]
    }

    /// Share of the quantity in particles of at most `diameter`; number and volume are quick.
    #[must_use]
    pub fn cdf(&self, weighting: Weighting, diameter: f64) -> f64 {
        let below = self.diameters.partition_point(|&d| d <= diameter);
        match weighting {
            Weighting::Number => below as f64 / self.len() as f64,
            Weighting::Volume => self.volume_share(below),
            Weighting::Length | Weighting::Area => {
                let k = i32::from(weighting.power());
                let scale = self.largest();
                let weight = |d: &f64| (d / scale).powi(k);
                let part: f64 = self.diameters[..below].iter().map(weight).sum();
                let rest: f64 = self.diameters[below..].iter().map(weight).sum();
                part / (part + rest)
            }
        }
    }

    /// The diameter at which the cumulative share reaches `u`, m.
    #[must_use]
    pub fn quantile(&self, weighting: Weighting, u: f64) -> f64 {
        let n = self.len();
        let index = match weighting {
            Weighting::Number => ((u * n as f64).ceil() as usize).clamp(1, n) - 1,
            Weighting::Volume => self.volume_index(u),
            Weighting::Length | Weighting::Area => {
                let k = i32::from(weighting.power());
                let scale = self.largest();
                let weight = |d: &f64| (d / scale).powi(k);
                let wanted = u * self.diameters.iter().map(weight).sum::<f64>();
                let mut sum = 0.0;
                let reached = |d: &f64| {
                    sum += weight(d);
                    sum >= wanted
                };
                self.diameters.iter().position(reached).unwrap_or(n - 1)
            }
        };
        self.diameters[index]
    }

    /// The particle (from 0, ascending) at which the share of the volume reaches `u`.
    #[must_use]
    pub fn volume_index(&self, u: f64) -> usize {
        let n = self.len();
        let wanted = u * self.volumes[n];
        (self.volumes[1..].partition_point(|&v| v < wanted)).min(n - 1)
    }

    /// Number of equal particles that would determine the volume's distribution as well: (sum v)^2 / sum v^2.
    #[must_use]
    pub fn effective_number_by_volume(&self) -> f64 {
        let scale = self.largest();
        let (mut sum, mut squares) = (0.0, 0.0);
        for d in &self.diameters {
            let v = (d / scale).powi(3);
            sum += v;
            squares += v * v;
        }
        sum * sum / squares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_quantiles_by_every_quantity() {
        let sample = Sample::new(vec![3.0, 1.0, 2.0]).expect("sizes");
        assert_eq!(sample.diameters(), [1.0, 2.0, 3.0]);
        for (weighting, below_two) in [
            (Weighting::Number, 2.0 / 3.0),
            (Weighting::Length, 3.0 / 6.0),
            (Weighting::Area, 5.0 / 14.0),
            (Weighting::Volume, 9.0 / 36.0),
        ] {
            assert!((sample.cdf(weighting, 2.0) - below_two).abs() < 1e-15);
            assert_eq!(sample.cdf(weighting, 0.5), 0.0);
            assert_eq!(sample.cdf(weighting, 3.0), 1.0);
            assert_eq!(sample.quantile(weighting, below_two - 1e-9), 2.0);
            assert_eq!(sample.quantile(weighting, below_two + 1e-9), 3.0);
            assert_eq!(sample.quantile(weighting, 1.0), 3.0);
        }
        assert!((sample.moment(2) - 14.0 / 3.0).abs() < 1e-15 * 8.0);
        // (1 + 8 + 27)^2 / (1 + 64 + 729)
        assert!((sample.effective_number_by_volume() - 1296.0 / 794.0).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_size_is_named() {
        assert_eq!(Sample::new(vec![]), Err(SampleError::Empty));
        let error = Sample::new(vec![1.0, -2.0]).expect_err("negative");
        assert_eq!(
            error.to_string(),
            "size 2 of the list is -2: diameters must be finite and above 0"
        );
        assert!(Sample::new(vec![f64::NAN]).is_err());
    }
}
