/* A lid presses a bed of grains: every call of mercury.h once, by a program in C. Arguments: scene, folder of the run, one for a second run. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mercury.h"

static void check(int holds, const char *what, const mercury_t *run) {
  if (!holds) {
    fprintf(stderr, "%s: %s\n", what, run ? mercury_error(run) : "");
    exit(1);
  }
}

int main(int count, char **arguments) {
  char error[2000];
  const char *wrong[] = {"time.emd=1", NULL};
  const char *set[] = {"time.end=0.05", NULL};
  if (count != 4) return 2;

  /* Errors are texts. */
  check(mercury_open(arguments[1], arguments[2], wrong, error, sizeof error) == NULL, "a wrong key", NULL);
  check(strstr(error, "time.emd") != NULL, error, NULL);
  check(mercury_open("missing.toml", NULL, NULL, error, 20) == NULL, "a missing scene", NULL);
  check(strlen(error) == 19, "a text that is cut", NULL);
  check(mercury_open(NULL, NULL, NULL, NULL, 0) == NULL, "no scene", NULL);

  mercury_t *run = mercury_open(arguments[1], arguments[2], set, error, sizeof error);
  check(run != NULL, error, NULL);
  check(mercury_time(run) == 0.0 && mercury_step(run) > 0.0, "times", run);
  int lid = mercury_wall(run, "lid"), floor = mercury_wall(run, "floor");
  check(lid >= 0 && floor >= 0 && lid != floor, "walls", run);
  check(mercury_wall(run, "led") == MERCURY_FAILED, "an unknown wall", run);
  check(strstr(mercury_error(run), "no wall `led`; there are: ") != NULL, "its text", run);

  /* The lid goes down in windows of ten steps; once in each window it goes the wrong way first. */
  const double window = 10 * mercury_step(run);
  double pose[7], load[6], mean[6], momentum = 0.0;
  check(mercury_wall_pose(run, lid, pose) == MERCURY_REACHED, "pose", run);
  const double start = pose[2];
  for (int k = 1; k <= 60; ++k) {
    double down[6] = {0, 0, -0.3, 0, 0, 0}, up[6] = {0, 0, 0.2, 0, 0, 0};
    mercury_state_t *state = mercury_save(run);
    check(state != NULL, "save", run);
    pose[2] = start - 0.3 * (k - 1) * window + 0.2 * window;
    check(mercury_wall_drive(run, lid, pose, up) == MERCURY_REACHED, "drive", run);
    check(mercury_advance(run, k * window) == MERCURY_REACHED, "advance", run);
    check(mercury_restore(run, state) == MERCURY_REACHED, "restore", run);
    mercury_state_free(state);
    pose[2] = start - 0.3 * k * window;
    check(mercury_wall_drive(run, lid, pose, down) == MERCURY_REACHED, "drive", run);
    check(mercury_advance(run, k * window) == MERCURY_REACHED, "advance", run);
    check(mercury_wall_load(run, lid, load, mean) == MERCURY_REACHED, "load", run);
    momentum += mean[2] * window;
    check(mercury_wall_pose(run, lid, pose) == MERCURY_REACHED, "pose", run);
    check(pose[2] == start - 0.3 * k * window, "the lid is where its pose says", run);
  }
  check(momentum > 0.0 && load[2] > 0.0, "grains press the lid up", run);
  check(mercury_wall_drive(run, floor, pose, mean) == MERCURY_FAILED, "a wall of the scene", run);
  check(strstr(mercury_error(run), "external") != NULL, "its text", run);

  /* Columns stay until the run goes on. */
  const double *z, *mass;
  size_t grains, others;
  check(mercury_grains(run, "z", &z, &grains) == MERCURY_REACHED && grains > 0, "column", run);
  check(mercury_grains(run, "mass", &mass, &others) == MERCURY_REACHED && others == grains, "column", run);
  double height = 0.0, whole = 0.0;
  for (size_t k = 0; k < grains; ++k) height += mass[k] * z[k], whole += mass[k];
  check(isfinite(height / whole) && height / whole > 0.0, "centre of mass", run);
  check(mercury_grains(run, "u", &z, &grains) == MERCURY_FAILED, "an unknown column", run);

  check(mercury_advance(run, NAN) == MERCURY_FAILED, "no time", run);
  check(mercury_advance(run, INFINITY) == MERCURY_ENDED, "to the end", run);
  check(mercury_finish(run) == MERCURY_REACHED, "finish", run);
  check(fabs(mercury_time(run) - 0.05) < mercury_step(run), "the end", run);
  check(mercury_advance(run, 1.0) == MERCURY_FAILED, "behind the end", run);
  mercury_close(run);
  mercury_close(NULL);
  mercury_state_free(NULL);

  /* The same without wrong ways. */
  run = mercury_open(arguments[1], arguments[3], set, error, sizeof error);
  check(run != NULL, error, NULL);
  for (int k = 1; k <= 60; ++k) {
    double down[6] = {0, 0, -0.3, 0, 0, 0};
    check(mercury_wall_pose(run, lid, pose) == MERCURY_REACHED, "pose", run);
    pose[2] = start - 0.3 * k * window;
    check(mercury_wall_drive(run, lid, pose, down) == MERCURY_REACHED, "drive", run);
    check(mercury_advance(run, k * window) == MERCURY_REACHED, "advance", run);
  }
  check(mercury_advance(run, INFINITY) == MERCURY_ENDED, "to the end", run);
  check(mercury_finish(run) == MERCURY_REACHED, "finish", run);
  mercury_close(run);
  printf("momentum of the lid: %.17g N s\n", momentum);
  return 0;
}
