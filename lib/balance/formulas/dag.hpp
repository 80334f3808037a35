#pragma once
/// Straight-line programs: expressions in which what is alike is calculated once. A second ring for the recursions.
/// Private to formulas.

#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

namespace balance::formulas {

enum class ProgramOperation { constant, input, sum, difference, product, negative, cosine, sine, root, inverse };

/// Operations of one number.
constexpr bool is_unary(ProgramOperation operation) { return operation >= ProgramOperation::negative; }

struct ProgramNode {
  ProgramOperation operation = ProgramOperation::constant;
  int a = 0, b = 0;
  double value = 0;                 ///< of a constant
  std::string name;                 ///< of a leaf
  bool is_state_dependent = false;  ///< it depends on the state: else it is calculated once per mechanism
};

/// Operations in the order in which they can be done, each once.
class StraightLineProgram {
 public:
  static constexpr std::size_t max_nodes = 500'000;

  int add_constant(double value);
  int add_input(const std::string& name, bool moves);
  int add_operation(ProgramOperation operation, int a, int b);
  const ProgramNode& operator[](int index) const { return nodes_[static_cast<std::size_t>(index)]; }
  std::size_t size() const { return nodes_.size(); }

 private:
  int add(ProgramNode node);
  std::vector<ProgramNode> nodes_;
  std::map<double, int> constants_;
  std::map<std::string, int> leaves_;
  std::unordered_map<std::uint64_t, int> known_;
};

/// A node as a number that calculates. Plain numbers know no arena until they meet one that does.
class ProgramValue {
 public:
  ProgramValue() = default;
  ProgramValue(double value) : value_(value) {}  // NOLINT(google-explicit-constructor)
  ProgramValue(int value) : value_(value) {}     // NOLINT(google-explicit-constructor)
  ProgramValue(StraightLineProgram& arena, int node);

  bool is(double value) const { return arena_ == nullptr && value_ == value; }
  bool is_number() const { return arena_ == nullptr; }
  double value() const { return value_; }
  /// The node, made in an arena if it is a plain number.
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

}  // namespace balance::formulas
