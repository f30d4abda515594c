/* MuJoCo's forward dynamics of the file MODEL, which switches contacts and constraints off. */
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void accel(const double *q, const double *w, double *a) {
  static mjModel *model;
  static mjData *data;
  if (!model) {
    char error[1000];
    model = mj_loadXML(MODEL, 0, error, sizeof error);
    if (!model) { fprintf(stderr, "%s\n", error); exit(1); }
    data = mj_makeData(model);
  }
  memcpy(data->qpos, q, model->nq * sizeof(double));
  memcpy(data->qvel, w, model->nv * sizeof(double));
  mj_forward(model, data);
  memcpy(a, data->qacc, model->nv * sizeof(double));
}
