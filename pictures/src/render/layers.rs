//! Translucent layers over each sample, the farthest first.

use crate::colour::Colour;

/// A light that comes through: red, green, blue (0 to 1, premultiplied) and alpha.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Light(pub(super) [f32; 4]);

impl Light {
    pub(super) const NONE: Self = Self([0.0; 4]);

    pub(super) fn opaque(colour: Colour) -> Self {
        Self::new(colour, 1.0)
    }

    pub(super) fn new(Colour(r, g, b): Colour, alpha: f64) -> Self {
        let channel = |c: u8| (f64::from(c) / 255.0 * alpha) as f32;
        Self([channel(r), channel(g), channel(b), alpha as f32])
    }

    /// `front` over this (T. Porter and T. Duff, 1984).
    pub(super) fn under(self, front: Self) -> Self {
        let through = 1.0 - front.0[3];
        Self(std::array::from_fn(|k| front.0[k] + through * self.0[k]))
    }

    pub(super) fn add(&mut self, other: Self) {
        for (sum, value) in self.0.iter_mut().zip(other.0) {
            *sum += value;
        }
    }

    /// The mean of `number` lights whose sum this is, as an 8-bit pixel that is not premultiplied.
    pub(super) fn pixel(self, number: usize) -> [u8; 4] {
        let [r, g, b, alpha] = self.0;
        if alpha <= 0.0 {
            return [0; 4];
        }
        let channel = |c: f32| (c / alpha * 255.0 + 0.5) as u8;
        let alpha = (alpha / number as f32 * 255.0 + 0.5) as u8;
        [channel(r), channel(g), channel(b), alpha]
    }
}

/// The layers of the samples of one tile.
pub(super) struct Layers {
    /// For each sample the last layer laid down, plus one; 0: none.
    last: Vec<u32>,
    layers: Vec<Layer>,
    /// Scratch: the layers of one sample.
    stack: Vec<(f32, u32)>,
}

struct Layer {
    light: Light,
    depth: f32,
    /// The layer of the same sample laid down before, plus one.
    before: u32,
}

impl Layers {
    pub(super) fn new(samples: usize) -> Self {
        Self {
            last: vec![0; samples],
            layers: Vec::new(),
            stack: Vec::new(),
        }
    }

    /// Ready for another tile.
    pub(super) fn clear(&mut self) {
        self.last.fill(0);
        self.layers.clear();
    }

    pub(super) fn is_empty(&self) -> bool {
        self.layers.is_empty()
    }

    pub(super) fn push(&mut self, sample: usize, depth: f32, light: Light) {
        self.layers.push(Layer {
            light,
            depth,
            before: self.last[sample],
        });
        self.last[sample] = self.layers.len() as u32;
    }

    /// `ground` under all layers of the sample. Of layers at one depth the later one lies in front.
    pub(super) fn over(&mut self, sample: usize, ground: Light) -> Light {
        self.stack.clear();
        let mut next = self.last[sample];
        while next > 0 {
            let layer = &self.layers[next as usize - 1];
            self.stack.push((layer.depth, next));
            next = layer.before;
        }
        self.stack
            .sort_unstable_by(|a, b| f32::total_cmp(&b.0, &a.0).then(a.1.cmp(&b.1)));
        self.stack.iter().fold(ground, |below, (_, layer)| {
            below.under(self.layers[*layer as usize - 1].light)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_layer_is_laid_first() {
        let mut layers = Layers::new(2);
        layers.push(1, 1.0, Light::new(Colour(255, 0, 0), 0.5));
        layers.push(1, 3.0, Light::new(Colour(0, 255, 0), 0.5));
        layers.push(1, 2.0, Light::new(Colour(0, 0, 255), 0.5));
        // On white: green 1/2, blue 1/2 over that, red 1/2 over both.
        let pixel = layers.over(1, Light::opaque(Colour::WHITE)).pixel(1);
        // That leaves 1/8 of white, 1/8 of green, 1/4 of blue, 1/2 of red: 5/8, 2/8, 3/8 of 255.
        assert_eq!(pixel, [159, 64, 96, 255]);
        assert_eq!(layers.over(0, Light::NONE), Light::NONE);
        // On nothing: alpha 1 - 1/8, red is 4 of 7 parts, blue 2, green 1.
        assert_eq!(layers.over(1, Light::NONE).pixel(1), [146, 36, 73, 223]);
    }
}
