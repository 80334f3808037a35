#include "balance/formulas/dag_maker.hpp"

#include <cstdlib>

namespace balance::formulas {

ProgramValue ProgramFactory::wave(const CircularFunction& function) {
  ProgramValue argument(0);
  for (const auto& [angle, multiple] : function.argument)
    argument = argument + ProgramValue(multiple) * angle_of(angle);
  return unary(function.is_sine ? ProgramOperation::sine : ProgramOperation::cosine, argument);
}

ProgramValue ProgramFactory::convert(const Polynomial& p) {
  ProgramValue sum(0);
  for (const Term& term : p.terms()) {
    ProgramValue product(term.coefficient.value());
    for (int k = 0; k < term.monomial.size(); ++k) {
      const ProgramValue base = symbol(term.monomial.symbol(k));
      const int exponent = term.monomial.exponent(k);
      const ProgramValue factor = exponent < 0 ? unary(ProgramOperation::inverse, base) : base;
      for (int n = 0; n < std::abs(exponent); ++n) product = product * factor;
    }
    if (term.wave != 0)
      for (const CircularFunction& function : ring_.wave(term.wave)) product = product * wave(function);
    sum = sum + product;
  }
  return sum;
}

namespace {

std::string item(const char* list, int index) { return std::string(list) + "[" + std::to_string(index) + "]"; }

}  // namespace

std::vector<ProgramValue> build_torque_program(StraightLineProgram& arena, Ring& ring, const SymbolicTree& tree) {
  ProgramFactory make(arena, ring);
  VariableRates<ProgramValue> rates;
  std::vector<ProgramValue> value;
  for (const JointVariable& variable : tree.variables) {
    ProgramValue x = make.convert(variable.offset), v(0), a(0);
    for (const auto& [column, ratio] : variable.follows) {
      const ProgramValue n = make.convert(ratio);
      x = x + n * make.leaf(item("q", column), true);
      v = v + n * make.leaf(item("dq", column), true);
      a = a + n * make.leaf(item("ddq", column), true);
    }
    if (variable.is_angle)
      make.bind_angle(variable.index, x);
    else
      make.bind_symbol(variable.index, x);
    value.push_back(x);
    rates.rate.push_back(v);
    rates.acceleration.push_back(a);
  }
  for (const JointSpring& spring : tree.joint_springs)
    make.bind_symbol(spring.symbol, value[static_cast<std::size_t>(spring.variable)]);
  return newton_euler_torques<ProgramValue>(tree, make, rates);
}

}  // namespace balance::formulas
