//! Mercury from C: `mercury.h`.
//!
//! A run is opened by the path or the text of a scene and made in pieces. Between two of them the calling program reads loads on walls and columns of particles, and
//! drives walls whose scene says `motion = "external"`. No panic crosses the border; errors are texts. One thread at a time may use a run.
//!
//! The header is made from this file by cbindgen and checked in; a test compares them.

use std::ffi::{CStr, CString, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use mercury_common::frames::Column;
use mercury_solver::output::folder::Earlier;
use mercury_solver::plan::refusal;
use mercury_solver::run::{Advance, Claim, OpenError, OpenRun, Run, Saved, SceneInput, WallDrive};

/// `mercury_advance`: the time is reached, and the run can go on.
pub const MERCURY_REACHED: c_int = 0;
/// `mercury_advance`: the run has come to its end; only `mercury_finish` is left.
pub const MERCURY_ENDED: c_int = 1;
/// A call failed; `mercury_error` returns the text.
pub const MERCURY_FAILED: c_int = -1;

/// A run.
#[allow(non_camel_case_types)]
pub struct mercury_t {
    /// None once it is finished or failed.
    open: Option<(Run, Claim)>,
    /// Time and step of the end.
    moment: (f64, u64),
    time_step: f64,
    error: CString,
    /// The columns that were requested last.
    columns: Vec<(CString, Vec<f64>)>,
}

/// State of a run in memory.
#[allow(non_camel_case_types)]
pub struct mercury_state_t {
    saved: Saved,
}

/// A text without a zero byte inside.
fn c_text(text: &str) -> CString {
    let bytes: Vec<u8> = text.bytes().filter(|&byte| byte != 0).collect();
    CString::new(bytes).unwrap_or_default()
}

/// Runs `work`; a panic, which is a defect of Mercury, becomes an error.
fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        let text = text.unwrap_or("a panic without a text");
        Err(format!(
            "defect of Mercury, please report it with the scene: {text}"
        ))
    })
}

impl mercury_t {
    /// Calls the run; its error is kept for `mercury_error`.
    fn call<T>(&mut self, work: impl FnOnce(&mut Run) -> Result<T, String>) -> Option<T> {
        let Some((run, _)) = &mut self.open else {
            self.error = c_text("the run is finished, or failed before");
            return None;
        };
        let done = guarded(|| work(run));
        if let Some((run, _)) = &self.open {
            self.moment = (run.engine().time(), run.engine().steps());
        }
        self.columns.clear();
        done.map_err(|text| self.error = c_text(&text)).ok()
    }
}

/// A text of C.
///
/// # Safety
/// `text` is null or points to a text that ends with zero.
unsafe fn text_of<'a>(text: *const c_char, what: &str) -> Result<&'a str, String> {
    if text.is_null() {
        return Err(format!("{what} is a null pointer"));
    }
    // SAFETY: not null, and the caller promises the zero at its end.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| format!("{what} is not UTF-8"))
}

/// `N` numbers of C.
///
/// # Safety
/// `numbers` is null or points to `N` numbers.
unsafe fn numbers_of<const N: usize>(numbers: *const f64, what: &str) -> Result<[f64; N], String> {
    if numbers.is_null() {
        return Err(format!("{what} is a null pointer"));
    }
    // SAFETY: not null, and the caller promises N numbers.
    Ok(unsafe { *numbers.cast::<[f64; N]>() })
}

fn refused(error: &OpenError) -> String {
    match error {
        OpenError::Scene(errors) => refusal(errors),
        other => other.to_string(),
    }
}

/// A scene by its path, or by its text if it has several lines or begins with a brace.
fn scene(scene: &str) -> Result<SceneInput, String> {
    if !scene.contains('\n') && !scene.trim_start().starts_with('{') {
        return SceneInput::read(Path::new(scene)).map_err(|errors| refusal(&errors));
    }
    Ok(SceneInput {
        path: PathBuf::from("scene"),
        text: scene.to_owned(),
        set: Vec::new(),
    })
}

