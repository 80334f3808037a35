#include "balance/synthesis/formulas/straight_line_program.hpp"

#include "balance/synthesis/formulas/rational.hpp"

#include <cstdlib>
#include <utility>

namespace balance::formulas {

int StraightLineProgram::add(ProgramNode node) {
  if (nodes_.size() >= max_nodes) throw FormulaError("the program is too long");
  nodes_.push_back(std::move(node));
  return static_cast<int>(nodes_.size()) - 1;
}

int StraightLineProgram::add_constant(double value) {
  const auto [entry, is_new] = constants_.try_emplace(value, 0);
  if (is_new) entry->second = add({ProgramOperation::constant, 0, 0, value, "", false});
  return entry->second;
}

int StraightLineProgram::add_input(const std::string& name, bool is_state_dependent) {
  const auto [entry, is_new] = inputs_.try_emplace(name, 0);
  if (is_new) entry->second = add({ProgramOperation::input, 0, 0, 0, name, is_state_dependent});
  return entry->second;
}

int StraightLineProgram::add_operation(ProgramOperation operation, int a, int b) {
  if ((operation == ProgramOperation::sum || operation == ProgramOperation::product) && a > b) std::swap(a, b);
  // there are fewer than 2^20 nodes
  const auto key =
      static_cast<std::uint64_t>(operation) << 60 | static_cast<std::uint64_t>(a) << 30 | static_cast<std::uint64_t>(b);
  const auto [entry, is_new] = operations_.try_emplace(key, 0);
  if (is_new) {
    const bool is_state_dependent = nodes_[static_cast<std::size_t>(a)].is_state_dependent ||
                                    nodes_[static_cast<std::size_t>(b)].is_state_dependent;
    entry->second = add({operation, a, b, 0, "", is_state_dependent});
  }
  return entry->second;
}

ProgramValue::ProgramValue(StraightLineProgram& arena, int node) : arena_(&arena), node_(node) {}

bool ProgramValue::is_negative() const {
  return arena_ != nullptr && (*arena_)[node_].operation == ProgramOperation::negative;
}
ProgramValue ProgramValue::opposite() const { return {*arena_, (*arena_)[node_].a}; }

ProgramValue ProgramValue::operator-() const {
  if (arena_ == nullptr) return {-value_};
  const ProgramNode& self = (*arena_)[node_];
  if (self.operation == ProgramOperation::negative) return opposite();
  if (self.operation == ProgramOperation::difference)
    return {*arena_, arena_->add_operation(ProgramOperation::difference, self.b, self.a)};
  return {*arena_, arena_->add_operation(ProgramOperation::negative, node_, node_)};
}

ProgramValue operator+(const ProgramValue& a, const ProgramValue& b) {
  if (a.is_number() && b.is_number()) return {a.value_ + b.value_};
  if (a.is(0)) return b;
  if (b.is(0)) return a;
  if (b.is_negative()) return a - b.opposite();
  if (a.is_negative()) return b - a.opposite();
  StraightLineProgram& arena = a.is_number() ? *b.arena_ : *a.arena_;
  return {arena, arena.add_operation(ProgramOperation::sum, a.node(arena), b.node(arena))};
}

ProgramValue operator-(const ProgramValue& a, const ProgramValue& b) {
  if (a.is_number() && b.is_number()) return {a.value_ - b.value_};
  if (b.is(0)) return a;
  if (a.is(0)) return -b;
  if (b.is_negative()) return a + b.opposite();
  StraightLineProgram& arena = a.is_number() ? *b.arena_ : *a.arena_;
  const int left = a.node(arena), right = b.node(arena);
  if (left == right) return {0};
  return {arena, arena.add_operation(ProgramOperation::difference, left, right)};
}

ProgramValue operator*(const ProgramValue& a, const ProgramValue& b) {
  if (a.is_number() && b.is_number()) return {a.value_ * b.value_};
  if (a.is(0) || b.is(0)) return {0};
  if (a.is(1)) return b;
  if (b.is(1)) return a;
  if (a.is(-1)) return -b;
  if (b.is(-1)) return -a;
  if (a.is_negative()) return -(a.opposite() * b);
  if (b.is_negative()) return -(a * b.opposite());
  StraightLineProgram& arena = a.is_number() ? *b.arena_ : *a.arena_;
  return {arena, arena.add_operation(ProgramOperation::product, a.node(arena), b.node(arena))};
}

ProgramValue ProgramFactory::circular_value(const CircularFunction& function) {
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
      for (const CircularFunction& function : ring_.wave(term.wave)) product = product * circular_value(function);
    sum = sum + product;
  }
  return sum;
}

namespace {

std::string item(const char* list, int index) { return std::string(list) + "[" + std::to_string(index) + "]"; }

}  // namespace

std::vector<ProgramValue> build_torque_program(StraightLineProgram& arena, Ring& ring, const SymbolicTree& tree) {
  ProgramFactory factory(arena, ring);
  VariableRates<ProgramValue> rates;
  std::vector<ProgramValue> values;
  for (const JointVariable& variable : tree.variables) {
    ProgramValue x = factory.convert(variable.offset), v(0), a(0);
    for (const auto& [column, ratio] : variable.follows) {
      const ProgramValue n = factory.convert(ratio);
      x = x + n * factory.leaf(item("q", column), true);
      v = v + n * factory.leaf(item("dq", column), true);
      a = a + n * factory.leaf(item("ddq", column), true);
    }
    if (variable.is_angle)
      factory.bind_angle(variable.index, x);
    else
      factory.bind_symbol(variable.index, x);
    values.push_back(x);
    rates.rate.push_back(v);
    rates.acceleration.push_back(a);
  }
  for (const JointSpring& spring : tree.joint_springs)
    factory.bind_symbol(spring.symbol, values[static_cast<std::size_t>(spring.variable)]);
  return newton_euler_torques<ProgramValue>(tree, factory, rates);
}

}  // namespace balance::formulas
