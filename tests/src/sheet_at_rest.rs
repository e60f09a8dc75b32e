//! A ball at rest on an elastic sheet, as the least of its energy. Written from the formulas alone, it shares no code with the solver.
//!
//! The energy is that of springs along edges, hinges that rest flat, weights, and the contact. With d the distance of the ball's centre from a triangle or an
//! edge, t the thickness, and U(d) = k (R + t/2 - d)^2/2 below R + t/2, the contact stores the sum of U over the triangles less the sum over those edges that a spanning forest of the nearest
//! edges between them has: one U for each region of the sheet that the ball touches, however many triangles it has.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::reference::nearest_point;

/// Sheet at rest, SI units.
#[derive(Debug, Clone)]
pub struct SheetAtRest {
    /// Places of the vertices, which are those without stress but for `prestrain`.
    pub vertices: Vec<DVec3>,
    /// Corners of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Whether each vertex is held.
    pub is_held: Vec<bool>,
    /// Lengths without stress are shorter by 1 + this.
    pub prestrain: f64,
    /// Thickness, m.
    pub thickness: f64,
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Density, kg/m^3.
    pub density: f64,
    /// Ke of the hinges, N m.
    pub bending: f64,
    /// Radius of the ball, m.
    pub radius: f64,
    /// Its mass, kg.
    pub mass: f64,
    /// Stiffness of the contact, N/m.
    pub stiffness: f64,
    /// Gravity, m/s^2, downwards along z.
    pub gravity: f64,
}

struct Spring {
    ends: [usize; 2],
    stiffness: f64,
    length: f64,
}

/// The corners in the order edge, edge, beside, beside; the triangles; Ke e^2/(A1 + A2).
struct Hinge {
    corners: [usize; 4],
    triangles: [usize; 2],
    factor: f64,
}

/// The terms of the energy; the last place is that of the ball's centre.
struct Energy<'a> {
    of: &'a SheetAtRest,
    springs: Vec<Spring>,
    hinges: Vec<Hinge>,
    masses: Vec<f64>,
}

impl SheetAtRest {
    /// Places of the vertices and of the ball's centre, m, where the energy is least, from `ball` (m) and the flat sheet. The forces that are left are below
    /// 1e-9 of the weight of the ball.
    ///
    /// # Panics
    /// If it does not find them.
    #[must_use]
    pub fn least(&self, ball: DVec3) -> Vec<DVec3> {
        let mut places = self.vertices.clone();
        places.push(ball);
        self.energy().least(places)
    }

    /// Largest distance at which the ball touches the middle of the sheet, m.
    fn reach(&self) -> f64 {
        self.radius + 0.5 * self.thickness
    }

    fn energy(&self) -> Energy<'_> {
        let rest = |k: u32| self.vertices[k as usize] / (1.0 + self.prestrain);
        let area =
            |[a, b, c]: [u32; 3]| 0.5 * (rest(b) - rest(a)).cross(rest(c) - rest(a)).length();
        let mut masses = vec![0.0; self.vertices.len()];
        let mut at_edges: BTreeMap<[u32; 2], Vec<(usize, u32)>> = BTreeMap::new();
        for (number, &corners) in self.triangles.iter().enumerate() {
            for (k, &corner) in corners.iter().enumerate() {
                masses[corner as usize] += self.density * self.thickness * area(corners) / 3.0;
                let (a, b) = (corner, corners[(k + 1) % 3]);
                let sides = at_edges.entry([a.min(b), a.max(b)]).or_default();
                sides.push((number, corners[(k + 2) % 3]));
            }
        }
        masses.push(self.mass);
        let (mut springs, mut hinges) = (Vec::new(), Vec::new());
        for (ends, sides) in at_edges {
            let length = (rest(ends[1]) - rest(ends[0])).length();
            let areas: f64 = sides.iter().map(|&(k, _)| area(self.triangles[k])).sum();
            let squared = length * length;
            springs.push(Spring {
                ends: ends.map(|k| k as usize),
                stiffness: self.youngs_modulus * self.thickness * areas / squared,
                length,
            });
            if let [(one, near), (other, far)] = sides[..] {
                hinges.push(Hinge {
                    corners: [ends[0], ends[1], near, far].map(|k| k as usize),
                    triangles: [one, other],
                    factor: self.bending * squared / areas,
                });
            }
        }
        Energy {
            of: self,
            springs,
            hinges,
            masses,
        }
    }
}

