#pragma once
/// What is linear in the tree's coordinates: joint coordinates, the angle of a planar tool. Private to kinematics and the rooms
/// that open it up.

#include "balance/base/id.hpp"

#include <utility>
#include <vector>

namespace balance {

using ColumnId = TypedIndex<struct ColumnList>;  ///< of the tree's coordinates y and of all matrices that go with them

/// Σ coefficient · y[column] + constant.
template <class T>
struct LinearQuantityOf {
  std::vector<std::pair<ColumnId, T>> terms;
  T constant = 0;
  bool is_length = false;

  /// @tparam N T, or several samples' numbers
  template <class N>
  N value(const N* y) const {
    return constant + rate(y);
  }
  /// Of its value, if these are the coordinates' rates; accelerations alike.
  template <class N>
  N rate(const N* dy) const {
    N sum = 0;
    for (const auto& [column, coefficient] : terms) sum += coefficient * dy[column];
    return sum;
  }
  /// Adds the generalised forces of an effort along the quantity: its power is theirs.
  void add_generalised_force(const T& effort, T* tau) const {
    for (const auto& [column, coefficient] : terms) tau[column] += coefficient * effort;
  }
  bool has_terms() const { return !terms.empty(); }
  bool has_single_term() const { return terms.size() == 1; }
  /// It is one of the tree's coordinates itself, not a multiple or a sum.
  bool is_column() const { return terms.size() == 1 && terms[0].second == 1 && constant == 0; }
};

using LinearQuantity = LinearQuantityOf<double>;

}  // namespace balance
