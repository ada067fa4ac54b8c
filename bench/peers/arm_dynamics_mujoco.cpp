// Calls per second of MuJoCo's dynamics on the model of a file, one state after another, as a JSON object.
#include <mujoco/mujoco.h>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "rates.hpp"

int main(int, char** arguments) {
  char error[1000] = "";
  mjModel* model = mj_loadXML(arguments[1], nullptr, error, sizeof error);
  if (!model) {
    fprintf(stderr, "%s\n", error);
    return 1;
  }
  mjData* data = mj_makeData(model);
  const size_t n = model->nv, states = 256;
  std::vector<double> values(3 * n * states), x(n), force(n);
  srand(1);
  for (double& value : values) value = 2.0 * rand() / RAND_MAX - 1.0;
  double sum = 0;
  const auto set = [&](size_t i) {
    for (size_t k = 0; k < n; ++k) {
      data->qpos[k] = values[(3 * i) * n + k];
      data->qvel[k] = values[(3 * i + 1) * n + k];
      data->qacc[k] = values[(3 * i + 2) * n + k];
    }
  };
  const auto positions = [&](size_t i) {
    set(i);
    mj_kinematics(model, data);
    mj_comPos(model, data);
  };
  const double inverse = rate([&](size_t i) {
    positions(i);
    mj_comVel(model, data);
    mj_rne(model, data, 1, x.data());
    sum += x[0];
  }, states);
  const double mass = rate([&](size_t i) {
    positions(i);
    mj_makeM(model, data);
    sum += data->M[0];
  }, states);
  const double forward = rate([&](size_t i) {
    positions(i);
    mj_makeM(model, data);
    mj_factorM(model, data);
    mj_comVel(model, data);
    mj_rne(model, data, 0, force.data());
    for (size_t k = 0; k < n; ++k) force[k] = values[(3 * i + 2) * n + k] - force[k];
    mj_solveM(model, data, x.data(), force.data(), 1);
    sum += x[0];
  }, states);
  printf("{\"joints\": %zu, \"inverse_dynamics\": %.0f, \"forward_dynamics\": %.0f, \"mass_matrix\": %.0f, \"checksum\": %.6g}\n",
         n, inverse, forward, mass, sum);
}
