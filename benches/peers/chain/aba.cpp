// Pinocchio's articulated-body algorithm over CasADi's symbols, as C: aba LINKS FILE. Hinges about y, angles between links.
#include <casadi/casadi.hpp>
#include <pinocchio/autodiff/casadi.hpp>
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>

namespace pin = pinocchio;
using Symbol = casadi::SX;

int main(int, char** arguments) {
  const int n = std::atoi(arguments[1]);
  pin::Model links;
  pin::JointIndex parent = 0;
  pin::SE3 place = pin::SE3::Identity();
  const Eigen::Vector3d bob(0, 0, -1);
  for (int i = 0; i < n; i++) {
    parent = links.addJoint(parent, pin::JointModelRY(), place, "joint" + std::to_string(i));
    links.appendBodyToJoint(parent, pin::Inertia(1.0, bob, Eigen::Matrix3d::Zero()), pin::SE3::Identity());
    place.translation() = bob;
  }
  links.gravity.linear() = Eigen::Vector3d(0, 0, -9.81);
  auto model = links.cast<Symbol>();
  pin::DataTpl<Symbol> data(model);
  Symbol q = Symbol::sym("q", n), w = Symbol::sym("w", n), a(n, 1);
  Eigen::Matrix<Symbol, -1, 1> angles(n), rates(n), torques(n);
  for (int i = 0; i < n; i++) { angles[i] = -q(i); rates[i] = -w(i); torques[i] = Symbol(0); }
  pin::aba(model, data, angles, rates, torques, pin::Convention::LOCAL);
  for (int i = 0; i < n; i++) a(i) = -data.ddq[i];
  casadi::Function("f", {q, w}, {a}, casadi::Dict{{"cse", true}}).generate(arguments[2], casadi::Dict{{"with_header", false}});
}
