//! Check of a scene by the solver: `mercury-solve --check`, in a cage.

use std::fs::{self, File};
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use axum::http::StatusCode;
use cloud_api::answers::Checked;
use cloud_api::names::{BadName, check_input, check_name};
use cloud_api::problem::SceneProblem;
use cloud_api::requests::Scene;
use cloud_worker::confine::Cage;
use mercury_common::within::Outside;
use serde_json::Value;
use tempfile::tempfile_in;

use crate::access::ApiError;
use crate::earlier;
use crate::runs::blocking;
use crate::secrets;
use crate::state::App;

/// The largest scene, in bytes.
pub(crate) const LARGEST_SCENE: usize = 1 << 20;

/// The most further files of a scene.
const MOST_FILES: usize = 100;

/// The most `--set` of a scene.
const MOST_SETS: usize = 1000;

/// How long a check may take.
pub(crate) const PATIENCE: Duration = Duration::from_secs(10);

/// The most memory of a check, in bytes: the plan of a scene is small, its meshes and tables need not be.
pub(crate) const MEMORY: u64 = 4 << 30;

/// The largest answer of the solver, in bytes.
pub(crate) const LARGEST_ANSWER: u64 = 16 << 20;

/// The largest file that a check writes, in bytes.
const LARGEST_FILE: u64 = 256 << 20;

/// A folder that is removed with its contents.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        if let Err(error) = fs::remove_dir_all(&self.0) {
            eprintln!("{}: {error}", self.0.display());
        }
    }
}

fn name_is_bad(name: &str, why: BadName) -> ApiError {
    // What is sent back is shown; a long name need not be.
    let shown: String = name.chars().take(40).collect();
    ApiError::bad_request("invalid file name", format!("{shown:?}: {why}"))
}

/// Checks what can be checked without the solver. Returns the contents that the scene needs: name, SHA-256, length.
pub(crate) fn inspect(
    app: &App,
    owner: i64,
    scene: &Scene,
) -> Result<Vec<(String, String, u64)>, ApiError> {
    check_name(&scene.name).map_err(|why| name_is_bad(&scene.name, why))?;
    if scene.text.len() > LARGEST_SCENE {
        return Err(ApiError::new(
            StatusCode::PAYLOAD_TOO_LARGE,
            "the scene is too long",
            "A scene has at most 1 MB.",
        ));
    }
    if scene.files.len() > MOST_FILES || scene.set.len() > MOST_SETS {
        return Err(ApiError::bad_request(
            "too many files or settings",
            format!("A scene has at most {MOST_FILES} files and {MOST_SETS} settings."),
        ));
    }
    if let Some(set) = scene
        .set
        .iter()
        .find(|set| !set.contains('=') || set.len() > 1000 || set.contains('\0'))
    {
        let shown: String = set.chars().take(40).collect();
        return Err(ApiError::bad_request(
            "invalid setting",
            format!("{shown:?}: expected KEY = VALUE, for example time.end = 0.1"),
        ));
    }
    let mut files = Vec::new();
    for (name, sha256) in &scene.files {
        check_input(name).map_err(|why| name_is_bad(name, why))?;
        if *name == scene.name {
            return Err(ApiError::bad_request(
                "two files have one name",
                format!("{name} is the scene already"),
            ));
        }
        let Some(bytes) = app.db.input(sha256, owner)? else {
            return Err(ApiError::bad_request(
                "a file is missing",
                format!("The server does not have {name}. Add the file to the scene again."),
            ));
        };
        files.push((name.clone(), sha256.clone(), bytes));
    }
    Ok(files)
}

/// Writes a scene with its files into a folder of its own.
pub(crate) fn lay_out(app: &App, scene: &Scene, files: &[(String, String, u64)]) -> Result<Folder> {
    let folder = Folder(app.options.data.join("checks").join(secrets::random()?));
    fs::create_dir(&folder.0)?;
    fs::write(folder.0.join(&scene.name), &scene.text)?;
    for (name, sha256, _) in files {
        let path = folder.0.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        app.store
            .get_into(&format!("inputs/{sha256}"), &mut File::create_new(path)?)?;
    }
    Ok(folder)
}

/// Checks a scene by the solver.
pub(crate) async fn check(
    app: &Arc<App>,
    owner: i64,
    mut scene: Scene,
    trial: bool,
) -> Result<Checked, ApiError> {
    let _turn = app.checks.take((owner, false)).await?;
    let app = Arc::clone(app);
    blocking(move || {
        earlier::pin(&app, owner, &mut scene)?;
        let files = inspect(&app, owner, &scene)?;
        let folder = lay_out(&app, &scene, &files)?;
        let mut arguments = vec![
            scene.name.clone(),
            "--check".into(),
            "--json".into(),
            "--within".into(),
            ".".into(),
        ];
        arguments.extend(trial.then(|| "--trial=2s".to_owned()));
        arguments.extend(scene.set.iter().map(|set| format!("--set={set}")));
        let said = solve(&app, &folder, &arguments, PATIENCE)?;
        Ok(said.checked())
    })
    .await
}

