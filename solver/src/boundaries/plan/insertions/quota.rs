//! Numbers of each size that are fixed before the first particle comes.

use mercury_common::scene::{Insertion, Scene, SceneError, Total};

use mercury_engine::boundaries::mean_volume;
use mercury_engine::boundaries::{Ingredient, MOST_OF_QUOTA};

/// Why numbers cannot be fixed in advance.
pub(super) fn wrong_quota(
    scene: &Scene,
    insertion: &Insertion,
    mixture: &[Ingredient],
    total: Option<Total>,
    dimensions: u8,
) -> Option<SceneError> {
    let mean = |weight: &dyn Fn(&Ingredient) -> f64| -> f64 {
        let of =
            |part: &Ingredient| part.share * weight(part) * mean_volume(&part.sizes, dimensions);
        mixture.iter().map(of).sum()
    };
    let density = |part: &Ingredient| {
        let material = scene.materials.get(part.material.index());
        material.map_or(f64::NAN, |material| *material.density)
    };
    let number = match total {
        Some(Total::Number(number)) => number as f64,
        Some(Total::Volume(volume)) => volume / mean(&|_| 1.0),
        Some(Total::Mass(mass)) => mass / mean(&density),
        Some(Total::Full) | None => {
            let message = "needs a total: the number of each size is fixed before the first comes";
            let error = insertion.method.place.error(message);
            return Some(error.with_help(
                "give total = { number | mass | volume = ... }, or use method = \"random\"",
            ));
        }
    };
    (number > MOST_OF_QUOTA).then(|| {
        let message = format!(
            "{number:.3e} particles are expected, and a quota lists at most {MOST_OF_QUOTA:.0e}"
        );
        let error = insertion.method.place.error(message);
        error.with_help("are the units of the diameters right? Else use method = \"random\"")
    })
}