fn open(scene_or_path: &str, output: Option<&str>, set: Vec<String>) -> Result<mercury_t, String> {
    let mut input = scene(scene_or_path)?;
    input.set = set;
    let prefix = mercury_common::scene::stem(&input.path);
    let folder = output.map_or_else(|| PathBuf::from(prefix), PathBuf::from);
    let opening = OpenRun {
        input,
        folder,
        earlier: Earlier::Refuse,
        results: Vec::new(),
        threads: None,
        checkpoint_every: None,
        called: "mercury_open".to_owned(),
        pause: Arc::default(),
        pieces_observed: false,
    };
    let (run, claim) = opening.begin().map_err(|error| refused(&error))?;
    Ok(mercury_t {
        moment: (run.engine().time(), run.engine().steps()),
        time_step: run.plan().physics().time_step,
        open: Some((run, claim)),
        error: CString::default(),
        columns: Vec::new(),
    })
}

/// Copies a text with its end, cut where it is too long.
///
/// # Safety
/// `to` is null or has room for `n` bytes.
unsafe fn copy_text(text: &str, to: *mut c_char, n: usize) {
    if to.is_null() || n == 0 {
        return;
    }
    let text = c_text(text);
    let bytes = text.as_bytes();
    let count = bytes.len().min(n - 1);
    // SAFETY: at most n bytes, which are there.
    unsafe {
        ptr::copy_nonoverlapping(bytes.as_ptr().cast(), to, count);
        *to.add(count) = 0;
    }
}

/// Opens a scene, checks it and begins its run.
///
/// `scene`: path of a file, or the text of a scene (TOML or JSON), which has several lines or begins with a brace. `output`: folder of the files of the run, which holds no run
/// yet; NULL: one of the name of the scene. `set`: NULL, or texts KEY=VALUE with NULL behind the last. Returns NULL on an error, whose text is copied to `error`, which
/// has room for `n` bytes, or is NULL.
///
/// # Safety
/// Texts end with zero, `set` with a null pointer, and `error` has room for `n` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_open(
    scene: *const c_char,
    output: *const c_char,
    set: *const *const c_char,
    error: *mut c_char,
    n: usize,
) -> *mut mercury_t {
    let opened = guarded(|| {
        // SAFETY: promised by the caller.
        let scene = unsafe { text_of(scene, "scene") }?;
        let output = match output.is_null() {
            true => None,
            // SAFETY: promised by the caller.
            false => Some(unsafe { text_of(output, "output") }?),
        };
        let mut changes = Vec::new();
        if !set.is_null() {
            for place in 0.. {
                // SAFETY: a null pointer ends the list, and nothing behind it is read.
                let change = unsafe { *set.add(place) };
                if change.is_null() {
                    break;
                }
                // SAFETY: promised by the caller.
                changes.push(unsafe { text_of(change, "set") }?.to_owned());
            }
        }
        open(scene, output, changes)
    });
    match opened {
        Ok(run) => Box::into_raw(Box::new(run)),
        Err(text) => {
            // SAFETY: promised by the caller.
            unsafe { copy_text(&text, error, n) };
            ptr::null_mut()
        }
    }
}

/// Text of the last error of a run; it stays until the next call.
///
/// # Safety
/// `run` is from `mercury_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_error(run: *const mercury_t) -> *const c_char {
    // SAFETY: promised by the caller.
    match unsafe { run.as_ref() } {
        Some(run) => run.error.as_ptr(),
        None => c"the run is a null pointer".as_ptr(),
    }
}

