//! A ball that a partner integrates beside one that the engine integrates, momentum, and strong coupling.

use std::path::Path;

use glam::{DQuat, DVec3};
use mercury_solver::output::folder::Earlier;
use mercury_solver::run::{Advance, Claim, OpenRun, Run, SceneInput, WallDrive};

/// Step of all scenes here, s.
const STEP: f64 = 2e-5;
/// Radius of the ball, m, and where it starts.
const RADIUS: f64 = 8e-3;
const HEIGHT: f64 = 0.0201;
/// m/s and m/s^2
const SPEED: f64 = -0.5;
const GRAVITY: f64 = -9.81;

/// A ball falls on a column of three beads above a floor: motion along one line, which amplifies no round-off. Laws without effective masses or radii, so that the shape of a wall
/// and a particle act alike.
fn scene(ball: &str) -> String {
    format!(
        r#"
gravity = [0, 0, {GRAVITY}]
[time]
end = 0.1
step = {STEP}
[domain]
min = [-0.05, -0.05, -0.01]
max = [0.05, 0.05, 0.08]
[materials.glass]
density = 2500.0
normal = {{ law = "linear", stiffness = 400.0, dissipation = 0.05 }}
[[walls]]
name = "floor"
shape = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
material = "glass"
[[particles]]
material = "glass"
radius = 2e-3
position = [0, 0, 2e-3]
[[particles]]
material = "glass"
radius = 2e-3
position = [0, 0, 6e-3]
[[particles]]
material = "glass"
radius = 2e-3
position = [0, 0, 10e-3]
{ball}
[guard]
policy = "off"
[output]
interval = 0.01
"#
    )
}

fn inside() -> String {
    scene(&format!(
        "[[particles]]\nmaterial = \"glass\"\nradius = {RADIUS}\nposition = [0, 0, {HEIGHT}]\nvelocity = [0, 0, {SPEED}]"
    ))
}

fn outside() -> String {
    scene(&format!(
        "[[walls]]\nname = \"ball\"\nshape = \"sphere\"\norigin = [0, 0, {HEIGHT}]\nradius = {RADIUS}\nside = \"outside\"\nmaterial = \"glass\"\nmotion = \"external\""
    ))
}

fn open(text: &str, folder: &Path) -> (Run, Claim) {
    let opening = OpenRun {
        input: SceneInput {
            path: "ball.toml".into(),
            text: text.to_owned(),
            set: Vec::new(),
        },
        folder: folder.to_owned(),
        earlier: Earlier::Refuse,
        results: Vec::new(),
        threads: Some(1),
        checkpoint_every: None,
        called: String::new(),
        pause: Default::default(),
        pieces_observed: false,
    };
    opening.begin().unwrap()
}

fn advance(run: &mut Run, step: u64) {
    let reached = run.advance(step as f64 * STEP, &mut |_| ()).unwrap();
    assert_eq!(reached, Advance::Reached);
    assert_eq!(run.engine().steps(), step);
}

/// Mass of the ball, kg.
fn mass() -> f64 {
    2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS * RADIUS * RADIUS
}

/// Steps of all comparisons: down, to rest for a moment, and some of the way up.
const STEPS: u64 = 2000;

/// Heights of the ball inside the engine, step by step.
fn reference() -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    let (mut run, _claim) = open(&inside(), folder.path());
    let mut heights = vec![HEIGHT];
    for step in 1..=STEPS {
        advance(&mut run, step);
        let particles = &run.engine().particles;
        let ball = particles
            .records
            .iter()
            .find(|p| p.radius == RADIUS)
            .unwrap();
        heights.push(ball.position.z);
    }
    heights
}

fn drive(run: &mut Run, wall: usize, z: f64, velocity: f64) {
    let drive = WallDrive {
        place: DVec3::Z * z,
        turn: DQuat::IDENTITY,
        velocity: DVec3::Z * velocity,
        angular_velocity: DVec3::ZERO,
    };
    run.drive_wall(wall, drive).unwrap();
}

/// Heights at the ends of windows of `window` steps of a ball of this mass, by the velocity Verlet scheme with the load that it had last.
fn explicit(window: u64, mass: f64) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    let (mut run, _claim) = open(&outside(), folder.path());
    let wall = run.wall("ball").unwrap();
    let length = window as f64 * STEP;
    let (mut z, mut heights) = (HEIGHT, vec![HEIGHT]);
    let force = |run: &mut Run| run.wall_load(wall).unwrap()[0].force.z + mass * GRAVITY;
    // Velocity of the half step.
    let mut velocity = SPEED + 0.5 * length * (force(&mut run) / mass);
    for end in (window..=STEPS).step_by(window as usize) {
        z += length * velocity;
        drive(&mut run, wall, z, velocity);
        advance(&mut run, end);
        velocity += length * (force(&mut run) / mass);
        heights.push(z);
    }
    heights
}

