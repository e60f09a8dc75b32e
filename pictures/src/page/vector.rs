//! A scene as SVG shapes.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use glam::DVec3;

use crate::camera::Lens;
use crate::colour::Colour;
use crate::frame::{is_place, is_width};
use crate::render::{Look, WALL_EDGE, facing, folded_edges, shaded};
use crate::svg::short;

/// The most circles of a file, ...
const MOST_CIRCLES: usize = 20_000;
/// ... and the most triangles.
const MOST_TRIANGLES: usize = 20_000;
/// Hidden spheres are found on a raster of this many cells along the larger side of the window.
const CELLS: f64 = 1200.0;

/// Something to be painted.
struct Shape {
    /// Depth of its middle.
    depth: f64,
    what: What,
}

enum What {
    Circle {
        x: f64,
        y: f64,
        radius: f64,
        colour: Colour,
        opacity: f64,
    },
    Polygon {
        points: [(f64, f64); 3],
        colour: Colour,
        opacity: f64,
    },
    Line {
        from: (f64, f64),
        to: (f64, f64),
        colour: Colour,
        width: f64,
    },
}

/// Adds the scene of window number `number` to `svg`; returns how many spheres it shows.
pub(super) fn draw(svg: &mut String, number: usize, lens: &Lens, look: &Look) -> usize {
    let window = lens.window();
    let middle = (
        window.x as f64 + 0.5 * window.width as f64,
        window.y as f64 + 0.5 * window.height as f64,
    );
    let on_page = |place: DVec3| {
        let (x, y) = lens.project(place)?;
        (x.is_finite() && y.is_finite()).then_some((middle.0 + x, middle.1 + y))
    };
    let mut shapes = circles(lens, look, on_page);
    let drawn = shapes.len();
    polygons(lens, look, on_page, &mut shapes);
    lines(lens, look, on_page, &mut shapes);
    shapes.sort_by(|a, b| f64::total_cmp(&b.depth, &a.depth));

    let mut gradients: BTreeMap<(u8, u8, u8), usize> = BTreeMap::new();
    let mut markup = String::new();
    for shape in &shapes {
        write_shape(
            &mut markup,
            &shape.what,
            look.frame.flat,
            number,
            &mut gradients,
        );
    }
    svg.push_str("<defs>\n");
    let _ = writeln!(
        svg,
        "<clipPath id=\"window{number}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>",
        window.x, window.y, window.width, window.height
    );
    for ((r, g, b), gradient) in &gradients {
        write_gradient(svg, number, *gradient, Colour(*r, *g, *b));
    }
    let _ = write!(
        svg,
        "</defs>\n<g clip-path=\"url(#window{number})\" stroke-linecap=\"round\">\n{markup}</g>\n"
    );
    drawn
}

/// The spheres in the window that something is seen of.
fn circles(lens: &Lens, look: &Look, on_page: impl Fn(DVec3) -> Option<(f64, f64)>) -> Vec<Shape> {
    let window = lens.window();
    let (x0, y0) = (window.x as f64, window.y as f64);
    let (width, height) = (window.width as f64, window.height as f64);
    let mut seen = Vec::new();
    for (sphere, colour) in look.spheres.iter().zip(&look.sphere_colours) {
        if !sphere.is_drawable() {
            continue;
        }
        let place = lens.place(sphere.centre);
        let Some((x, y)) = on_page(place) else {
            continue;
        };
        let shrink = lens.distance().map_or(1.0, |d| d / (d + place.z));
        let radius = (sphere.radius * lens.target_scale() * shrink).max(0.3);
        let inside = |at: f64, low: f64, size: f64| at + radius > low && at - radius < low + size;
        if inside(x, x0, width) && inside(y, y0, height) && radius.is_finite() {
            seen.push((place.z, radius, x, y, *colour));
        }
    }
    let opaque = look.sphere_opacity >= 1.0;
    if seen.len() > MOST_CIRCLES / 4 && opaque && !look.frame.flat {
        seen = in_sight(seen, (x0, y0), (width, height));
    }
    if seen.len() > MOST_CIRCLES {
        // The ones that cover most; of equals the nearest.
        seen.sort_by(|a, b| f64::total_cmp(&b.1, &a.1).then(f64::total_cmp(&a.0, &b.0)));
        seen.truncate(MOST_CIRCLES);
    }
    seen.into_iter()
        .map(|(depth, radius, x, y, colour)| Shape {
            depth,
            what: What::Circle {
                x,
                y,
                radius,
                colour: coarse(colour),
                opacity: look.sphere_opacity,
            },
        })
        .collect()
}

