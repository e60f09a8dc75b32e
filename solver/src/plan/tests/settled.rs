//! The last event that a scene schedules.

use super::{BALL, HEAD, planned_with};

#[test]
fn the_last_event_is_that_of_walls_and_insertions() {
    let fill = |keys: &str| {
        format!(
            "[[insertions]]\nname = \"fill\"\nmaterial = \"ball\"\nregion = {{ shape = \"box\", min = [-1, -1, -1], max = [1, 1, 1] }}\npsd = {{ kind = \"monodisperse\", diameter = 0.1 }}\n{keys}\n"
        )
    };
    let plane = |keys: &str| {
        format!(
            "[[walls]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\nmaterial = \"ball\"\n{keys}\n"
        )
    };
    let lid = plane(
        "motion = [{ kind = \"translation\", velocity = [0, 0, 0.1], from = 0.2, until = 0.7 }]",
    );
    let drum = plane(
        "motion = [{ kind = \"rotation\", axis = [0, 0, 1], origin = [0, 0, 0], angular_velocity = 3.0 }]",
    );
    for (body, time, event) in [
        (String::new(), 0.0, "the start"),
        (drum, 0.0, "the start"),
        (plane("until = 0.4"), 0.4, "wall `floor`"),
        (lid.clone(), 0.7, "wall `floor`"),
        // 30 at 60 a second, from 0.1 s on; a flow without a total goes on.
        (
            fill("from = 0.1\nrate = { number = 60.0 }\ntotal = { number = 30 }"),
            0.6,
            "insertion `fill`",
        ),
        (
            fill("from = 0.1\nrate = { number = 60.0 }\nuntil = 0.3\ntotal = { number = 30 }"),
            0.3,
            "insertion `fill`",
        ),
        (
            fill("from = 0.1\nrate = { number = 60.0 }"),
            0.1,
            "insertion `fill`",
        ),
        (
            fill("from = 0.1\nrate = { number = 60.0 }\nuntil = 0.9"),
            0.9,
            "insertion `fill`",
        ),
        (fill("total = { number = 30 }") + &lid, 0.7, "wall `floor`"),
    ] {
        let text = format!("{HEAD}{BALL}{body}");
        let plan =
            planned_with(&text, &["time.step=1e-5"]).unwrap_or_else(|errors| panic!("{errors}"));
        let settled = plan.settled();
        // Round-off of a few operations on numbers below 1.
        assert!((settled.time - time).abs() < 1e-12, "{body}: {settled:?}");
        assert!(settled.event.contains(event), "{body}: {settled:?}");
    }
}