/// Largest distance of both ways, m, and the whole way, m.
fn compared(reference: &[f64], heights: &[f64], window: u64) -> (f64, f64) {
    let at_ends = reference.iter().step_by(window as usize);
    let distances = at_ends.zip(heights).map(|(a, b)| (a - b).abs());
    let lowest = reference.iter().copied().fold(f64::INFINITY, f64::min);
    (distances.fold(0.0, f64::max), HEIGHT - lowest)
}

/// Windows of one step give the ball of the engine but for round-off: the same scheme with the same loads. Windows of H steps have an error of first order at
/// least.
#[test]
fn a_ball_outside_goes_as_one_inside() {
    let reference = reference();
    let errors: Vec<f64> = [1, 10, 20]
        .map(|window| {
            let (distance, way) = compared(&reference, &explicit(window, mass()), window);
            println!(
                "H = {window}: {distance:.3e} m of {way:.3e} m, {:.2e}",
                distance / way
            );
            distance / way
        })
        .to_vec();
    assert!(errors[0] <= 1e-14, "{errors:?}");
    assert!(errors[1] <= 0.005 && errors[2] <= 0.01, "{errors:?}");
    let order = libm::log2(errors[2] / errors[1]);
    println!("order {order:.3}");
    // The partner's own error is of second order, that of the beads, which see constant velocities within a window, of first.
    assert!(order >= 0.9, "{order}");
}

/// Momentum of the grains after each window: that of before, the weight, and what floor and ball gave, by their means. Both sides are sums of the same terms; 3 beads and 2,000 steps.
#[test]
fn mean_loads_carry_the_momentum() {
    let folder = tempfile::tempdir().unwrap();
    let (mut run, _claim) = open(&outside(), folder.path());
    let walls = ["ball", "floor"].map(|name| run.wall(name).unwrap());
    let (window, mut z) = (20, HEIGHT);
    let length = window as f64 * STEP;
    let (mut expected, mut scale) = (0.0, 0.0);
    for end in (window..=STEPS).step_by(window as usize) {
        z += length * 0.2 * SPEED;
        drive(&mut run, walls[0], z, 0.2 * SPEED);
        advance(&mut run, end);
        let mass: f64 = run.engine().particles.masses.iter().sum();
        expected += mass * GRAVITY * length;
        for wall in walls {
            let impulse = run.wall_load(wall).unwrap()[1].force.z * length;
            expected -= impulse;
            scale += impulse.abs();
        }
        let rows = run.particles().unwrap();
        let column = |name: &str| {
            let place = rows
                .specs
                .iter()
                .position(|spec| spec.name == name)
                .unwrap();
            rows.frame.columns[place].as_f64().unwrap().to_vec()
        };
        let momenta = column("mass").into_iter().zip(column("vz"));
        let momentum: f64 = momenta.map(|(mass, velocity)| mass * velocity).sum();
        let error = (momentum - expected).abs() / scale.max(1e-9);
        assert!(
            error <= 1e-12,
            "step {end}: {momentum} {expected}, {error:e}"
        );
    }
    assert!(scale > 1e-4, "{scale}");
}

/// A ball of a tenth of the mass and windows of 200 steps, longer than a contact of it lasts: with trials from one state, until the load that the partner assumed is that which it finds, the ball comes
/// to where windows of one step bring it.
#[test]
fn trials_from_one_state_couple_a_light_ball() {
    let (window, mass) = (200, 0.1 * mass());
    let fine = explicit(1, mass);
    let folder = tempfile::tempdir().unwrap();
    let (mut run, _claim) = open(&outside(), folder.path());
    let wall = run.wall("ball").unwrap();
    let length = window as f64 * STEP;
    let (mut z, mut velocity, mut force) = (HEIGHT, SPEED, 0.0);
    let (mut most, mut trials) = (0, 0);
    for end in (window..=STEPS).step_by(window as usize) {
        let before = run.save().unwrap();
        // Secant steps for the mean force (N) of the window: Aitken's relaxation in one dimension.
        let (mut last, mut assumed): (Option<(f64, f64)>, f64) = (None, force);
        let mut count = 0;
        loop {
            count += 1;
            let after = velocity + length * (assumed / mass + GRAVITY);
            let mean = 0.5 * (velocity + after);
            drive(&mut run, wall, z + length * mean, mean);
            advance(&mut run, end);
            let found = run.wall_load(wall).unwrap()[1].force.z;
            let residual = found - assumed;
            // A micrometre in a window.
            if residual.abs() * length * length / mass < 1e-6 || count == 20 {
                force = found;
                velocity = after;
                z += length * mean;
                break;
            }
            let next = match last {
                Some((x, r)) if residual != r => {
                    assumed - residual * (assumed - x) / (residual - r)
                }
                _ => assumed + 0.2 * residual,
            };
            last = Some((assumed, residual));
            assumed = next;
            run.restore(&before).unwrap();
        }
        trials += count;
        most = most.max(count);
    }
    let distance = (z - fine[STEPS as usize]).abs();
    println!("end {distance:.2e} m from that of H = 1; {trials} trials, at most {most} a window");
    assert!(most <= 8, "{most}");
    assert!(distance <= 1e-4, "{distance}");
}
