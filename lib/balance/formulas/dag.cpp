#include "balance/formulas/dag.hpp"

#include "balance/formulas/rational.hpp"

#include <utility>

namespace balance::formulas {

int Arena::add(DagNode node) {
  if (nodes_.size() >= most_nodes) throw FormulaError("the program is too long");
  nodes_.push_back(std::move(node));
  return static_cast<int>(nodes_.size()) - 1;
}

int Arena::constant(double value) {
  const auto [at, fresh] = constants_.try_emplace(value, 0);
  if (fresh) at->second = add({Operation::constant, 0, 0, value, "", false});
  return at->second;
}

int Arena::leaf(const std::string& name, bool moves) {
  const auto [at, fresh] = leaves_.try_emplace(name, 0);
  if (fresh) at->second = add({Operation::leaf, 0, 0, 0, name, moves});
  return at->second;
}

int Arena::make(Operation operation, int a, int b) {
  if ((operation == Operation::sum || operation == Operation::product) && a > b) std::swap(a, b);
  // nodes are fewer than 2^20
  const auto key =
      static_cast<std::uint64_t>(operation) << 60 | static_cast<std::uint64_t>(a) << 30 | static_cast<std::uint64_t>(b);
  const auto [at, fresh] = known_.try_emplace(key, 0);
  if (fresh) {
    const bool moves = nodes_[static_cast<std::size_t>(a)].moves || nodes_[static_cast<std::size_t>(b)].moves;
    at->second = add({operation, a, b, 0, "", moves});
  }
  return at->second;
}

Dag::Dag(Arena& arena, int node) : arena_(&arena), node_(node) {}

bool Dag::is_negative() const { return arena_ != nullptr && (*arena_)[node_].operation == Operation::negative; }
Dag Dag::opposite() const { return {*arena_, (*arena_)[node_].a}; }

Dag Dag::operator-() const {
  if (arena_ == nullptr) return {-value_};
  const DagNode& self = (*arena_)[node_];
  if (self.operation == Operation::negative) return opposite();
  if (self.operation == Operation::difference) return {*arena_, arena_->make(Operation::difference, self.b, self.a)};
  return {*arena_, arena_->make(Operation::negative, node_, node_)};
}

Dag operator+(const Dag& a, const Dag& b) {
  if (a.is_number() && b.is_number()) return {a.value_ + b.value_};
  if (a.is(0)) return b;
  if (b.is(0)) return a;
  if (b.is_negative()) return a - b.opposite();
  if (a.is_negative()) return b - a.opposite();
  Arena& arena = a.is_number() ? *b.arena_ : *a.arena_;
  return {arena, arena.make(Operation::sum, a.node(arena), b.node(arena))};
}

Dag operator-(const Dag& a, const Dag& b) {
  if (a.is_number() && b.is_number()) return {a.value_ - b.value_};
  if (b.is(0)) return a;
  if (a.is(0)) return -b;
  if (b.is_negative()) return a + b.opposite();
  Arena& arena = a.is_number() ? *b.arena_ : *a.arena_;
  const int left = a.node(arena), right = b.node(arena);
  if (left == right) return {0};
  return {arena, arena.make(Operation::difference, left, right)};
}

Dag operator*(const Dag& a, const Dag& b) {
  if (a.is_number() && b.is_number()) return {a.value_ * b.value_};
  if (a.is(0) || b.is(0)) return {0};
  if (a.is(1)) return b;
  if (b.is(1)) return a;
  if (a.is(-1)) return -b;
  if (b.is(-1)) return -a;
  if (a.is_negative()) return -(a.opposite() * b);
  if (b.is_negative()) return -(a * b.opposite());
  Arena& arena = a.is_number() ? *b.arena_ : *a.arena_;
  return {arena, arena.make(Operation::product, a.node(arena), b.node(arena))};
}

}  // namespace balance::formulas
