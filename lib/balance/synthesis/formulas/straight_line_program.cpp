#include "balance/synthesis/formulas/straight_line_program.hpp"

#include "balance/synthesis/formulas/rational.hpp"

#include <algorithm>
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

std::string item(const char* list, std::size_t index) { return std::string(list) + "[" + std::to_string(index) + "]"; }

/// Derivatives of nodes for given derivatives of inputs; those of all other inputs are zero.
class ProgramDerivative {
 public:
  ProgramDerivative(StraightLineProgram& arena, std::map<int, ProgramValue> inputs)
      : arena_(arena), derivatives_(std::move(inputs)) {}

  ProgramValue of(const ProgramValue& value) {
    if (value.is_number()) return 0;
    const int node = value.node(arena_);
    for (const int operand : list_operands(node)) derivatives_.try_emplace(operand, derive(operand));
    return derivatives_.at(node);
  }

 private:
  /// A node and what it depends on, without what is known; operands first.
  std::vector<int> list_operands(int node) const {
    std::vector<int> list, stack{node};
    std::vector<bool> is_visited(static_cast<std::size_t>(node) + 1, false);
    while (!stack.empty()) {
      const int next = stack.back();
      stack.pop_back();
      if (is_visited[static_cast<std::size_t>(next)] || derivatives_.contains(next)) continue;
      is_visited[static_cast<std::size_t>(next)] = true;
      list.push_back(next);
      const ProgramNode& self = arena_[next];
      if (self.operation == ProgramOperation::constant || self.operation == ProgramOperation::input) continue;
      stack.push_back(self.a);
      if (!is_unary(self.operation)) stack.push_back(self.b);
    }
    std::sort(list.begin(), list.end());
    return list;
  }

  ProgramValue unary(ProgramOperation operation, int operand) {
    return {arena_, arena_.add_operation(operation, operand, operand)};
  }

  ProgramValue derive(int node) {
    const ProgramNode self = arena_[node];  // a copy: the nodes move as others are added
    using enum ProgramOperation;
    if (self.operation == constant || self.operation == input) return 0;
    const ProgramValue da = derivatives_.at(self.a), a(arena_, self.a), own(arena_, node);
    switch (self.operation) {
      case sum: return da + derivatives_.at(self.b);
      case difference: return da - derivatives_.at(self.b);
      case product: return da * ProgramValue(arena_, self.b) + a * derivatives_.at(self.b);
      case negative: return -da;
      case cosine: return da.is(0) ? 0 : -(unary(sine, self.a) * da);
      case sine: return da.is(0) ? 0 : unary(cosine, self.a) * da;
      case root: return da.is(0) ? 0 : ProgramValue(0.5) * unary(inverse, node) * da;
      case inverse: return -(own * own * da);
      case constant:
      case input: break;
    }
    return 0;
  }

  StraightLineProgram& arena_;
  std::map<int, ProgramValue> derivatives_;
};

void add_closures(StraightLineProgram& arena, ProgramFactory& factory, const SymbolicTree& tree, TreeProgram& program) {
  program.closures = closure_equations<ProgramValue>(tree, factory);
  const std::size_t n = tree.columns.size();
  std::vector<std::vector<ProgramValue>> columns;
  std::map<int, ProgramValue> rates;
  for (std::size_t c = 0; c < n; ++c) {
    const int q = factory.leaf(item("q", c), true).node(arena);
    rates.emplace(q, factory.leaf(item("dq", c), true));
    ProgramDerivative by_column(arena, {{q, ProgramValue(1)}});
    columns.emplace_back();
    for (const ProgramValue& h : program.closures) columns.back().push_back(by_column.of(h));
  }
  ProgramDerivative by_time(arena, rates), by_time_again(arena, rates);
  for (std::size_t r = 0; r < program.closures.size(); ++r) {
    for (std::size_t c = 0; c < n; ++c) program.jacobian.push_back(columns[c][r]);
    program.bias.push_back(by_time_again.of(by_time.of(program.closures[r])));
  }
}

}  // namespace

TreeProgram build_tree_program(StraightLineProgram& arena, Ring& ring, const SymbolicTree& tree,
                               const std::vector<CoordinateId>& actuators) {
  ProgramFactory factory(arena, ring);
  VariableRates<ProgramValue> rates;
  std::vector<ProgramValue> values;
  for (const JointVariable& variable : tree.variables) {
    ProgramValue x = factory.convert(variable.offset), v(0), a(0);
    for (const auto& [column, ratio] : variable.follows) {
      const ProgramValue n = factory.convert(ratio);
      x = x + n * factory.leaf(item("q", static_cast<std::size_t>(column)), true);
      v = v + n * factory.leaf(item("dq", static_cast<std::size_t>(column)), true);
      a = a + n * factory.leaf(item("ddq", static_cast<std::size_t>(column)), true);
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
  TreeProgram program;
  program.torques = newton_euler_torques<ProgramValue>(tree, factory, rates);
  if (tree.closures.empty()) return program;
  add_closures(arena, factory, tree, program);
  program.inputs.resize(tree.columns.size() * actuators.size());
  for (std::size_t a = 0; a < actuators.size(); ++a) {
    const int variable = tree.coordinate_variable[static_cast<std::size_t>(actuators[a])];
    for (const auto& [column, ratio] : tree.variables[static_cast<std::size_t>(variable)].follows)
      program.inputs[static_cast<std::size_t>(column) * actuators.size() + a] = factory.convert(ratio);
  }
  return program;
}

}  // namespace balance::formulas
