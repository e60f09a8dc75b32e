//! The few colours that show a picture best.

use std::collections::BTreeMap;

/// Colours are counted in cells of this many bits a channel.
const BITS: u32 = 6;

/// A list of colours, and for each cell of colours the nearest of them.
pub(super) struct Palette {
    /// Red, green, blue of each.
    pub(super) colours: Vec<[u8; 3]>,
    nearest: Vec<u8>,
}

/// Pixels of one cell: how many, and the sums of their channels.
#[derive(Clone, Copy)]
struct Group {
    cell: u32,
    number: u64,
    sums: [u64; 3],
}

impl Group {
    fn mean(&self, channel: usize) -> f64 {
        self.sums[channel] as f64 / self.number as f64
    }
}

fn cell(pixel: &[u8]) -> u32 {
    pixel[..3]
        .iter()
        .fold(0, |cell, c| cell << BITS | u32::from(*c) >> (8 - BITS))
}

impl Palette {
    /// At most `most` colours (256 or less) for these pixels: boxes of colours are cut in two, the one with the largest
    /// sum of squared differences first, across its widest spread (after P. Heckbert, 1982, and X. Wu, 1991).
    pub(super) fn new<'a>(pixels: impl Iterator<Item = &'a [u8]>, most: usize) -> Self {
        let mut groups: BTreeMap<u32, Group> = BTreeMap::new();
        let mut last: Option<(u32, Group)> = None;
        // Runs of one colour are common: count them before looking the cell up.
        let flush = |groups: &mut BTreeMap<u32, Group>, run: Group| {
            groups
                .entry(run.cell)
                .and_modify(|group| {
                    group.number += run.number;
                    for (sum, more) in group.sums.iter_mut().zip(run.sums) {
                        *sum += more;
                    }
                })
                .or_insert(run);
        };
        for pixel in pixels {
            let cell = cell(pixel);
            let sums = [pixel[0], pixel[1], pixel[2]].map(u64::from);
            match &mut last {
                Some((same, run)) if *same == cell => {
                    run.number += 1;
                    for (sum, more) in run.sums.iter_mut().zip(sums) {
                        *sum += more;
                    }
                }
                _ => {
                    let run = Group {
                        cell,
                        number: 1,
                        sums,
                    };
                    if let Some((_, run)) = last.replace((cell, run)) {
                        flush(&mut groups, run);
                    }
                }
            }
        }
        if let Some((_, run)) = last {
            flush(&mut groups, run);
        }
        let mut boxes = vec![Cut::new(groups.into_values().collect())];
        while boxes.len() < most {
            let widest = (0..boxes.len())
                .max_by(|a, b| f64::total_cmp(&boxes[*a].spread, &boxes[*b].spread).then(b.cmp(a)));
            match widest.and_then(|widest| boxes[widest].split().map(|half| (widest, half))) {
                Some((widest, (low, high))) => {
                    boxes[widest] = low;
                    boxes.push(high);
                }
                None => break,
            }
        }
        let mut palette = Self {
            colours: Vec::new(),
            nearest: vec![0; 1 << (3 * BITS)],
        };
        for cut in &boxes {
            if let Some(mean) = cut.mean() {
                palette.colours.push(mean.map(|c| (c + 0.5) as u8));
            }
        }
        // A group takes the nearest of all colours, which need not be that of its own box.
        for group in boxes.iter().flat_map(|cut| &cut.groups) {
            let at = [0, 1, 2].map(|channel| group.mean(channel));
            let nearest = palette.search(at);
            palette.nearest[group.cell as usize] = nearest;
        }
        palette
    }

    /// The number of the colour for one of the pixels that the palette was made for.
    pub(super) fn index(&self, pixel: &[u8]) -> u8 {
        self.nearest[cell(pixel) as usize]
    }

    fn search(&self, at: [f64; 3]) -> u8 {
        let distance = |colour: &[u8; 3]| -> f64 {
            (colour.iter().zip(at))
                .map(|(c, a)| (f64::from(*c) - a).powi(2))
                .sum()
        };
        let best = (0..self.colours.len()).min_by(|a, b| {
            f64::total_cmp(&distance(&self.colours[*a]), &distance(&self.colours[*b]))
        });
        best.unwrap_or(0) as u8
    }
}

/// Groups of colours that share one entry.
struct Cut {
    groups: Vec<Group>,
    /// Sum of squared differences from the mean along the channel that has the most, and that channel.
    spread: f64,
    channel: usize,
}

impl Cut {
    fn new(groups: Vec<Group>) -> Self {
        let mut cut = Self {
            groups,
            spread: 0.0,
            channel: 0,
        };
        if let Some(mean) = cut.mean() {
            for (channel, mean) in mean.into_iter().enumerate() {
                let spread = (cut.groups.iter())
                    .map(|group| group.number as f64 * (group.mean(channel) - mean).powi(2))
                    .sum();
                if spread > cut.spread {
                    (cut.spread, cut.channel) = (spread, channel);
                }
            }
        }
        cut
    }

    fn mean(&self) -> Option<[f64; 3]> {
        let number: u64 = self.groups.iter().map(|group| group.number).sum();
        (number > 0).then(|| {
            [0, 1, 2].map(|channel| {
                let sum: u64 = self.groups.iter().map(|group| group.sums[channel]).sum();
                sum as f64 / number as f64
            })
        })
    }

    /// Cut at the mean.
    fn split(&self) -> Option<(Self, Self)> {
        let mean = self.mean()?[self.channel];
        let (low, high): (Vec<Group>, Vec<Group>) =
            (self.groups.iter()).partition(|group| group.mean(self.channel) < mean);
        let both = !low.is_empty() && !high.is_empty();
        (self.spread > 0.0 && both).then(|| (Self::new(low), Self::new(high)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_exactly() {
        let pixels = [
            [10, 20, 30, 255],
            [200, 0, 0, 255],
            [0, 0, 0, 255],
            [10, 20, 30, 255],
        ];
        let palette = Palette::new(pixels.iter().map(|p| p.as_slice()), 255);
        assert_eq!(palette.colours.len(), 3);
        for pixel in &pixels {
            assert_eq!(palette.colours[palette.index(pixel) as usize], pixel[..3]);
        }
        assert!(Palette::new(std::iter::empty(), 255).colours.is_empty());
    }

    #[test]
    fn a_gradient_of_a_thousand_colours_loses_little() {
        let pixels: Vec<[u8; 4]> = (0..40_000_u32)
            .map(|i| {
                [
                    (i % 200) as u8,
                    (i / 200) as u8,
                    (i % 200 / 2 + i / 400) as u8,
                    255,
                ]
            })
            .collect();
        let palette = Palette::new(pixels.iter().map(|p| p.as_slice()), 255);
        assert_eq!(palette.colours.len(), 255);
        let squared: f64 = pixels
            .iter()
            .map(|p| {
                let c = palette.colours[palette.index(p) as usize];
                (0..3)
                    .map(|k| (f64::from(c[k]) - f64::from(p[k])).powi(2))
                    .sum::<f64>()
            })
            .sum();
        // 255 cells of equal size on a plane of 200 x 200 (x sqrt of 1 + 1/4 + 1/4): side 15.4, error² side²/6.
        let deviation = (squared / pixels.len() as f64).sqrt();
        assert!(deviation < 8.0, "{deviation}");
    }
}
