#pragma once
/// The recursions' numbers as nodes of a straight-line program. Private to formulas.

#include "balance/formulas/dag.hpp"
#include "balance/formulas/newton_euler.hpp"

#include <string>
#include <vector>

namespace balance::formulas {

class ProgramFactory {
 public:
  /// @param angles, symbols what stands for those that move; others are leaves
  ProgramFactory(StraightLineProgram& arena, const Ring& ring) : arena_(arena), ring_(ring) {}

  void bind_angle(int angle, const ProgramValue& value) { angles_[angle] = value; }
  void bind_symbol(int symbol, const ProgramValue& value) { symbols_[symbol] = value; }

  ProgramValue symbol(int index) {
    const auto moving = symbols_.find(index);
    return moving != symbols_.end() ? moving->second : leaf(ring_.symbol(index).name, false);
  }
  ProgramValue circular(int angle, bool sine) {
    return unary(sine ? ProgramOperation::sine : ProgramOperation::cosine, angle_of(angle));
  }
  ProgramValue convert(const Polynomial& p);
  ProgramValue unary(ProgramOperation operation, const ProgramValue& of) {
    const int node = of.node(arena_);
    return {arena_, arena_.add_operation(operation, node, node)};
  }
  ProgramValue root(const ProgramValue& of) { return unary(ProgramOperation::root, of); }
  ProgramValue inverse(const ProgramValue& of) { return unary(ProgramOperation::inverse, of); }
  ProgramValue leaf(const std::string& name, bool moves) { return {arena_, arena_.add_input(name, moves)}; }

 private:
  ProgramValue angle_of(int angle) {
    const auto moving = angles_.find(angle);
    return moving != angles_.end() ? moving->second : leaf(ring_.angle(angle).name, false);
  }
  ProgramValue wave(const CircularFunction& function);

  StraightLineProgram& arena_;
  const Ring& ring_;
  std::map<int, ProgramValue> angles_, symbols_;
};

/// Torques of the tree's columns for the states `q[i]`, `dq[i]`, `ddq[i]`; springs included.
std::vector<ProgramValue> build_torque_program(StraightLineProgram& arena, Ring& ring, const SymbolicTree& tree);

}  // namespace balance::formulas