/// Depth, radius, x, y, colour.
type Seen = (f64, f64, f64, f64, Colour);

/// Those that own at least one cell of a coarse raster.
fn in_sight(seen: Vec<Seen>, (x0, y0): (f64, f64), (width, height): (f64, f64)) -> Vec<Seen> {
    let cell = width.max(height) / CELLS;
    let (columns, rows) = (
        (width / cell).ceil().max(1.0) as usize,
        (height / cell).ceil().max(1.0) as usize,
    );
    let mut owner = vec![(f64::INFINITY, usize::MAX); columns * rows];
    for (number, (depth, radius, x, y, _)) in seen.iter().enumerate() {
        let (x, y, radius) = ((x - x0) / cell, (y - y0) / cell, (radius / cell).max(0.71));
        let range = |middle: f64, end: usize| {
            let low = (middle - radius - 0.5).ceil().max(0.0) as usize;
            low..((middle + radius + 0.5).floor().max(0.0) as usize).min(end)
        };
        for row in range(y, rows) {
            for column in range(x, columns) {
                let (dx, dy) = (column as f64 + 0.5 - x, row as f64 + 0.5 - y);
                let height = radius * radius - dx * dx - dy * dy;
                let here = depth - height.max(0.0).sqrt() * cell;
                let best = &mut owner[row * columns + column];
                if height >= 0.0 && here < best.0 {
                    *best = (here, number);
                }
            }
        }
    }
    let mut visible = vec![false; seen.len()];
    for (_, number) in owner {
        if let Some(flag) = visible.get_mut(number) {
            *flag = true;
        }
    }
    let mut keep = visible.into_iter();
    seen.into_iter()
        .filter(|_| keep.next().unwrap_or(false))
        .collect()
}

/// A colour on a grid of 4 levels' spacing: fewer gradients than the eye can count.
fn coarse(Colour(r, g, b): Colour) -> Colour {
    Colour(r & 0xfc, g & 0xfc, b & 0xfc)
}

fn polygons(
    lens: &Lens,
    look: &Look,
    on_page: impl Fn(DVec3) -> Option<(f64, f64)>,
    shapes: &mut Vec<Shape>,
) {
    let mut left = MOST_TRIANGLES;
    let mut push = |triangle: &[DVec3; 3], opacity: f64, colour: &dyn Fn(DVec3) -> Colour| {
        if left == 0 || !triangle.iter().all(|corner| is_place(*corner)) {
            return;
        }
        let places = triangle.map(|corner| lens.place(corner));
        let [Some(a), Some(b), Some(c)] = places.map(&on_page) else {
            return;
        };
        left -= 1;
        let normal = (places[1] - places[0]).cross(places[2] - places[0]);
        shapes.push(Shape {
            depth: places.iter().map(|place| place.z).sum::<f64>() / 3.0,
            what: What::Polygon {
                points: [a, b, c],
                colour: colour(normal),
                opacity: opacity.clamp(0.0, 1.0),
            },
        });
    };
    for surface in &look.frame.surfaces {
        let colour = surface.colour.unwrap_or(look.theme.surface);
        for triangle in &surface.triangles {
            push(triangle, surface.opacity, &|_| colour);
        }
    }
    for (grain, colour) in look.frame.grains.iter().zip(&look.grain_colours) {
        for triangle in &grain.triangles {
            push(triangle, look.opacity_of(grain), &|normal| {
                shaded(*colour, normal)
            });
        }
    }
}

