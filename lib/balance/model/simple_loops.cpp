#include "balance/model/simple_loops.hpp"

#include <algorithm>

namespace balance {

namespace {

/// Walks from one body after the other, over later bodies only, so that every loop is met at its earliest body.
class SimpleLoopEnumerator {
 public:
  explicit SimpleLoopEnumerator(const Mechanism& mechanism)
      : mechanism_(mechanism), taken_(mechanism.bodies.size(), false) {}

  /// All loops of so many joints.
  void list(std::size_t length, std::size_t most, std::vector<SimpleLoop>& loops) {
    for (BodyId body = 0; body < static_cast<int>(mechanism_.bodies.size()); ++body)
      extend_path(body, body, length, most, loops);
  }
  bool is_budget_exhausted() const { return steps_ > max_search_steps; }

 private:
  static constexpr long max_search_steps = 200000;  ///< of the whole search, which grows exponentially

  void extend_path(int start, int here, std::size_t length, std::size_t most, std::vector<SimpleLoop>& loops) {
    if (way_.size() == length || loops.size() >= most || ++steps_ > max_search_steps) return;
    for (int j = 0; j < static_cast<int>(mechanism_.joints.size()); ++j) {
      const Joint& joint = mechanism_.joints[j];
      if (joint.first != here && joint.second != here) continue;
      const int there = joint.first == here ? joint.second : joint.first;
      const auto same = [j](const LoopStep& step) { return step.joint == j; };
      if (there < start || taken_[there] || std::any_of(way_.begin(), way_.end(), same)) continue;
      way_.push_back({j, joint.first == here});
      if (there != start) {
        taken_[there] = true;
        extend_path(start, there, length, most, loops);
        taken_[there] = false;
      } else if (way_.size() == length && way_.front().joint < j && loops.size() < most) {  // of the two directions one
        loops.push_back(way_);
      }
      way_.pop_back();
    }
  }

  const Mechanism& mechanism_;
  std::vector<bool> taken_;
  SimpleLoop way_;
  long steps_ = 0;
};

}  // namespace

std::vector<SimpleLoop> list_simple_loops(const Mechanism& mechanism, std::size_t most) {
  SimpleLoopEnumerator walk(mechanism);
  std::vector<SimpleLoop> loops;
  for (std::size_t length = 2; length <= mechanism.bodies.size() && loops.size() < most && !walk.is_budget_exhausted();
       ++length)
    walk.list(length, most, loops);
  return loops;
}

}  // namespace balance
