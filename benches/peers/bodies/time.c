/* Times functions accel(q, w, a) of shared objects in turn: time ROUNDS REPEAT LIBRARY:SYMBOL:STATES:COORDINATES:VELOCITIES …
 * A file of states has the coordinates and the velocities of each, in the variables of its library. Accelerations of all states are
 * written beside it. Prints for each the median nanoseconds of a call and the quartiles of its ratio to the first. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#define STATES 256
#define MOST 64
typedef void (*function)(const double *, const double *, double *);
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }
static int order(const void *a, const void *b) { double x = *(double *)a, y = *(double *)b; return (x > y) - (x < y); }
static double state[8][STATES][2 * MOST], times[8][1001], ratios[1001];
int main(int count, char **words) {
  int rounds = atoi(words[1]), repeat = atoi(words[2]), peers = count - 3, n[8], m[8];
  function f[8];
  double out[STATES][MOST];
  for (int k = 0; k < peers; k++) {
    char *library = strtok(words[3 + k], ":"), *symbol = strtok(0, ":"), *states = strtok(0, ":");
    n[k] = atoi(strtok(0, ":")); m[k] = atoi(strtok(0, ":"));
    void *handle = dlopen(library, RTLD_NOW);
    if (!handle || !(f[k] = (function)dlsym(handle, symbol))) { fprintf(stderr, "%s\n", dlerror()); return 1; }
    FILE *file = fopen(states, "rb");
    char name[4096]; snprintf(name, sizeof name, "%s.out", states);
    FILE *written = fopen(name, "wb");
    for (int s = 0; s < STATES; s++) {
      if (fread(state[k][s], sizeof(double), n[k] + m[k], file) != (size_t)(n[k] + m[k])) return 2;
      f[k](state[k][s], state[k][s] + n[k], out[s]);
      fwrite(out[s], sizeof(double), m[k], written);
    }
    fclose(file); fclose(written);
  }
  for (int r = 0; r < rounds; r++) for (int j = 0; j < peers; j++) {
    int k = (j + r) % peers; double start = now();
    for (int p = 0; p < repeat; p++) for (int s = 0; s < STATES; s++) f[k](state[k][s], state[k][s] + n[k], out[s]);
    times[k][r] = (now() - start) * 1e9 / repeat / STATES;
  }
  for (int k = 0; k < peers && rounds > 0; k++) {
    for (int r = 0; r < rounds; r++) ratios[r] = times[0][r] / times[k][r];
    qsort(ratios, rounds, sizeof(double), order);
    double low = ratios[rounds / 4], middle = ratios[rounds / 2], high = ratios[3 * rounds / 4];
    qsort(times[k], rounds, sizeof(double), order);
    printf("%.1f %.4f %.4f %.4f\n", times[k][rounds / 2], low, middle, high);
  }
}