fn lines(
    lens: &Lens,
    look: &Look,
    on_page: impl Fn(DVec3) -> Option<(f64, f64)>,
    shapes: &mut Vec<Shape>,
) {
    let mut add = |from: DVec3, to: DVec3, colour: Colour, width: f64, pieces: usize| {
        if !is_place(from) || !is_place(to) || !is_width(width) {
            return;
        }
        // Painted by depth: a long line in pieces, because spheres may stand before one end and behind the other.
        for piece in 0..pieces {
            let at = |k: usize| lens.place(from + (to - from) * (k as f64 / pieces as f64));
            let (a, b) = (at(piece), at(piece + 1));
            if let (Some(from), Some(to)) = (on_page(a), on_page(b)) {
                shapes.push(Shape {
                    depth: 0.5 * (a.z + b.z),
                    what: What::Line {
                        from,
                        to,
                        colour,
                        width,
                    },
                });
            }
        }
    };
    let frame = look.frame;
    let window = lens.window();
    if look.shows_domain(lens, (window.width, window.height)) {
        for [from, to] in frame.domain_edges() {
            add(from, to, look.theme.domain, look.unit, 24);
        }
    }
    let width = WALL_EDGE * look.unit;
    for surface in frame.surfaces.iter().filter(|surface| surface.edges) {
        let line = width / lens.target_scale();
        for [from, to] in folded_edges(&surface.triangles, line, |normal| facing(lens, normal)) {
            add(from, to, look.theme.wall, width, 4);
        }
    }
    for line in &frame.lines {
        let colour = line.colour.unwrap_or(look.theme.wall);
        for pair in line.points.windows(2) {
            add(pair[0], pair[1], colour, line.width * look.unit, 4);
        }
    }
    for (contact, (colour, width)) in frame.contacts.iter().zip(&look.contacts) {
        add(contact.from, contact.to, *colour, *width, 1);
    }
}

fn write_shape(
    svg: &mut String,
    what: &What,
    flat: bool,
    number: usize,
    gradients: &mut BTreeMap<(u8, u8, u8), usize>,
) {
    let fade = |name: &str, opacity: f64| {
        if opacity < 1.0 {
            format!(" {name}=\"{opacity:.3}\"")
        } else {
            String::new()
        }
    };
    let _ = match what {
        What::Circle {
            x,
            y,
            radius,
            colour,
            opacity,
        } => {
            let place = format!(
                "cx=\"{}\" cy=\"{}\" r=\"{}\"",
                short(*x),
                short(*y),
                short(*radius)
            );
            let fade = fade("opacity", *opacity);
            if flat {
                let rim = colour.lit(0.45).hex();
                let width = short((0.06 * radius).clamp(0.2, 1.2));
                writeln!(
                    svg,
                    "<circle {place} fill=\"{}\" stroke=\"{rim}\" stroke-width=\"{width}\"{fade}/>",
                    colour.hex()
                )
            } else {
                let next = gradients.len();
                let key = (colour.0, colour.1, colour.2);
                let gradient = *gradients.entry(key).or_insert(next);
                writeln!(
                    svg,
                    "<circle {place} fill=\"url(#s{number}-{gradient})\"{fade}/>"
                )
            }
        }
        What::Polygon {
            points,
            colour,
            opacity,
        } => {
            let text: Vec<String> = (points.iter())
                .map(|(x, y)| format!("{},{}", short(*x), short(*y)))
                .collect();
            writeln!(
                svg,
                "<polygon points=\"{}\" fill=\"{}\"{}/>",
                text.join(" "),
                colour.hex(),
                fade("fill-opacity", *opacity)
            )
        }
        What::Line {
            from,
            to,
            colour,
            width,
        } => writeln!(
            svg,
            "<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" stroke=\"{}\" stroke-width=\"{}\"/>",
            short(from.0),
            short(from.1),
            short(to.0),
            short(to.1),
            colour.hex(),
            short(*width)
        ),
    };
}

/// The shading of spheres of one colour.
fn write_gradient(svg: &mut String, number: usize, gradient: usize, colour: Colour) {
    let _ = write!(
        svg,
        "<radialGradient id=\"s{number}-{gradient}\" cx=\"0.5\" cy=\"0.5\" r=\"0.5\" fx=\"0.32\" fy=\"0.26\">"
    );
    for (at, colour) in [
        ("0", colour.mix(Colour::WHITE, 0.2)),
        ("0.3", colour),
        ("0.85", colour.lit(0.66)),
        ("1", colour.lit(0.38)),
    ] {
        let _ = write!(
            svg,
            "<stop offset=\"{at}\" stop-color=\"{}\"/>",
            colour.hex()
        );
    }
    svg.push_str("</radialGradient>\n");
}
