#pragma once
/// The recursions' numbers as nodes of a straight-line program. Private to formulas.

#include "balance/formulas/dag.hpp"
#include "balance/formulas/newton_euler.hpp"

#include <string>
#include <vector>

namespace balance::formulas {

class DagMaker {
 public:
  /// @param angles, symbols what stands for those that move; others are leaves
  DagMaker(Arena& arena, const Ring& ring) : arena_(arena), ring_(ring) {}

  void move_angle(int angle, const Dag& value) { angles_[angle] = value; }
  void move_symbol(int symbol, const Dag& value) { symbols_[symbol] = value; }

  Dag symbol(int index) {
    const auto moving = symbols_.find(index);
    return moving != symbols_.end() ? moving->second : leaf(ring_.symbol(index).name, false);
  }
  Dag circular(int angle, bool sine) { return unary(sine ? Operation::sine : Operation::cosine, angle_of(angle)); }
  Dag of(const Polynomial& p);
  Dag unary(Operation operation, const Dag& of) {
    const int node = of.node(arena_);
    return {arena_, arena_.make(operation, node, node)};
  }
  Dag root(const Dag& of) { return unary(Operation::root, of); }
  Dag inverse(const Dag& of) { return unary(Operation::inverse, of); }
  Dag leaf(const std::string& name, bool moves) { return {arena_, arena_.leaf(name, moves)}; }

 private:
  Dag angle_of(int angle) {
    const auto moving = angles_.find(angle);
    return moving != angles_.end() ? moving->second : leaf(ring_.angle(angle).name, false);
  }
  Dag wave(const Circular& function);

  Arena& arena_;
  const Ring& ring_;
  std::map<int, Dag> angles_, symbols_;
};

/// Torques of the tree's columns for the states `q[i]`, `dq[i]`, `ddq[i]`; springs included.
std::vector<Dag> torque_program(Arena& arena, Ring& ring, const SymbolicTree& tree);

}  // namespace balance::formulas