impl Energy<'_> {
    fn corners(&self, triangle: usize) -> [usize; 3] {
        self.of.triangles[triangle].map(|k| k as usize)
    }

    /// The energy (J), and its slope with respect to each place (N) added to `slope`.
    fn at(&self, x: &[DVec3], slope: &mut [DVec3]) -> f64 {
        slope.fill(DVec3::ZERO);
        let mut sum = 0.0;
        for (k, mass) in self.masses.iter().enumerate() {
            sum += mass * self.of.gravity * x[k].z;
            slope[k].z += mass * self.of.gravity;
        }
        for spring in &self.springs {
            let [a, b] = spring.ends;
            let branch = x[b] - x[a];
            let stretch = branch.length() - spring.length;
            sum += 0.5 * spring.stiffness * stretch * stretch;
            let pull = branch.normalize() * (spring.stiffness * stretch);
            slope[b] += pull;
            slope[a] -= pull;
        }
        for hinge in &self.hinges {
            sum += self.bend(hinge, x, slope);
        }
        sum += self.touch(x, slope);
        for (k, is_held) in self.of.is_held.iter().enumerate() {
            if *is_held {
                slope[k] = DVec3::ZERO;
            }
        }
        sum
    }

    /// 4 factor (1 - cos(theta/2)), theta the angle between the normals.
    fn bend(&self, hinge: &Hinge, x: &[DVec3], slope: &mut [DVec3]) -> f64 {
        let of_triangle = hinge.triangles.map(|number| {
            let corners = self.corners(number);
            let [a, b, c] = corners.map(|k| x[k]);
            (corners, b - a, c - a, (b - a).cross(c - a))
        });
        let [one, other] = of_triangle.map(|(.., normal)| normal.normalize());
        let cosine = ((1.0 + one.dot(other)) * 0.5).sqrt();
        // Slope by n1 . n2.
        let by_product = -hinge.factor / cosine;
        for ((corners, ab, ac, normal), (own, of_other)) in
            of_triangle.into_iter().zip([(one, other), (other, one)])
        {
            let turn = (of_other - own * own.dot(of_other)) * (by_product / normal.length());
            let (on_b, on_c) = (ac.cross(turn), turn.cross(ab));
            slope[corners[0]] -= on_b + on_c;
            slope[corners[1]] += on_b;
            slope[corners[2]] += on_c;
        }
        // 1 - cos(theta/2) by the difference of the normals, to all digits where it is small.
        let half_sine_squared = 0.25 * (one - other).length_squared();
        4.0 * hinge.factor * half_sine_squared / (1.0 + cosine)
    }

    /// U(d) and its slope, times `sign`, for the nearest point of some corners.
    fn spring(&self, x: &[DVec3], corners: &[usize], sign: f64, slope: &mut [DVec3]) -> f64 {
        let ball = x.len() - 1;
        let (foot, weights) = nearest(x, corners, x[ball]);
        let branch = x[ball] - foot;
        let overlap = self.of.reach() - branch.length();
        if overlap <= 0.0 {
            return 0.0;
        }
        let push = branch.normalize() * (-sign * self.of.stiffness * overlap);
        slope[ball] += push;
        for (&corner, weight) in corners.iter().zip(weights) {
            slope[corner] -= push * weight;
        }
        sign * 0.5 * self.of.stiffness * overlap * overlap
    }

    fn touch(&self, x: &[DVec3], slope: &mut [DVec3]) -> f64 {
        let centre = x[x.len() - 1];
        let count = self.of.triangles.len();
        let away = |corners: &[usize]| (nearest(x, corners, centre).0 - centre).length();
        let mut sum = 0.0;
        let mut group: Vec<usize> = (0..count).collect();
        let is_near: Vec<bool> = (0..count)
            .map(|k| away(&self.corners(k)) < self.of.reach())
            .collect();
        for triangle in (0..count).filter(|&k| is_near[k]) {
            sum += self.spring(x, &self.corners(triangle), 1.0, slope);
        }
        let mut edges: Vec<(f64, &Hinge)> = (self.hinges.iter())
            .filter(|hinge| hinge.triangles.iter().all(|&k| is_near[k]))
            .map(|hinge| (away(&hinge.corners[..2]), hinge))
            .collect();
        edges.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (_, hinge) in edges {
            let [one, other] = hinge.triangles.map(|k| group[k]);
            if one != other {
                group
                    .iter_mut()
                    .filter(|k| **k == other)
                    .for_each(|k| *k = one);
                sum += self.spring(x, &hinge.corners[..2], -1.0, slope);
            }
        }
        sum
    }

    /// Least energy by the method of Broyden, Fletcher, Goldfarb and Shanno with limited memory (Nocedal & Wright 2006, algorithm
    /// 7.4).
    fn least(&self, mut x: Vec<DVec3>) -> Vec<DVec3> {
        const MEMORY: usize = 30;
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        let enough = 1e-9 * self.of.mass * self.of.gravity;
        let mut slope = vec![DVec3::ZERO; x.len()];
        let mut energy = self.at(&x, &mut slope);
        let mut memory: Vec<(Vec<DVec3>, Vec<DVec3>, f64)> = Vec::new();
        for _ in 0..20_000 {
            if slope.iter().all(|slope| slope.length() < enough) {
                return x;
            }
            let mut way: Vec<DVec3> = slope.iter().map(|slope| -*slope).collect();
            let mut parts = Vec::new();
            for (moved, turned, inverse) in memory.iter().rev() {
                let part = inverse * dot(moved, &way);
                parts.push(part);
                way.iter_mut()
                    .zip(turned)
                    .for_each(|(way, y)| *way -= *y * part);
            }
            if let Some((moved, turned, _)) = memory.last() {
                let scale = dot(moved, turned) / dot(turned, turned);
                way.iter_mut().for_each(|way| *way *= scale);
            } else {
                let scale = 1e-4 / dot(&way, &way).sqrt();
                way.iter_mut().for_each(|way| *way *= scale);
            }
            for ((moved, turned, inverse), part) in memory.iter().zip(parts.iter().rev()) {
                let other = inverse * dot(turned, &way);
                way.iter_mut()
                    .zip(moved)
                    .for_each(|(way, s)| *way += *s * (part - other));
            }
            let first = dot(&way, &slope);
            let mut length = 1.0;
            let mut next_slope = slope.clone();
            let (next, next_energy) = loop {
                let next: Vec<DVec3> = x
                    .iter()
                    .zip(&way)
                    .map(|(x, way)| *x + *way * length)
                    .collect();
                let next_energy = self.at(&next, &mut next_slope);
                // Near the end the energy has no digits left; the slope along the way has.
                let is_lower = next_energy <= energy + 1e-4 * length * first;
                let is_flatter = dot(&way, &next_slope).abs() <= 0.9 * first.abs()
                    && next_energy <= energy + 1e-12 * energy.abs();
                if is_lower || is_flatter {
                    break (next, next_energy);
                }
                length *= 0.5;
                if length < 1e-12 {
                    memory.clear();
                    break (x.clone(), energy);
                }
            };
            let moved: Vec<DVec3> = next.iter().zip(&x).map(|(a, b)| *a - *b).collect();
            let turned: Vec<DVec3> = next_slope
                .iter()
                .zip(&slope)
                .map(|(a, b)| *a - *b)
                .collect();
            let product = dot(&moved, &turned);
            if product > 0.0 {
                memory.push((moved, turned, product.recip()));
                if memory.len() > MEMORY {
                    memory.remove(0);
                }
            }
            (x, slope, energy) = (next, next_slope, next_energy);
        }
        let left = slope.iter().map(|slope| slope.length()).fold(0.0, f64::max);
        panic!("the least of the energy was not found: {left:e} N are left");
    }
}

/// The nearest point of a triangle or an edge, and the weights of its corners.
fn nearest(x: &[DVec3], corners: &[usize], centre: DVec3) -> (DVec3, [f64; 3]) {
    let [a, b] = [x[corners[0]], x[corners[1]]];
    let part = |from: DVec3, way: DVec3, to: DVec3| (to - from).dot(way) / way.length_squared();
    let Some(&third) = corners.get(2) else {
        let along = part(a, b - a, centre).clamp(0.0, 1.0);
        return (a + (b - a) * along, [1.0 - along, along, 0.0]);
    };
    let c = x[third];
    let foot = nearest_point([a, b, c], centre);
    let normal = (b - a).cross(c - a);
    let of_b = (foot - a).cross(c - a).dot(normal) / normal.length_squared();
    let of_c = (b - a).cross(foot - a).dot(normal) / normal.length_squared();
    (foot, [1.0 - of_b - of_c, of_b, of_c])
}
