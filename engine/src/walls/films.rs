//! Liquid on walls: by triangle on a mesh, as a whole on any other shape.

use std::f64::consts::PI;

use super::{Shape, WallNow};

/// The film of a wall at the start.
#[derive(Debug, Clone, PartialEq)]
pub struct WallFilmPlan {
    /// Areas of the triangles of a mesh, of another shape that of the whole, m^2; 0 where there is no surface.
    pub areas: Vec<f64>,
    /// Volumes at the start, of each of them, m^3.
    pub volumes: Vec<f64>,
    /// Share of a broken bridge's liquid that stays on the wall.
    pub keeps: f64,
}

/// Liquid on a wall.
#[derive(Debug, Clone, PartialEq)]
struct WallFilm {
    areas: Vec<f64>,
    keeps: f64,
    /// m^3, of each triangle.
    volumes: Vec<f64>,
}

/// The films of all walls, in the order of the plan.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WallFilms {
    walls: Vec<Option<WallFilm>>,
}

/// A place that holds liquid: the wall, and the triangle.
pub type WallPlace = (usize, usize);

/// Film of a shape that holds the liquid at a feature: of an edge or a corner of a mesh that of the first of its triangles.
#[must_use]
pub fn film_at(shape: &Shape, feature: u32) -> Option<usize> {
    let Shape::Mesh(mesh) = shape else {
        return Some(0);
    };
    let mut triangles = Vec::new();
    mesh.triangles_of(feature, &mut triangles);
    triangles.first().map(|&triangle| triangle as usize)
}

impl WallFilms {
    /// Films at the start.
    #[must_use]
    pub fn start(plan: &[Option<WallFilmPlan>]) -> Self {
        let film = |plan: &WallFilmPlan| WallFilm {
            areas: plan.areas.clone(),
            keeps: plan.keeps,
            volumes: plan.volumes.clone(),
        };
        Self {
            walls: plan.iter().map(|plan| plan.as_ref().map(film)).collect(),
        }
    }

    /// Whether no wall holds liquid.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.walls.iter().all(Option::is_none)
    }

    /// Where the liquid at a feature of a wall is held: of an edge or a corner on the first of its triangles. `None` for a wall that holds
    /// none.
    #[must_use]
    pub fn place(&self, wall: usize, feature: u32, walls: &[WallNow]) -> Option<WallPlace> {
        let film = self.walls.get(wall)?.as_ref()?;
        let triangle = film_at(walls.get(wall)?.shape(), feature)?;
        (triangle < film.volumes.len()).then_some((wall, triangle))
    }

    fn film(&self, (wall, triangle): WallPlace) -> Option<(&WallFilm, usize)> {
        let film = self.walls.get(wall)?.as_ref()?;
        (triangle < film.volumes.len()).then_some((film, triangle))
    }

    /// The liquid at a place, m^3.
    #[must_use]
    pub fn volume(&self, place: WallPlace) -> f64 {
        self.film(place).map_or(0.0, |(film, k)| film.volumes[k])
    }

    /// Volume that a grain of this radius (m) can take of it, m^3: the share of the triangle that its shadow covers.
    #[must_use]
    pub fn within_reach(&self, place: WallPlace, radius: f64) -> f64 {
        self.film(place).map_or(0.0, |(film, k)| {
            let shadow = PI * radius * radius;
            if shadow < film.areas[k] {
                film.volumes[k] * (shadow / film.areas[k])
            } else {
                film.volumes[k]
            }
        })
    }

    /// How thick the film is, m.
    #[must_use]
    pub fn thickness(&self, place: WallPlace) -> f64 {
        self.film(place).map_or(0.0, |(film, k)| {
            if film.areas[k] > 0.0 {
                film.volumes[k] / film.areas[k]
            } else {
                0.0
            }
        })
    }

    /// Share of a broken bridge's liquid that stays there.
    #[must_use]
    pub fn keeps(&self, place: WallPlace) -> f64 {
        self.film(place).map_or(0.0, |(film, _)| film.keeps)
    }

    /// Replaces the liquid at a place, m^3.
    pub fn set(&mut self, (wall, triangle): WallPlace, volume: f64) {
        if let Some(Some(film)) = self.walls.get_mut(wall)
            && let Some(held) = film.volumes.get_mut(triangle)
        {
            *held = volume;
        }
    }

    /// All volumes, m^3, wall by wall.
    pub fn all(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        let films = self.walls.iter().flatten();
        films.flat_map(|film| film.volumes.iter().copied())
    }

    /// Every film shrinks by this thickness (m) at most; what is gone is handed to `gone`, m^3.
    pub fn shrink(&mut self, thickness: f64, mut gone: impl FnMut(f64)) {
        for film in self.walls.iter_mut().flatten() {
            for (volume, area) in film.volumes.iter_mut().zip(&film.areas) {
                let before = *volume;
                if before > 0.0 {
                    *volume = (before - thickness * area).max(0.0);
                    gone(before - *volume);
                }
            }
        }
    }

    /// State in a checkpoint: the volumes of each wall, none of walls that hold no liquid.
    #[must_use]
    pub fn save(&self) -> Vec<Vec<f64>> {
        let volumes = |film: &Option<WallFilm>| {
            film.as_ref()
                .map_or_else(Vec::new, |film| film.volumes.clone())
        };
        self.walls.iter().map(volumes).collect()
    }

    /// Takes over what a checkpoint kept; whether it fits the walls of the plan.
    pub fn restore(&mut self, saved: &[Vec<f64>]) -> bool {
        let fits = saved.len() == self.walls.len()
            && saved.iter().zip(&self.walls).all(|(saved, film)| {
                saved.len() == film.as_ref().map_or(0, |film| film.volumes.len())
                    && saved
                        .iter()
                        .all(|&volume| volume >= 0.0 && volume.is_finite())
            });
        if fits {
            for (film, saved) in self.walls.iter_mut().zip(saved) {
                if let Some(film) = film {
                    film.volumes.clone_from(saved);
                }
            }
        }
        fits
    }
}