/// How long a preview may take.
const PREVIEW: Duration = Duration::from_secs(20);

/// The most particles that a preview is made of.
const MOST_PREVIEWED: f64 = 300_000.0;

/// Walls and first particles: frame 0 of a run of one step.
pub(crate) async fn preview(
    app: &Arc<App>,
    owner: i64,
    mut scene: Scene,
) -> Result<Vec<u8>, ApiError> {
    let nothing = |why: &str| ApiError::new(StatusCode::UNPROCESSABLE_ENTITY, "no preview", why);
    let checked = check(app, owner, scene.clone(), false).await?;
    if checked.unchecked.is_some() {
        return Err(nothing("The scene is too large for a check."));
    }
    let plan = match checked.plan {
        Some(plan) if checked.problems.is_empty() => plan,
        _ => return Err(ApiError::unrunnable(checked.problems)),
    };
    let step = plan["time"]["step"]
        .as_f64()
        .ok_or_else(|| nothing("The plan has no time step."))?;
    if plan["particles"]["at_start"].as_f64().unwrap_or(0.0) > MOST_PREVIEWED {
        return Err(nothing(
            "The scene begins with too many particles for a preview.",
        ));
    }
    let _turn = app.checks.take((owner, false)).await?;
    let app = Arc::clone(app);
    blocking(move || {
        earlier::pin(&app, owner, &mut scene)?;
        let files = inspect(&app, owner, &scene)?;
        let folder = lay_out(&app, &scene, &files)?;
        let mut arguments: Vec<String> = [
            scene.name.as_str(),
            "--quiet",
            "--within",
            ".",
            "--output",
            ".run",
            "--threads",
            "1",
        ]
        .map(str::to_owned)
        .into();
        arguments.extend(scene.set.iter().map(|set| format!("--set={set}")));
        arguments.push(format!("--set=time.end={step}"));
        arguments.push("--set=output.pictures=false".to_owned());
        let said = solve(&app, &folder, &arguments, PREVIEW)?;
        if said.code != Some(0) {
            return Err(nothing("The first step could not be made."));
        }
        view(&app, &folder.0.join(".run"), None)?
            .ok_or_else(|| nothing("The solver wrote no frame."))
    })
    .await
}

/// How long a view may take.
const VIEW: Duration = Duration::from_secs(20);

/// The largest view, in bytes: 200,000 triangles and 300,000 particles.
const LARGEST_VIEW: u64 = 64 << 20;

/// Walls of a frame of the run in `folder`, or without `frame` all of a preview, as JSON: made by this program, in a cage with the limits
/// of a check. The meshes are those of users, and may be large.
pub(crate) fn view(app: &App, folder: &Path, frame: Option<usize>) -> Result<Option<Vec<u8>>> {
    let program = Path::new("/proc/self/exe");
    let mut arguments = vec!["view".to_owned()];
    arguments.extend(frame.map(|frame| format!("--frame={frame}")));
    let said = confined(
        app,
        program,
        folder,
        &arguments,
        VIEW,
        LARGEST_VIEW,
        LARGEST_FILE,
    )?;
    match said.code {
        Some(0) if said.answer.is_empty() => Ok(None),
        Some(0) => Ok(Some(said.answer.into_bytes())),
        code => {
            let why = said.messages.trim();
            eprintln!("{}: no view (exit code {code:?}): {why}", folder.display());
            Ok(None)
        }
    }
}

/// Says in words of the scene what the solver says in words of its command line.
fn in_words_of_the_scene(problem: &mut SceneProblem) {
    for outside in [Outside::Name, Outside::Link] {
        if let Some(name) = problem.message.strip_suffix(&outside.to_string()) {
            problem.message = format!("{name}is no file of this scene");
            problem.help = Some("add the file to the scene, and name it without folders".into());
        }
    }
    if problem.message.starts_with("the file does not exist") {
        problem.help = Some("add the file to the scene".into());
    }
}

/// Answer of the solver.
pub(crate) struct SolverAnswer {
    pub(crate) code: Option<i32>,
    pub(crate) answer: String,
    pub(crate) messages: String,
}