/// Goes on to the first step at or after `until` (s), or to the end. Returns MERCURY_REACHED, MERCURY_ENDED or MERCURY_FAILED.
///
/// # Safety
/// `run` is from `mercury_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_advance(run: *mut mercury_t, until: f64) -> c_int {
    // SAFETY: promised by the caller.
    let Some(handle) = (unsafe { run.as_mut() }) else {
        return MERCURY_FAILED;
    };
    let advanced = handle.call(|run| {
        if until.is_nan() {
            return Err("the time is not a number".to_owned());
        }
        let advanced = run.advance(until, &mut |_| ());
        advanced.map_err(|failure| format!("the run failed: {failure}"))
    });
    match advanced {
        Some(Advance::Reached | Advance::Paused) => MERCURY_REACHED,
        Some(Advance::Ended) => MERCURY_ENDED,
        None => MERCURY_FAILED,
    }
}

/// Writes the files of the end; the run can only be closed then. A run that has not come to its end makes one more step and counts as stopped.
///
/// # Safety
/// `run` is from `mercury_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_finish(run: *mut mercury_t) -> c_int {
    // SAFETY: promised by the caller.
    let Some(handle) = (unsafe { run.as_mut() }) else {
        return MERCURY_FAILED;
    };
    let Some((run, _claim)) = handle.open.take() else {
        handle.error = c_text("the run is finished, or failed before");
        return MERCURY_FAILED;
    };
    let finished = guarded(|| {
        let report = run.finish();
        report.map_err(|failure| format!("the run failed: {failure}"))
    });
    match finished {
        Ok(report) => {
            handle.moment = (report.summary.time, report.summary.steps);
            MERCURY_REACHED
        }
        Err(text) => {
            handle.error = c_text(&text);
            MERCURY_FAILED
        }
    }
}

/// Frees a run, which need not be finished. NULL is left alone.
///
/// # Safety
/// `run` is from `mercury_open`, and is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_close(run: *mut mercury_t) {
    if !run.is_null() {
        // SAFETY: promised by the caller.
        let run = unsafe { Box::from_raw(run) };
        let _ = guarded(|| {
            drop(run);
            Ok(())
        });
    }
}

/// Present time, s; -1 for NULL.
///
/// # Safety
/// `run` is from `mercury_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_time(run: *const mercury_t) -> f64 {
    // SAFETY: promised by the caller.
    unsafe { run.as_ref() }.map_or(-1.0, |run| run.moment.0)
}

/// Time step, s; -1 for NULL.
///
/// # Safety
/// `run` is from `mercury_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_step(run: *const mercury_t) -> f64 {
    // SAFETY: promised by the caller.
    unsafe { run.as_ref() }.map_or(-1.0, |run| run.time_step)
}

/// Number of a wall by its name, or MERCURY_FAILED.
///
/// # Safety
/// `run` is from `mercury_open` and not closed, and `name` ends with zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_wall(run: *mut mercury_t, name: *const c_char) -> c_int {
    // SAFETY: promised by the caller.
    let Some(handle) = (unsafe { run.as_mut() }) else {
        return MERCURY_FAILED;
    };
    let found = handle.call(|run| {
        // SAFETY: promised by the caller.
        let name = unsafe { text_of(name, "name") }?;
        let walls = &run.plan().physics().walls;
        let known: Vec<&str> = walls.iter().map(|wall| wall.name.as_str()).collect();
        run.wall(name)
            .ok_or_else(|| format!("no wall `{name}`; there are: {}", known.join(", ")))
    });
    found.map_or(MERCURY_FAILED, |wall| wall as c_int)
}

