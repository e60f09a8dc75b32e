//! Threads that do not come to the step.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Duration;

use mercury_common::scene::Files;

use mercury_engine::step::Engine;
use mercury_solver::plan::{parse_scene, plan};

/// Time for which an absent thread stays away while another one waits for it.
const AWAY: Duration = Duration::from_secs(20);

/// One of two threads has other things to do, as on a machine on which others take its core: the steps, lists among them, are made without it, and
/// come out as those of one thread.
#[test]
fn no_step_waits_for_a_thread_that_is_not_there() {
    // 2,744 spheres in a lattice of contacts, with some speed along the diagonal, so that lists are built.
    let text = r#"
        time = { end = 1.0, step = 1e-5 }
        domain = { min = [0, 0, 0], max = [0.28, 0.28, 0.28], periodic = ["x", "y", "z"] }
        [materials.glass]
        density = 2500.0
        normal = { law = "linear", stiffness = 2000.0, restitution = 0.5 }
        tangential = { law = "linear", stiffness_ratio = 0.3, friction = 0.5 }
        [[particles]]
        material = "glass"
        radius = 0.01004
        lattice = { min = [0.0, 0.0, 0.0], max = [0.27, 0.27, 0.27], spacing = 0.02 }
        velocity = [3.0, 2.0, 1.0]
        [output]
        interval = 1.0
    "#;
    let scene = parse_scene(Path::new("absent.toml"), text, &[], Files::Unchecked).unwrap();
    let plan = Arc::new(plan(&scene).unwrap());
    let mut alone = Engine::new(Arc::clone(&plan), 1).unwrap();
    let mut engine = Engine::new(plan, 2).unwrap();
    let (take, taken) = channel();
    let (release, released) = channel();
    let (answer, answered) = channel();
    engine.pool().unwrap().spawn(move || {
        take.send(()).unwrap();
        answer.send(released.recv_timeout(AWAY).is_ok()).unwrap();
    });
    taken.recv().unwrap();
    engine.steps_at_once(60, None).unwrap();
    release.send(()).unwrap();
    assert!(
        answered.recv().unwrap(),
        "the steps waited for a thread that had other things to do"
    );
    alone.steps_at_once(60, None).unwrap();
    assert!(alone.list_statistics().0 > 2, "lists were built");
    assert!(alone.snapshot() == engine.snapshot());
}
