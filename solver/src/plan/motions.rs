//! How walls move, in words.

use std::f64::consts::TAU;

use glam::DVec3;

use mercury_engine::contact::parameter::short;
use mercury_engine::walls::{Area, Component, Motion, Servo, Target};

/// A line for each part of a motion: axis, speed, time.
pub(crate) fn lines(motion: &Motion) -> Vec<String> {
    motion.components().iter().map(line).collect()
}

fn line(component: &Component) -> String {
    match component {
        Component::Translation {
            velocity,
            from,
            until,
        } => {
            let speed = velocity.length();
            let along = if speed > 0.0 {
                format!(" along {}", vector(*velocity / speed))
            } else {
                String::new()
            };
            format!(
                "goes at {} m/s{along}{}",
                short(speed),
                window(*from, *until)
            )
        }
        Component::Rotation {
            axis,
            origin,
            angular_velocity,
            from,
            until,
        } => format!(
            "turns about {} through {} m at {} rad/s = {} rpm{}",
            vector(*axis),
            vector(*origin),
            short(*angular_velocity),
            short(angular_velocity * 60.0 / TAU),
            window(*from, *until)
        ),
        Component::Oscillation {
            amplitude,
            frequency,
            phase,
            from,
            until,
        } => format!(
            "swings by {} m at {} Hz, phase {} degrees, at most {} m/s{}",
            vector(*amplitude),
            short(*frequency),
            short(phase.to_degrees()),
            short(TAU * frequency * amplitude.length()),
            window(*from, *until)
        ),
        Component::Table { table, .. } => {
            let [from, until] = table.displacement().ends();
            format!(
                "follows a table of {} rows{}",
                table.displacement().rows().len(),
                window(from, until)
            )
        }
        Component::Servo(servo) => of_servo(servo),
        Component::External => "driven by another program".to_owned(),
    }
}

fn of_servo(servo: &Servo) -> String {
    let (unit, rows) = (servo.target.unit(), servo.target.curve().rows());
    let load = match rows {
        [(_, value)] => format!("{} {unit}", short(*value)),
        rows => {
            let reported: Vec<String> = (rows.iter().take(4))
                .map(|(time, value)| format!("{} {unit} at {} s", short(*value), short(*time)))
                .collect();
            let rest = rows.len().saturating_sub(reported.len());
            let more = if rest > 0 {
                format!(" and {rest} more rows")
            } else {
                String::new()
            };
            format!("{}{more}", reported.join(", "))
        }
    };
    let over = match &servo.target {
        Target::Force(_) => String::new(),
        Target::Pressure(_, Area::Given(area)) => format!(" on {} m^2", short(*area)),
        Target::Pressure(_, Area::OfWall) => " on its area".to_owned(),
    };
    format!(
        "servo along {}: {load}{over}, at most {} m/s{}",
        vector(servo.axis),
        short(servo.max_speed),
        window(servo.from, servo.until)
    )
}

fn window(from: f64, until: f64) -> String {
    match (from > 0.0, until.is_finite()) {
        (false, false) => String::new(),
        (true, false) => format!(", from {} s on", short(from)),
        (false, true) => format!(", until {} s", short(until)),
        (true, true) => format!(", from {} to {} s", short(from), short(until)),
    }
}

pub(super) fn vector(v: DVec3) -> String {
    // Without the sign of zeros.
    let [x, y, z] = (v + DVec3::ZERO).to_array().map(short);
    format!("[{x}, {y}, {z}]")
}

#[cfg(test)]
mod tests {
    use super::*;
    use mercury_common::curve::Curve;

    #[test]
    fn what_moves_is_reported_with_axis_speed_and_time() {
        let forever = f64::INFINITY;
        let servo = |target, until| {
            Component::Servo(Servo {
                axis: -DVec3::Z,
                target,
                max_speed: 0.1,
                from: 0.0,
                until,
            })
        };
        let rows = Curve::new(vec![(0.0, 5.0), (1.5, 20.0)]).unwrap();
        let rotation = Component::Rotation {
            axis: DVec3::Y,
            origin: DVec3::new(0.5, 0.0, 0.0),
            angular_velocity: 0.2 * TAU,
            from: 1.0,
            until: forever,
        };
        let translation = Component::Translation {
            velocity: DVec3::new(0.0, -0.5, 0.0),
            from: 2.0,
            until: 3.0,
        };
        let pressure = Target::Pressure(Curve::constant(1e4).unwrap(), Area::OfWall);
        let motion = Motion::new(vec![rotation, translation, servo(Target::Force(rows), 2.0)]);
        assert_eq!(
            lines(&motion.unwrap()),
            [
                "turns about [0, 1, 0] through [0.5, 0, 0] m at 1.25664 rad/s = 12 rpm, from 1 s on",
                "goes at 0.5 m/s along [0, -1, 0], from 2 to 3 s",
                "servo along [0, 0, -1]: 5 N at 0 s, 20 N at 1.5 s, at most 0.1 m/s, until 2 s",
            ]
        );
        let motion = Motion::new(vec![servo(pressure, forever)]).unwrap();
        assert_eq!(
            lines(&motion),
            ["servo along [0, 0, -1]: 10000 Pa on its area, at most 0.1 m/s"]
        );
    }
}
