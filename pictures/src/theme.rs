//! The colours of everything that does not show a value.

use crate::colour::Colour;
use crate::colour_map::ColourMap;
use crate::options::Background;

/// Colours that go with a background.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Theme {
    /// Colour of the background; none: the picture is transparent there.
    pub(crate) paper: Option<Colour>,
    /// Text.
    pub(crate) ink: Colour,
    /// Secondary text.
    pub(crate) soft_ink: Colour,
    /// Outlines of the domain.
    pub(crate) domain: Colour,
    /// Outlines of walls.
    pub(crate) wall: Colour,
    /// Surfaces of walls.
    pub(crate) surface: Colour,
    /// Spheres when colours show nothing.
    pub(crate) plain: Colour,
    /// Fixed particles.
    pub(crate) fixed: Colour,
    /// Particles without a value.
    pub(crate) missing: Colour,
    /// Droplets without a value.
    pub(crate) droplet: Colour,
    /// Contacts by strength.
    pub(crate) contacts: ColourMap,
    /// The arrow of gravity.
    pub(crate) gravity: Colour,
    /// Colour into which distance fades.
    pub(crate) haze: Colour,
}

impl Theme {
    pub(crate) fn new(background: Background) -> Self {
        let light = Self {
            paper: Some(Colour::WHITE),
            ink: Colour::INK,
            soft_ink: Colour::SOFT_INK,
            domain: Colour::DOMAIN,
            wall: Colour::WALL,
            surface: Colour(120, 140, 165),
            plain: Colour(196, 184, 160),
            fixed: Colour::FIXED,
            missing: Colour(120, 116, 122),
            droplet: Colour(70, 150, 220),
            contacts: ColourMap::Embers,
            gravity: Colour(190, 72, 50),
            haze: Colour(236, 239, 243),
        };
        match background {
            Background::Light => light,
            Background::Transparent => Self {
                paper: None,
                ..light
            },
            Background::Dark => Self {
                paper: Some(Colour(17, 20, 26)),
                ink: Colour(232, 235, 240),
                soft_ink: Colour(160, 168, 180),
                domain: Colour(92, 102, 118),
                wall: Colour(150, 162, 180),
                surface: Colour(150, 175, 205),
                plain: Colour(206, 192, 166),
                fixed: Colour(130, 134, 140),
                missing: Colour(96, 92, 100),
                droplet: Colour(110, 180, 240),
                contacts: ColourMap::Inferno,
                gravity: Colour(236, 120, 92),
                haze: Colour(34, 40, 50),
            },
        }
    }
}
