//! A Python script that opens series in ParaView with sensible glyphs.

use std::fmt::Write as _;

/// Series of files that there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ScriptParts {
    /// `<prefix>.particles.pvd`.
    pub particles: bool,
    /// `<prefix>.contacts.pvd`.
    pub contacts: bool,
    /// `<prefix>.walls.pvd`.
    pub walls: bool,
    /// `<prefix>.bodies.pvd`.
    pub bodies: bool,
    /// `<prefix>.clumps.pvd`.
    pub clumps: bool,
    /// `<prefix>.bridges.pvd`.
    pub bridges: bool,
    /// `<prefix>.droplets.pvd`.
    pub droplets: bool,
    /// `<prefix>.membranes.pvd`.
    pub membranes: bool,
    /// `<prefix>.bonds.pvd`.
    pub bonds: bool,
}

/// A Python string literal.
fn python_literal(text: &str) -> String {
    let mut quoted = String::from('"');
    for letter in text.chars() {
        match letter {
            '\\' | '"' => quoted.extend(['\\', letter]),
            letter if letter.is_control() => {
                let _ = write!(quoted, "\\x{:02x}", u32::from(letter));
            }
            letter => quoted.push(letter),
        }
    }
    quoted.push('"');
    quoted
}

/// The script: particles as spheres of their diameter, coloured by speed; walls translucent; contacts as lines coloured by force and bonds
/// by stress, hidden at first. It finds the files beside itself, and saves a picture if it is given a name.
#[must_use]
pub fn script(prefix: &str, parts: ScriptParts) -> String {
    let mut text = String::new();
    let quoted = python_literal(prefix);
    let _ = writeln!(
        text,
        r#"# Opens this run in ParaView:   paraview --script=THIS_FILE
# or as a picture of the last frame:   pvpython THIS_FILE PICTURE.png
import os
import sys
from paraview.simple import *

here = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()
prefix = {quoted}
view = GetActiveViewOrCreate("RenderView")


def series(kind):
    reader = PVDReader(registrationName=prefix + "." + kind, FileName=os.path.join(here, prefix + "." + kind + ".pvd"))
    reader.UpdatePipeline(max(reader.TimestepValues or [0.0]))
    return reader
"#
    );
    if parts.particles {
        text.push_str(
            r#"
particles = series("particles")
shown = Show(particles, view)
names = [array.Name for array in particles.PointData]
shown.SetRepresentationType("3D Glyphs")
shown.GlyphType = "Sphere"
shown.GlyphType.ThetaResolution = 16
shown.GlyphType.PhiResolution = 16
if "diameter" in names:
    # The glyph has diameter 1.
    shown.Scaling = True
    shown.ScaleMode = "Magnitude"
    shown.SelectScaleArray = "diameter"
    shown.ScaleFactor = 1.0
if "speed" in names:
    ColorBy(shown, ("POINTS", "speed"))
    shown.SetScalarBarVisibility(view, True)
"#,
        );
    }
    if parts.membranes {
        text.push_str(
            r#"
membranes = series("membranes")
sheet_display = Show(membranes, view)
ColorBy(sheet_display, ("CELLS", "tension_1"))
sheet_display.SetScalarBarVisibility(view, True)
"#,
        );
    }
    if parts.walls {
        text.push_str(
            r#"
walls = series("walls")
wall_display = Show(walls, view)
wall_display.SetRepresentationType("Surface")
wall_display.Opacity = 0.2
wall_display.ColorArrayName = ["POINTS", ""]
"#,
        );
    }
    if parts.clumps {
        text.push_str(
            r#"
clumps = series("clumps")
clump_display = Show(clumps, view)
clump_display.SetRepresentationType("Surface")
ColorBy(clump_display, ("CELLS", "speed"))
"#,
        );
    }
    if parts.bodies {
        text.push_str(
            r#"
bodies = series("bodies")
body_display = Show(bodies, view)
body_display.SetRepresentationType("Points")
Hide(bodies, view)
"#,
        );
    }
    if parts.contacts {
        text.push_str(
            r#"
contacts = series("contacts")
contact_display = Show(contacts, view)
contact_display.SetRepresentationType("Wireframe")
contact_display.LineWidth = 3.0
ColorBy(contact_display, ("CELLS", "force_magnitude"))
Hide(contacts, view)
"#,
        );
    }
    if parts.bridges {
        text.push_str(
            r#"
bridges = series("bridges")
bridge_display = Show(bridges, view)
bridge_display.SetRepresentationType("Wireframe")
bridge_display.LineWidth = 4.0
ColorBy(bridge_display, ("CELLS", "bridge_volume"))
Hide(bridges, view)
"#,
        );
    }
    if parts.bonds {
        text.push_str(
            r#"
bonds = series("bonds")
bond_display = Show(bonds, view)
bond_display.SetRepresentationType("Wireframe")
bond_display.LineWidth = 4.0
ColorBy(bond_display, ("CELLS", "stress"))
Hide(bonds, view)
"#,
        );
    }
    if parts.droplets {
        text.push_str(
            r#"
droplets = series("droplets")
droplet_display = Show(droplets, view)
droplet_display.SetRepresentationType("3D Glyphs")
droplet_display.GlyphType = "Sphere"
droplet_display.Scaling = True
droplet_display.ScaleMode = "Magnitude"
droplet_display.SelectScaleArray = "diameter"
droplet_display.ScaleFactor = 1.0
droplet_display.ColorArrayName = ["POINTS", ""]
droplet_display.AmbientColor = [0.25, 0.5, 0.85]
droplet_display.DiffuseColor = [0.25, 0.5, 0.85]
"#,
        );
    }
    text.push_str(
        r#"
scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.GoToLast()
"#,
    );
    if parts.particles {
        text.push_str("shown.RescaleTransferFunctionToDataRange(False, True)\n");
    }
    if parts.clumps {
        // One range of colours for speeds of spheres and of clumps.
        let _ = writeln!(
            text,
            "clump_display.RescaleTransferFunctionToDataRange({}, True)",
            if parts.particles { "True" } else { "False" }
        );
        if !parts.particles {
            text.push_str("clump_display.SetScalarBarVisibility(view, True)\n");
        }
    }
    text.push_str(
        r#"view.CameraPosition = [0.0, -1.0, 0.0]
view.CameraFocalPoint = [0.0, 0.0, 0.0]
view.CameraViewUp = [0.0, 0.0, 1.0]
view.ResetCamera()
Render(view)
if len(sys.argv) > 1 and sys.argv[-1].endswith(".png"):
    SaveScreenshot(sys.argv[-1], view, ImageResolution=[1200, 900])
"#,
    );
    text
}
