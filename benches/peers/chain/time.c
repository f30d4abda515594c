/* Times functions accel(q, w, a) of shared objects in turn, on the same 256 states: time LINKS ROUNDS LIBRARY:SYMBOL:relative? …
 * Prints for each the median nanoseconds of a call, the median ratio to the first, and the largest difference from it. Functions in
 * relative angles get their states, and are compared, in these. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#define STATES 256
typedef void (*function)(const double *, const double *, double *);
static uint64_t seed = 88172645463325252ull;
static double draw(void) {
  seed ^= seed << 13; seed ^= seed >> 7; seed ^= seed << 17;
  return (double)(seed >> 11) / 4503599627370496.0 - 1;
}
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }
static int order(const void *a, const void *b) { double x = *(double *)a, y = *(double *)b; return (x > y) - (x < y); }
static double q[2][STATES][64], w[2][STATES][64], reference[STATES][64], times[32][101], ratios[101];
int main(int count, char **words) {
  int n = atoi(words[1]), rounds = atoi(words[2]), peers = count - 3;
  function f[32]; int relative[32];
  for (int k = 0; k < peers; k++) {
    char *library = strtok(words[3 + k], ":"), *symbol = strtok(0, ":"); relative[k] = atoi(strtok(0, ":"));
    void *handle = dlopen(library, RTLD_NOW);
    if (!handle || !(f[k] = (function)dlsym(handle, symbol))) { fprintf(stderr, "%s\n", dlerror()); return 1; }
  }
  for (int s = 0; s < STATES; s++) for (int i = 0; i < n; i++) {
    q[0][s][i] = M_PI * draw(); w[0][s][i] = 2 * draw();
    q[1][s][i] = q[0][s][i] - (i ? q[0][s][i - 1] : 0); w[1][s][i] = w[0][s][i] - (i ? w[0][s][i - 1] : 0);
  }
  double out[64], worst[32] = {0};
  for (int k = 0; k < peers; k++) for (int s = 0; s < STATES; s++) {
    double sum = 0, largest = 0, difference = 0;
    f[k](q[relative[k]][s], w[relative[k]][s], out);
    for (int i = 0; i < n; i++) {
      sum = relative[k] ? sum + out[i] : out[i];
      if (k == 0) reference[s][i] = sum;
      double d = fabs(sum - reference[s][i]);
      if (!(d <= difference)) difference = d;
      largest = fmax(largest, fabs(reference[s][i]));
    }
    if (!(difference / largest <= worst[k])) worst[k] = difference / largest;
  }
  int repeat = 1 + (int)(4e5 / STATES / (n * n / 8 + n));
  for (int r = 0; r < rounds; r++) for (int j = 0; j < peers; j++) {
    int k = (j + r) % peers; double start = now();
    for (int p = 0; p < repeat; p++) for (int s = 0; s < STATES; s++) f[k](q[relative[k]][s], w[relative[k]][s], out);
    times[k][r] = (now() - start) * 1e9 / repeat / STATES;
  }
  for (int k = 0; k < peers; k++) {
    for (int r = 0; r < rounds; r++) ratios[r] = times[0][r] / times[k][r];
    qsort(ratios, rounds, sizeof(double), order);
    double ratio = ratios[rounds / 2];
    for (int r = 0; r < rounds; r++) ratios[r] = times[k][r];
    qsort(ratios, rounds, sizeof(double), order);
    printf("%.2f %.4f %.1e\n", ratios[rounds / 2], ratio, worst[k]);
  }
}
