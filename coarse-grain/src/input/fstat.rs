//! Lines of `.fstat` as contacts.

use glam::DVec3;
use mercury_common::formats::fstat::FstatFrame;

use crate::state::{Contacts, Particles, Partner};

/// The contacts of a frame; of the two lines of a pair the one of the lower number is kept, or the only one.
///
/// The contact point is computed from the particle as MercuryDPM's reader does: `x - (R - overlap/2) n`.
///
/// # Errors
/// When a line names a particle that is not there.
pub(super) fn contacts(frame: &FstatFrame, particles: &Particles) -> Result<Contacts, String> {
    let count = particles.len();
    let row = |index: i64| -> Result<usize, String> {
        usize::try_from(index)
            .ok()
            .filter(|&row| row < count)
            .ok_or_else(|| {
                format!(
                    "the contacts at t = {} name particle {index}; the particles are 0 to {}",
                    frame.time,
                    count as i64 - 1
                )
            })
    };
    let mut out = Contacts::default();
    for line in &frame.contacts {
        let i = row(line.i)?;
        let (partner, normal, distance) = if line.j < 0 {
            let wall = u32::try_from(-(line.j + 1)).unwrap_or(u32::MAX);
            (Partner::Wall(wall), -line.normal, 0.0)
        } else {
            let j = row(line.j)?;
            if j == i {
                return Err(format!(
                    "the contacts at t = {} have particle {i} touch itself",
                    frame.time
                ));
            }
            // The line of the higher number repeats the other one, unless that is of a fixed particle and left out.
            if j < i && particles.flowing[j] {
                continue;
            }
            if !particles.flowing[i] && !particles.flowing[j] {
                continue;
            }
            let distance = particles.radius[i] + particles.radius[j] - line.overlap;
            (Partner::Particle(j as u32), line.normal, distance)
        };
        // A line of a fixed particle that some writers leave in: its partner's line holds the same.
        if let Partner::Particle(j) = partner
            && j as usize > i
            && !particles.flowing[i]
        {
            continue;
        }
        let arm = (particles.radius[i] - 0.5 * line.overlap) * normal;
        let partner_arm = if line.j < 0 {
            DVec3::ZERO
        } else {
            arm - distance * normal
        };
        out.particle.push(i as u32);
        out.partner.push(partner);
        out.point.push(particles.position[i] - arm);
        out.arm.push(arm);
        out.partner_arm.push(partner_arm);
        out.normal.push(normal);
        out.force.push(line.force());
    }
    Ok(out)
}
