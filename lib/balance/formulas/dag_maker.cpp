#include "balance/formulas/dag_maker.hpp"

#include <cstdlib>

namespace balance::formulas {

Dag DagMaker::wave(const Circular& function) {
  Dag argument(0);
  for (const auto& [angle, multiple] : function.argument) argument = argument + Dag(multiple) * angle_of(angle);
  return unary(function.sine ? Operation::sine : Operation::cosine, argument);
}

Dag DagMaker::of(const Polynomial& p) {
  Dag sum(0);
  for (const Term& term : p.terms()) {
    Dag product(term.factor.value());
    for (int k = 0; k < term.monomial.size(); ++k) {
      const Dag base = symbol(term.monomial.symbol(k));
      const int exponent = term.monomial.exponent(k);
      const Dag factor = exponent < 0 ? unary(Operation::inverse, base) : base;
      for (int n = 0; n < std::abs(exponent); ++n) product = product * factor;
    }
    if (term.wave != 0)
      for (const Circular& function : ring_.wave(term.wave)) product = product * wave(function);
    sum = sum + product;
  }
  return sum;
}

namespace {

std::string item(const char* list, int index) { return std::string(list) + "[" + std::to_string(index) + "]"; }

}  // namespace

std::vector<Dag> torque_program(Arena& arena, Ring& ring, const SymbolicTree& tree) {
  DagMaker make(arena, ring);
  VariableRates<Dag> rates;
  std::vector<Dag> value;
  for (const Variable& variable : tree.variables) {
    Dag x = make.of(variable.offset), v(0), a(0);
    for (const auto& [column, ratio] : variable.follows) {
      const Dag n = make.of(ratio);
      x = x + n * make.leaf(item("q", column), true);
      v = v + n * make.leaf(item("dq", column), true);
      a = a + n * make.leaf(item("ddq", column), true);
    }
    if (variable.is_angle)
      make.move_angle(variable.index, x);
    else
      make.move_symbol(variable.index, x);
    value.push_back(x);
    rates.rate.push_back(v);
    rates.acceleration.push_back(a);
  }
  for (const JointSpring& spring : tree.joint_springs)
    make.move_symbol(spring.symbol, value[static_cast<std::size_t>(spring.variable)]);
  return inverse_dynamics<Dag>(tree, make, rates);
}

}  // namespace balance::formulas
