#pragma once
/// Straight-line programs: common subexpressions are computed once. A second ring for the recursions.

#include "balance/synthesis/formulas/symbolic_recursion.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

namespace balance::formulas {

enum class ProgramOperation { constant, input, sum, difference, product, negative, cosine, sine, root, inverse };

/// Operations with one operand.
constexpr bool is_unary(ProgramOperation operation) { return operation >= ProgramOperation::negative; }

struct ProgramNode {
  ProgramOperation operation = ProgramOperation::constant;
  int a = 0, b = 0;
  double value = 0;                 ///< of a constant
  std::string name;                 ///< of an input
  bool is_state_dependent = false;  ///< otherwise it is computed once per mechanism
};

/// Operations in an order of execution, each of them once.
class StraightLineProgram {
 public:
  static constexpr std::size_t max_nodes = 500'000;

  int add_constant(double value);
  int add_input(const std::string& name, bool is_state_dependent);
  int add_operation(ProgramOperation operation, int a, int b);
  const ProgramNode& operator[](int index) const { return nodes_[static_cast<std::size_t>(index)]; }
  std::size_t size() const { return nodes_.size(); }

 private:
  int add(ProgramNode node);
  std::vector<ProgramNode> nodes_;
  std::map<double, int> constants_;
  std::map<std::string, int> inputs_;
  std::unordered_map<std::uint64_t, int> operations_;
};

/// A node with arithmetic operators. Plain numbers have no arena until they are combined with a node.
class ProgramValue {
 public:
  ProgramValue() = default;
  ProgramValue(double value) : value_(value) {}  // NOLINT(google-explicit-constructor)
  ProgramValue(int value) : value_(value) {}     // NOLINT(google-explicit-constructor)
  ProgramValue(StraightLineProgram& arena, int node);

  bool is(double value) const { return arena_ == nullptr && value_ == value; }
  bool is_number() const { return arena_ == nullptr; }
  double value() const { return value_; }
  /// The node; a plain number becomes a constant in the arena.
  int node(StraightLineProgram& arena) const { return arena_ == nullptr ? arena.add_constant(value_) : node_; }

  ProgramValue operator-() const;
  friend ProgramValue operator+(const ProgramValue& a, const ProgramValue& b);
  friend ProgramValue operator-(const ProgramValue& a, const ProgramValue& b);
  friend ProgramValue operator*(const ProgramValue& a, const ProgramValue& b);

 private:
  bool is_negative() const;
  ProgramValue opposite() const;
  StraightLineProgram* arena_ = nullptr;
  int node_ = 0;
  double value_ = 0;
};

/// The recursions' numbers as nodes of a straight-line program.
class ProgramFactory {
 public:
  ProgramFactory(StraightLineProgram& arena, const Ring& ring) : arena_(arena), ring_(ring) {}

  /// The value of an angle or a symbol that moves; all others are inputs.
  void bind_angle(int angle, const ProgramValue& value) { angles_[angle] = value; }
  void bind_symbol(int symbol, const ProgramValue& value) { symbols_[symbol] = value; }

  ProgramValue symbol(int index) {
    const auto bound = symbols_.find(index);
    return bound != symbols_.end() ? bound->second : leaf(ring_.symbol(index).name, false);
  }
  ProgramValue circular(int angle, bool sine) {
    return unary(sine ? ProgramOperation::sine : ProgramOperation::cosine, angle_of(angle));
  }
  ProgramValue convert(const Polynomial& p);
  ProgramValue unary(ProgramOperation operation, const ProgramValue& operand) {
    const int node = operand.node(arena_);
    return {arena_, arena_.add_operation(operation, node, node)};
  }
  ProgramValue root(const ProgramValue& operand) { return unary(ProgramOperation::root, operand); }
  ProgramValue inverse(const ProgramValue& operand) { return unary(ProgramOperation::inverse, operand); }
  ProgramValue leaf(const std::string& name, bool is_state_dependent) {
    return {arena_, arena_.add_input(name, is_state_dependent)};
  }

 private:
  ProgramValue angle_of(int angle) {
    const auto bound = angles_.find(angle);
    return bound != angles_.end() ? bound->second : leaf(ring_.angle(angle).name, false);
  }
  ProgramValue circular_value(const CircularFunction& function);

  StraightLineProgram& arena_;
  const Ring& ring_;
  std::map<int, ProgramValue> angles_, symbols_;
};

/// A tree at the states `q[i]`, `dq[i]`, `ddq[i]` of its columns.
struct TreeProgram {
  std::vector<ProgramValue> torques;   ///< per column, including springs
  std::vector<ProgramValue> closures;  ///< h
  std::vector<ProgramValue> jacobian;  ///< ∂h/∂q, row by row
  std::vector<ProgramValue> bias;      ///< second derivative of h by time at zero accelerations
  std::vector<ProgramValue> inputs;    ///< columns × actuators, row by row: rate of each actuator per rate of a column
};
/// @param actuators coordinates of the tree
TreeProgram build_tree_program(StraightLineProgram& arena, Ring& ring, const SymbolicTree& tree,
                               const std::vector<CoordinateId>& actuators);

}  // namespace balance::formulas
