#pragma once
/// Straight-line programs: expressions in which what is alike is calculated once. A second ring for the recursions.
/// Private to formulas.

#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

namespace balance::formulas {

enum class Operation { constant, leaf, sum, difference, product, negative, cosine, sine, root, inverse };

/// Operations of one number.
constexpr bool is_unary(Operation operation) { return operation >= Operation::negative; }

struct DagNode {
  Operation operation = Operation::constant;
  int a = 0, b = 0;
  double value = 0;    ///< of a constant
  std::string name;    ///< of a leaf
  bool moves = false;  ///< it depends on the state: else it is calculated once per mechanism
};

/// Operations in the order in which they can be done, each once.
class Arena {
 public:
  static constexpr std::size_t most_nodes = 500'000;

  int constant(double value);
  int leaf(const std::string& name, bool moves);
  int make(Operation operation, int a, int b);
  const DagNode& operator[](int index) const { return nodes_[static_cast<std::size_t>(index)]; }
  std::size_t size() const { return nodes_.size(); }

 private:
  int add(DagNode node);
  std::vector<DagNode> nodes_;
  std::map<double, int> constants_;
  std::map<std::string, int> leaves_;
  std::unordered_map<std::uint64_t, int> known_;
};

/// A node as a number that calculates. Plain numbers know no arena until they meet one that does.
class Dag {
 public:
  Dag() = default;
  Dag(double value) : value_(value) {}  // NOLINT(google-explicit-constructor)
  Dag(int value) : value_(value) {}     // NOLINT(google-explicit-constructor)
  Dag(Arena& arena, int node);

  bool is(double value) const { return arena_ == nullptr && value_ == value; }
  bool is_number() const { return arena_ == nullptr; }
  double value() const { return value_; }
  /// The node, made in an arena if it is a plain number.
  int node(Arena& arena) const { return arena_ == nullptr ? arena.constant(value_) : node_; }

  Dag operator-() const;
  friend Dag operator+(const Dag& a, const Dag& b);
  friend Dag operator-(const Dag& a, const Dag& b);
  friend Dag operator*(const Dag& a, const Dag& b);

 private:
  bool is_negative() const;
  Dag opposite() const;
  Arena* arena_ = nullptr;
  int node_ = 0;
  double value_ = 0;
};

}  // namespace balance::formulas
