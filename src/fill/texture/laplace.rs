//! The Laplace equation on the texels of an image.

use super::Light;

/// Sweeps on the finest grid. Each coarser one gets twice as many, up to [`MAX_SWEEPS`].
const SWEEPS: usize = 16;
const MAX_SWEEPS: usize = 256;
/// Factor of over-relaxation.
const RELAXATION: f32 = 1.6;

/// An image whose texels are known or not.
pub struct Texels {
    pub width: usize,
    pub height: usize,
    /// Row by row from the top.
    pub lights: Vec<Light>,
    pub known: Vec<bool>,
}

impl Texels {
    /// An image without known texels.
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            lights: vec![[0.0; 4]; width * height],
            known: vec![false; width * height],
        }
    }

    /// Continues the known texels: every other one becomes nearly the mean of its neighbours. Coarser
    /// images give the start of finer ones, so that few sweeps are needed.
    pub fn continue_known(&mut self) {
        self.solve(SWEEPS);
    }

    fn solve(&mut self, sweeps: usize) {
        if self.width.max(self.height) <= 2 {
            self.fill_with_mean();
        } else {
            let mut half = self.halved();
            half.solve((2 * sweeps).min(MAX_SWEEPS));
            self.start_from(&half);
        }
        for _ in 0..sweeps {
            self.sweep();
        }
    }

    fn fill_with_mean(&mut self) {
        let (mut sum, mut count) = ([0.0; 4], 0);
        for (light, _) in self.lights.iter().zip(&self.known).filter(|(_, k)| **k) {
            sum = std::array::from_fn(|k| sum[k] + light[k]);
            count += 1;
        }
        let mean = sum.map(|x| x / count.max(1) as f32);
        for (light, _) in self.lights.iter_mut().zip(&self.known).filter(|l| !l.1) {
            *light = mean;
        }
    }

    /// The image of half the size. A texel is known if one of its four is; it is the mean of these.
    fn halved(&self) -> Self {
        let mut half = Self::new(self.width.div_ceil(2), self.height.div_ceil(2));
        let mut counts = vec![0.0_f32; half.lights.len()];
        for y in 0..self.height {
            for x in 0..self.width {
                let (fine, coarse) = (y * self.width + x, y / 2 * half.width + x / 2);
                if self.known[fine] {
                    counts[coarse] += 1.0;
                    half.known[coarse] = true;
                    for k in 0..4 {
                        half.lights[coarse][k] += self.lights[fine][k];
                    }
                }
            }
        }
        for (light, count) in half.lights.iter_mut().zip(counts) {
            *light = light.map(|x| x / count.max(1.0));
        }
        half
    }

    /// Interpolates the unknown texels from those of the image of half the size.
    fn start_from(&mut self, half: &Self) {
        for y in 0..self.height {
            for x in 0..self.width {
                let at = y * self.width + x;
                if !self.known[at] {
                    let place = [x, y].map(|i| 0.5 * (i as f32 + 0.5));
                    self.lights[at] = half.interpolated(place);
                }
            }
        }
    }

    /// The light at a place in texels from the corner, between the centres of texels.
    fn interpolated(&self, [x, y]: [f32; 2]) -> Light {
        let along = |x: f32, count: usize| {
            let x = (x - 0.5).clamp(0.0, (count - 1) as f32);
            let first = (x as usize).min(count.saturating_sub(2));
            (first, (first + 1).min(count - 1), x - first as f32)
        };
        let (left, right, s) = along(x, self.width);
        let (top, bottom, t) = along(y, self.height);
        let at = |x: usize, y: usize| self.lights[y * self.width + x];
        let between =
            |a: Light, b: Light, t: f32| std::array::from_fn(|k| a[k] + t * (b[k] - a[k]));
        let upper = between(at(left, top), at(right, top), s);
        between(upper, between(at(left, bottom), at(right, bottom), s), t)
    }

    /// Moves every unknown texel to the mean of its neighbours, and beyond.
    fn sweep(&mut self) {
        let (width, height) = (self.width, self.height);
        for y in 0..height {
            for x in 0..width {
                let at = y * width + x;
                if self.known[at] {
                    continue;
                }
                let (mut sum, mut count) = ([0.0_f32; 4], 0.0_f32);
                let mut add = |other: Light| {
                    sum = std::array::from_fn(|k| sum[k] + other[k]);
                    count += 1.0;
                };
                if x > 0 {
                    add(self.lights[at - 1]);
                }
                if x + 1 < width {
                    add(self.lights[at + 1]);
                }
                if y > 0 {
                    add(self.lights[at - width]);
                }
                if y + 1 < height {
                    add(self.lights[at + width]);
                }
                let light = &mut self.lights[at];
                for k in 0..4 {
                    light[k] += RELAXATION * (sum[k] / count - light[k]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Inside a circle with the values of a linear function, its values.
    #[test]
    fn linear_functions_are_continued() {
        let n = 200;
        let mut texels = Texels::new(n, n);
        let radius = |x: usize, y: usize| {
            let [x, y] = [x, y].map(|i| i as f32 + 0.5 - 0.5 * n as f32);
            x.hypot(y)
        };
        let function = |x: usize, y: usize| (x as f32 + 0.5 * y as f32) / (1.5 * n as f32);
        let all = || (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
        for (x, y) in all() {
            if (radius(x, y) - 90.0).abs() < 1.5 {
                texels.known[y * n + x] = true;
                texels.lights[y * n + x] = [function(x, y), 0.25, 0.0, 1.0];
            }
        }
        texels.continue_known();
        let mut worst = 0.0_f32;
        for (x, y) in all().filter(|&(x, y)| radius(x, y) < 90.0) {
            let [r, g, b, a] = texels.lights[y * n + x];
            worst = worst.max((r - function(x, y)).abs());
            assert!((g - 0.25).abs() < 1e-4 && b.abs() < 1e-6 && (a - 1.0).abs() < 1e-4);
        }
        assert!(worst < 0.01, "{worst}");
    }
}
