// Pinocchio's articulated-body algorithm over CasADi's symbols, as C: generated TABLE FILE. Prints the number of arithmetic operations.
#include "model.hpp"
#include <casadi/casadi.hpp>
#include <iostream>
#include <pinocchio/autodiff/casadi.hpp>
#include <pinocchio/algorithm/aba.hpp>

using Symbol = casadi::SX;

int main(int, char** arguments) {
  const pin::Model bodies = model_of(arguments[1]);
  const auto model = bodies.cast<Symbol>();
  pin::DataTpl<Symbol> data(model);
  Symbol q = Symbol::sym("q", bodies.nq), w = Symbol::sym("w", bodies.nv), a(bodies.nv, 1);
  Eigen::Matrix<Symbol, -1, 1> places(bodies.nq), rates(bodies.nv), torques(bodies.nv);
  for (int i = 0; i < bodies.nq; i++) places[i] = q(i);
  for (int i = 0; i < bodies.nv; i++) { rates[i] = w(i); torques[i] = Symbol(0); }
  pin::aba(model, data, places, rates, torques, pin::Convention::LOCAL);
  for (int i = 0; i < bodies.nv; i++) a(i) = data.ddq[i];
  const casadi::Function function("f", {q, w}, {a}, casadi::Dict{{"cse", true}});
  function.generate(arguments[2], casadi::Dict{{"with_header", false}});
  int operations = 0;
  for (int k = 0; k < function.n_instructions(); k++) {
    const auto op = function.instruction_id(k);
    operations += op == casadi::OP_ADD || op == casadi::OP_SUB || op == casadi::OP_MUL || op == casadi::OP_DIV || op == casadi::OP_SQ
        || op == casadi::OP_TWICE || op == casadi::OP_INV;
  }
  std::cout << operations << std::endl;
}
