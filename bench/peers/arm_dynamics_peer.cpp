// Calls per second of Pinocchio's algorithms on a chain of revolute joints, one state after another, as a JSON object.
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/joint.hpp>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "rates.hpp"

using namespace pinocchio;

int main() {
  // Standard input: the number of joints, then for each its parent, the letter of its axis, its placement (R row by row, p),
  // mass, centre of mass and inertia about it (row by row).
  Model model;
  int joints;
  if (scanf("%d", &joints) != 1) return 2;
  for (int i = 0; i < joints; ++i) {
    int parent;
    char axis;
    double x[25];
    if (scanf("%d %c", &parent, &axis) != 2) return 2;
    for (double& value : x) if (scanf("%lf", &value) != 1) return 2;
    const SE3 placement(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(x), Eigen::Vector3d(x[9], x[10], x[11]));
    const Inertia body(x[12], Eigen::Vector3d(x[13], x[14], x[15]), Eigen::Map<const Eigen::Matrix3d>(x + 16));
    const std::string name = "joint_" + std::to_string(i);
    const JointIndex id = axis == 'X' ? model.addJoint(parent, JointModelRX(), placement, name)
                        : axis == 'Y' ? model.addJoint(parent, JointModelRY(), placement, name)
                                      : model.addJoint(parent, JointModelRZ(), placement, name);
    model.appendBodyToJoint(id, body);
  }
  Data data(model);
  const size_t states = 256;
  std::vector<Eigen::VectorXd> q, v, a;
  srand(1);
  for (size_t i = 0; i < states; ++i) {
    q.push_back(Eigen::VectorXd::Random(model.nq));
    v.push_back(Eigen::VectorXd::Random(model.nv));
    a.push_back(Eigen::VectorXd::Random(model.nv));
  }
  double sum = 0;
  const double r = rate([&](size_t i) { sum += rnea(model, data, q[i], v[i], a[i])[0]; }, states);
  const double l = rate([&](size_t i) { sum += aba(model, data, q[i], v[i], a[i], Convention::LOCAL)[0]; }, states);
  const double w = rate([&](size_t i) { sum += aba(model, data, q[i], v[i], a[i], Convention::WORLD)[0]; }, states);
  const double cl = rate([&](size_t i) { sum += crba(model, data, q[i], Convention::LOCAL)(0, 0); }, states);
  const double cw = rate([&](size_t i) { sum += crba(model, data, q[i], Convention::WORLD)(0, 0); }, states);
  const double dr = rate([&](size_t i) { computeRNEADerivatives(model, data, q[i], v[i], a[i]); sum += data.dtau_dq(0, 0); }, states);
  const double da = rate([&](size_t i) { computeABADerivatives(model, data, q[i], v[i], a[i]); sum += data.ddq_dq(0, 0); }, states);
  printf("{\"joints\": %d, \"inverse_dynamics\": %.0f, \"forward_dynamics\": %.0f, \"mass_matrix\": %.0f, "
         "\"inverse_derivatives\": %.0f, \"forward_derivatives\": %.0f, \"checksum\": %.6g}\n",
         model.nv, r, std::max(l, w), std::max(cl, cw), dr, da, sum);
}
