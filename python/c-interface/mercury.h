/* Mercury from C: a run that another program makes in pieces. Made by cbindgen from python/c-interface/src/lib.rs.
 *
 * All quantities are in SI units. One thread at a time may use a run. Functions return MERCURY_FAILED (or NULL) on an error, and mercury_error its text. */

#ifndef MERCURY_H
#define MERCURY_H

#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

// `mercury_advance`: the time is reached, and the run can go on.
#define MERCURY_REACHED 0

// `mercury_advance`: the run has come to its end; only `mercury_finish` is left.
#define MERCURY_ENDED 1

// A call failed; `mercury_error` returns the text.
#define MERCURY_FAILED -1

// State of a run in memory.
typedef struct mercury_state_t mercury_state_t;

// A run.
typedef struct mercury_t mercury_t;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Opens a scene, checks it and begins its run.
//
// `scene`: path of a file, or the text of a scene (TOML or JSON), which has several lines or begins with a brace. `output`: folder of the files of the run, which holds no run
// yet; NULL: one of the name of the scene. `set`: NULL, or texts KEY=VALUE with NULL behind the last. Returns NULL on an error, whose text is copied to `error`, which
// has room for `n` bytes, or is NULL.
//
// # Safety
// Texts end with zero, `set` with a null pointer, and `error` has room for `n` bytes.
struct mercury_t *mercury_open(const char *scene,
                               const char *output,
                               const char *const *set,
                               char *error,
                               uintptr_t n);

// Text of the last error of a run; it stays until the next call.
//
// # Safety
// `run` is from `mercury_open` and not closed.
const char *mercury_error(const struct mercury_t *run);

// Goes on to the first step at or after `until` (s), or to the end. Returns MERCURY_REACHED, MERCURY_ENDED or MERCURY_FAILED.
//
// # Safety
// `run` is from `mercury_open` and not closed.
int mercury_advance(struct mercury_t *run,
                    double until);

// Writes the files of the end; the run can only be closed then. A run that has not come to its end makes one more step and counts as stopped.
//
// # Safety
// `run` is from `mercury_open` and not closed.
int mercury_finish(struct mercury_t *run);

// Frees a run, which need not be finished. NULL is left alone.
//
// # Safety
// `run` is from `mercury_open`, and is not used again.
void mercury_close(struct mercury_t *run);

// Present time, s; -1 for NULL.
//
// # Safety
// `run` is from `mercury_open` and not closed.
double mercury_time(const struct mercury_t *run);

// Time step, s; -1 for NULL.
//
// # Safety
// `run` is from `mercury_open` and not closed.
double mercury_step(const struct mercury_t *run);

// Number of a wall by its name, or MERCURY_FAILED.
//
// # Safety
// `run` is from `mercury_open` and not closed, and `name` ends with zero.
int mercury_wall(struct mercury_t *run, const char *name);

// Drives a wall with `motion = "external"` in the next window, that of the next `mercury_advance`: it goes on with `velocity` (m/s of its reference point, then rad/s) and stands at the end
// where `pose` says (m, the place of its reference point, then its turn since the start as a quaternion w, x, y, z). A wall that is not driven rests.
//
// # Safety
// `run` is from `mercury_open` and not closed; `pose` has 7 numbers and `velocity` 6.
int mercury_wall_drive(struct mercury_t *run,
                       int wall,
                       const double *pose,
                       const double *velocity);

// Load of the particles on a wall: force (N), then torque about its reference point (N m). `load`: in the last step; `mean`: over the last window, so that mean times the length of the window is the
// momentum that the particles gave up. Either may be NULL.
//
// # Safety
// `run` is from `mercury_open` and not closed; `load` and `mean` are null or have room for 6 numbers.
int mercury_wall_load(struct mercury_t *run,
                      int wall,
                      double *load,
                      double *mean);

// Where a wall stands: the place of its reference point (m), then its turn since the start as a quaternion w, x, y, z.
//
// # Safety
// `run` is from `mercury_open` and not closed; `pose` has room for 7 numbers.
int mercury_wall_pose(struct mercury_t *run, int wall, double *pose);

// A column of numbers of all particles by their ids, with the name that it has in `.particles.arrow`: x, vx, radius, id and so on. `values` points to `count` numbers, which stay until the run goes on,
// goes back or is closed, or a wall is driven or read.
//
// # Safety
// `run` is from `mercury_open` and not closed; `column` ends with zero; `values` and `count` point to room for one each.
int mercury_grains(struct mercury_t *run,
                   const char *column,
                   const double **values,
                   uintptr_t *count);

// The present state, to go back to; NULL on an error. `mercury_state_free` frees it.
//
// # Safety
// `run` is from `mercury_open` and not closed.
struct mercury_state_t *mercury_save(struct mercury_t *run);

// Goes back to a saved state of this run. Its files are cut back, and all comes out as if the steps behind that state had never been made.
//
// # Safety
// `run` is from `mercury_open` and not closed; `state` is from `mercury_save` and not freed.
int mercury_restore(struct mercury_t *run,
                    const struct mercury_state_t *state);

// Frees a saved state. NULL is left alone.
//
// # Safety
// `state` is from `mercury_save`, and is not used again.
void mercury_state_free(struct mercury_state_t *state);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* MERCURY_H */
