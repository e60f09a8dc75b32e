//! Particles that left a run: by each face of the domain, each deletion, and each plane.

use std::fs;
use std::io;
use std::path::Path;

use mercury_common::formats::delimited::Rows;
use mercury_common::readable::rounded;
use mercury_common::surfaces::FACES;

use super::RunOptions;
use crate::plan::Plan;
use mercury_engine::boundaries::Tally;
use mercury_engine::step::Engine;

/// A line for each face and deletion through which a particle left, and for each flux plane.
pub(super) fn reported(plan: &Plan, engine: &Engine, options: &RunOptions) -> Vec<String> {
    let boundaries = engine.boundaries();
    let amount = |tally: &Tally| format!("{}, {} kg", tally.number, rounded(tally.mass, 6));
    let mut lines = Vec::new();
    for (face, tally) in FACES.iter().zip(boundaries.faces()) {
        if tally.number > 0 {
            lines.push(format!("through the face {face}: {}", amount(tally)));
        }
    }
    for (deletion, tally) in (plan.physics().deletions.iter()).zip(boundaries.deletions()) {
        lines.push(format!("into `{}`: {}", deletion.name, amount(tally)));
    }
    if plan.outputs().fluxes().is_empty() {
        return lines;
    }
    // The counts of a resumed run are in its file only.
    let path = options
        .folder
        .join(format!("{}.flux.csv", plan.outputs().prefix()));
    let text = fs::read_to_string(&path);
    let names = plan.outputs().fluxes().iter().map(|flux| &flux.name);
    lines.extend(names.map(|name| through(name, &path, &text)));
    lines
}

/// The counts of a plane from the text of its file, or the reason why they are not known.
fn through(name: &str, path: &Path, text: &io::Result<String>) -> String {
    let reported = match text {
        Ok(text) => match crossed(text, name) {
            Some([forward, backward, mass]) => {
                let mass = rounded(mass, 6);
                format!("{forward} along its normal and {backward} back, {mass} kg in all")
            }
            None => format!("not known, as {} has no header any more", path.display()),
        },
        Err(error) => format!("not known, as {} cannot be read: {error}", path.display()),
    };
    format!("through `{name}`: {reported}")
}

/// Sums over the rows of a plane: the particles that crossed along its normal and back, and their mass (kg), with those back
/// counted negative.
fn crossed(text: &str, name: &str) -> Option<[f64; 3]> {
    let rows = Rows::new(text);
    let name_at = rows.place("name")?;
    let mut places = [0; 3];
    for (place, column) in places.iter_mut().zip(["forward", "backward", "mass"]) {
        *place = rows.place(column)?;
    }
    let mut sums = [0.0; 3];
    for row in rows.filter(|row| row[name_at] == name) {
        for (sum, place) in sums.iter_mut().zip(places) {
            *sum += row[place].parse::<f64>().unwrap_or(0.0);
        }
    }
    Some(sums)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_a_plane_are_summed() {
        let text = "time,name,material,forward,backward,mass\n0,gate,m,0,0,0\n1,gate,\"m, n\",3,1,0.5\n1,\"a, b\",m,9,9,9\n2,gate,m,2,0,0.25\n";
        assert_eq!(crossed(text, "gate"), Some([5.0, 1.0, 0.75]));
        let with_units = text
            .replace("time,", "time [s],")
            .replace("mass\n", "mass [kg]\n");
        assert_eq!(crossed(&with_units, "gate"), crossed(text, "gate"));
        assert_eq!(crossed(text, "a, b"), Some([9.0, 9.0, 9.0]));
        assert_eq!(crossed(text, "ga"), Some([0.0; 3]));
        assert_eq!(crossed("", "gate"), None);
    }

    /// A missing file was reported as an empty one.
    #[test]
    fn what_cannot_be_read_is_said() {
        let path = Path::new("run/drum.flux.csv");
        let missing = io::Error::from(io::ErrorKind::PermissionDenied);
        assert_eq!(
            through("gate", path, &Err(missing)),
            "through `gate`: not known, as run/drum.flux.csv cannot be read: permission denied"
        );
        assert_eq!(
            through("gate", path, &Ok("time,na".to_owned())),
            "through `gate`: not known, as run/drum.flux.csv has no header any more"
        );
        let text = "time,name,material,forward,backward,mass\n1,gate,m,3,1,0.5\n".to_owned();
        assert_eq!(
            through("gate", path, &Ok(text)),
            "through `gate`: 3 along its normal and 1 back, 0.5 kg in all"
        );
    }
}