impl SolverAnswer {
    /// The answer, and the problems that it names.
    pub(crate) fn parts(&self) -> (Option<Value>, Vec<SceneProblem>) {
        let one = |message: &str| {
            let problem = SceneProblem {
                message: message.to_owned(),
                ..SceneProblem::default()
            };
            (None, vec![problem])
        };
        if self.code.is_none() {
            return one(
                "the study is too large for a check: it needs more than 30 s or 4 GB of memory. Submit its runs one by one; a single run needs no check",
            );
        }
        let Ok(mut answer) = serde_json::from_str::<Value>(&self.answer) else {
            let message = self.messages.trim();
            return one(if message.is_empty() {
                "the solver gave no answer"
            } else {
                message
            });
        };
        let problems = answer
            .as_object_mut()
            .and_then(|object| object.remove("problems"));
        let mut problems: Vec<SceneProblem> = problems
            .and_then(|problems| serde_json::from_value(problems).ok())
            .unwrap_or_default();
        problems.iter_mut().for_each(in_words_of_the_scene);
        if problems.is_empty() && self.code != Some(0) {
            return one(self.messages.trim());
        }
        (Some(answer), problems)
    }

    fn checked(&self) -> Checked {
        if self.code.is_none() {
            let why = format!(
                "The check needs more than {} s or {} GB of memory. Memory, disk and time of the run are not known, and it runs where all memory for runs is free. \
                 If its scene has a problem, the run fails at its start and says so.",
                PATIENCE.as_secs(),
                MEMORY >> 30
            );
            return Checked {
                unchecked: Some(why),
                ..Checked::default()
            };
        }
        let (answer, problems) = self.parts();
        // A plan that does not fit has problems besides.
        let plan = answer.filter(|answer| answer.get("time").is_some());
        Checked {
            problems,
            plan,
            unchecked: None,
        }
    }
}

/// Runs the solver in a cage around `folder`, for so long at most.
pub(crate) fn solve(
    app: &App,
    folder: &Folder,
    arguments: &[String],
    patience: Duration,
) -> Result<SolverAnswer> {
    let solver = &app.options.solver;
    confined(
        app,
        solver,
        &folder.0,
        arguments,
        patience,
        LARGEST_ANSWER,
        LARGEST_FILE,
    )
}

/// Runs a program in a cage around `folder`, for so long at most, with an answer and files of so many bytes at most.
pub(crate) fn confined(
    app: &App,
    program: &Path,
    folder: &Path,
    arguments: &[String],
    patience: Duration,
    largest: u64,
    file: u64,
) -> Result<SolverAnswer> {
    let cage = Cage {
        folder: folder.to_owned(),
        sandbox: app.options.sandbox,
        memory: MEMORY,
        file,
        cpu: patience.as_secs() * 2,
        mpi: None,
    };
    let checks = app.options.data.join("checks");
    let (answer, messages) = (tempfile_in(&checks)?, tempfile_in(&checks)?);
    let child = cage
        .command(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(answer.try_clone()?)
        .stderr(messages.try_clone()?)
        .spawn()
        .with_context(|| format!("{} cannot be started", program.display()))?;
    let code = wait(child, patience)?;
    let read = |mut file: File| -> Result<String> {
        let mut bytes = Vec::new();
        file.rewind()?;
        file.take(largest).read_to_end(&mut bytes)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    };
    Ok(SolverAnswer {
        code,
        answer: read(answer)?,
        messages: read(messages)?,
    })
}

/// The exit code, or `None` if it had to be killed or was.
fn wait(mut child: Child, patience: Duration) -> Result<Option<i32>> {
    let begin = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status.code());
        }
        if begin.elapsed() > patience {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(code: Option<i32>, answer: &str) -> SolverAnswer {
        SolverAnswer {
            code,
            answer: answer.to_owned(),
            messages: String::new(),
        }
    }

    #[test]
    fn problems_are_in_words_of_the_scene() {
        for outside in [Outside::Name, Outside::Link] {
            let said = format!(
                r#"{{"problems": [{{"key": "particles[0].file", "message": "\"../p.csv\" {outside}"}}]}}"#
            );
            let checked = answer(Some(2), &said).checked();
            let [problem] = &checked.problems[..] else {
                panic!("{checked:?}")
            };
            assert_eq!(problem.message, "\"../p.csv\" is no file of this scene");
            assert!(problem.help.as_ref().unwrap().contains("without folders"));
        }
        let said = r#"{"problems": [{"message": "the file does not exist: a.stl", "set": "walls.a.file=a.stl"}]}"#;
        let checked = answer(Some(2), said).checked();
        assert_eq!(
            checked.problems[0].help.as_deref(),
            Some("add the file to the scene")
        );
        assert_eq!(
            checked.problems[0].set.as_deref(),
            Some("walls.a.file=a.stl")
        );
    }

    #[test]
    fn a_check_that_was_given_up_says_so_and_has_no_problem() {
        let checked = answer(None, "").checked();
        assert!(checked.problems.is_empty() && checked.plan.is_none());
        assert!(checked.unchecked.unwrap().contains("10 s"));
        // A study needs its runs from the check.
        assert!(answer(None, "").parts().1[0].message.contains("one by one"));
    }
}