/// Drives a wall with `motion = "external"` in the next window, that of the next `mercury_advance`: it goes on with `velocity` (m/s of its reference point, then rad/s) and stands at the end
/// where `pose` says (m, the place of its reference point, then its turn since the start as a quaternion w, x, y, z). A wall that is not driven rests.
///
/// # Safety
/// `run` is from `mercury_open` and not closed; `pose` has 7 numbers and `velocity` 6.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_wall_drive(
    run: *mut mercury_t,
    wall: c_int,
    pose: *const f64,
    velocity: *const f64,
) -> c_int {
    // SAFETY: promised by the caller.
    let Some(handle) = (unsafe { run.as_mut() }) else {
        return MERCURY_FAILED;
    };
    let driven = handle.call(|run| {
        // SAFETY: promised by the caller.
        let [x, y, z, qw, qx, qy, qz] = unsafe { numbers_of::<7>(pose, "pose") }?;
        // SAFETY: promised by the caller.
        let [vx, vy, vz, wx, wy, wz] = unsafe { numbers_of::<6>(velocity, "velocity") }?;
        let drive = WallDrive {
            place: DVec3::new(x, y, z),
            turn: DQuat::from_xyzw(qx, qy, qz, qw),
            velocity: DVec3::new(vx, vy, vz),
            angular_velocity: DVec3::new(wx, wy, wz),
        };
        let driven = run.drive_wall(wall_number(wall)?, drive);
        driven.map_err(|failure| failure.to_string())
    });
    driven.map_or(MERCURY_FAILED, |()| MERCURY_REACHED)
}

fn wall_number(wall: c_int) -> Result<usize, String> {
    usize::try_from(wall).map_err(|_| format!("no wall {wall}: numbers are those of mercury_wall"))
}

/// Load of the particles on a wall: force (N), then torque about its reference point (N m). `load`: in the last step; `mean`: over the last window, so that mean times the length of the window is the
/// momentum that the particles gave up. Either may be NULL.
///
/// # Safety
/// `run` is from `mercury_open` and not closed; `load` and `mean` are null or have room for 6 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_wall_load(
    run: *mut mercury_t,
    wall: c_int,
    load: *mut f64,
    mean: *mut f64,
) -> c_int {
    // SAFETY: promised by the caller.
    let Some(handle) = (unsafe { run.as_mut() }) else {
        return MERCURY_FAILED;
    };
    let loads = handle.call(|run| {
        let loads = run.wall_load(wall_number(wall)?);
        loads.map_err(|error| error.to_string())
    });
    let Some(loads) = loads else {
        return MERCURY_FAILED;
    };
    for (to, from) in [load, mean].into_iter().zip(loads) {
        let (f, t) = (from.force, from.torque);
        if !to.is_null() {
            // SAFETY: promised by the caller.
            unsafe { *to.cast::<[f64; 6]>() = [f.x, f.y, f.z, t.x, t.y, t.z] };
        }
    }
    MERCURY_REACHED
}

/// Where a wall stands: the place of its reference point (m), then its turn since the start as a quaternion w, x, y, z.
///
/// # Safety
/// `run` is from `mercury_open` and not closed; `pose` has room for 7 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_wall_pose(
    run: *mut mercury_t,
    wall: c_int,
    pose: *mut f64,
) -> c_int {
    // SAFETY: promised by the caller.
    let Some(handle) = (unsafe { run.as_mut() }) else {
        return MERCURY_FAILED;
    };
    let found = handle.call(|run| {
        if pose.is_null() {
            return Err("pose is a null pointer".to_owned());
        }
        let found = run.wall_pose(wall_number(wall)?);
        found.map_err(|error| error.to_string())
    });
    let Some((x, q)) = found else {
        return MERCURY_FAILED;
    };
    // SAFETY: not null, and the caller promises the room.
    unsafe { *pose.cast::<[f64; 7]>() = [x.x, x.y, x.z, q.w, q.x, q.y, q.z] };
    MERCURY_REACHED
}

