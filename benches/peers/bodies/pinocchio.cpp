// Pinocchio's articulated-body algorithm, its templates compiled here, for the tables in FOLDER.
#include "model.hpp"
#include <pinocchio/algorithm/aba.hpp>

namespace {
struct Bodies {
  pin::Model model;
  pin::Data data;
  Eigen::VectorXd torques;
  explicit Bodies(const char* name) : model(model_of(name)), data(model), torques(Eigen::VectorXd::Zero(model.nv)) {}
  void accelerations(const double* q, const double* w, double* a) {
    using Vector = Eigen::Map<const Eigen::VectorXd>;
    pin::aba(model, data, Vector(q, model.nq), Vector(w, model.nv), torques, pin::Convention::LOCAL);
    Eigen::Map<Eigen::VectorXd>(a, model.nv) = data.ddq;
  }
};
}  // namespace

#define FUNCTION(name) \
  extern "C" void accel_##name(const double* q, const double* w, double* a) { \
    static Bodies bodies(FOLDER "/" #name ".txt"); \
    bodies.accelerations(q, w, a); \
  }
FUNCTION(body)
FUNCTION(chain)
FUNCTION(arm)