/// A column of numbers of all particles by their ids, with the name that it has in `.particles.arrow`: x, vx, radius, id and so on. `values` points to `count` numbers, which stay until the run goes on,
/// goes back or is closed, or a wall is driven or read.
///
/// # Safety
/// `run` is from `mercury_open` and not closed; `column` ends with zero; `values` and `count` point to room for one each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_grains(
    run: *mut mercury_t,
    column: *const c_char,
    values: *mut *const f64,
    count: *mut usize,
) -> c_int {
    // SAFETY: promised by the caller.
    let Some(handle) = (unsafe { run.as_mut() }) else {
        return MERCURY_FAILED;
    };
    // SAFETY: promised by the caller.
    let name = unsafe { text_of(column, "column") };
    let is_there = |name: &str| {
        let mut columns = handle.columns.iter();
        columns.position(|(known, _)| known.to_str() == Ok(name))
    };
    let place = match name {
        Ok(name) if is_there(name).is_some() => is_there(name),
        name => {
            let mut before = std::mem::take(&mut handle.columns);
            let read = handle.call(|run| {
                if values.is_null() || count.is_null() {
                    return Err("values or count is a null pointer".to_owned());
                }
                let name = name?;
                let rows = run.particles().map_err(|failure| failure.to_string())?;
                let names: Vec<&str> = rows.specs.iter().map(|spec| spec.name.as_str()).collect();
                let place = names.iter().position(|known| *known == name);
                let column = place.and_then(|place| numbers(&rows.frame.columns[place]));
                let column = column.ok_or_else(|| {
                    format!(
                        "no column `{name}` of numbers; there are: {}",
                        names.join(", ")
                    )
                })?;
                Ok((c_text(name), column))
            });
            // Columns of the same step stay, as the caller may hold them.
            let is_read = read.is_some();
            before.extend(read);
            handle.columns = before;
            is_read.then(|| handle.columns.len() - 1)
        }
    };
    let Some((_, column)) = place.and_then(|place| handle.columns.get(place)) else {
        return MERCURY_FAILED;
    };
    // SAFETY: not null, and the caller promises the room.
    unsafe {
        *values = column.as_ptr();
        *count = column.len();
    }
    MERCURY_REACHED
}

/// A column as numbers, if it has only such.
fn numbers(column: &Column) -> Option<Vec<f64>> {
    Some(match column {
        Column::F64(values) => values.clone(),
        Column::I32(values) => values.iter().map(|&value| f64::from(value)).collect(),
        Column::U8(values) => values.iter().map(|&value| f64::from(value)).collect(),
        Column::U32(values) => values.iter().map(|&value| f64::from(value)).collect(),
        Column::U64(values) => values.iter().map(|&value| value as f64).collect(),
        Column::OptionalU32(_) | Column::Text(_) => return None,
    })
}

/// The present state, to go back to; NULL on an error. `mercury_state_free` frees it.
///
/// # Safety
/// `run` is from `mercury_open` and not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_save(run: *mut mercury_t) -> *mut mercury_state_t {
    // SAFETY: promised by the caller.
    let Some(handle) = (unsafe { run.as_mut() }) else {
        return ptr::null_mut();
    };
    let saved = handle.call(|run| run.save().map_err(|failure| failure.to_string()));
    saved.map_or(ptr::null_mut(), |saved| {
        Box::into_raw(Box::new(mercury_state_t { saved }))
    })
}

/// Goes back to a saved state of this run. Its files are cut back, and all comes out as if the steps behind that state had never been made.
///
/// # Safety
/// `run` is from `mercury_open` and not closed; `state` is from `mercury_save` and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_restore(
    run: *mut mercury_t,
    state: *const mercury_state_t,
) -> c_int {
    // SAFETY: promised by the caller.
    let (Some(handle), state) = (unsafe { (run.as_mut(), state.as_ref()) }) else {
        return MERCURY_FAILED;
    };
    let restored = handle.call(|run| {
        let state = state.ok_or("state is a null pointer")?;
        let restored = run.restore(&state.saved);
        restored.map_err(|failure| failure.to_string())
    });
    restored.map_or(MERCURY_FAILED, |()| MERCURY_REACHED)
}

/// Frees a saved state. NULL is left alone.
///
/// # Safety
/// `state` is from `mercury_save`, and is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mercury_state_free(state: *mut mercury_state_t) {
    if !state.is_null() {
        // SAFETY: promised by the caller.
        drop(unsafe { Box::from_raw(state) });
    }
}
