#pragma once
/// Efforts and multipliers by the square system of Actuation, with a sample in every lane. Private to lanes.

#include "balance/base/lane_system.hpp"
#include "balance/dynamics/actuation.hpp"

#include <vector>

namespace balance {

/// @tparam L a space over packs
template <class L>
class LaneActuation {
 public:
  using T = typename L::Scalar;

  /// @param scalar regular, and used before
  template <class S>
  explicit LaneActuation(const Actuation<S>& scalar)
      : closures_(scalar.closures_), passive_columns_(scalar.passive_columns_) {
    for (const auto& motor : scalar.actuated_) motors_.push_back({motor.column, motor.ratio, {}});
    for (const auto& entry : scalar.closure_entries_) passive_entries_.push_back({entry.place, entry.index});
    for (std::size_t a = 0; a < scalar.motor_column_entries_.size(); ++a)
      for (const auto& entry : scalar.motor_column_entries_[a]) motors_[a].entries.push_back({entry.place, entry.row});
    SparsityPattern pattern(static_cast<std::size_t>(closures_));
    for (const auto& entry : scalar.closure_entries_) pattern[entry.row].push_back(position(entry.column));
    passive_.analyse(pattern);
    efforts_.assign(motors_.size(), T(0.0));
    multipliers_.assign(static_cast<std::size_t>(closures_), T(0.0));
  }

  /// The matrix before the first lane's, and the order of pivots: those of the scalar one's last.
  template <class S>
  void start(const Actuation<S>& scalar) {
    if (closures_ == 0) return;
    passive_.take_order(scalar.passive_);
    passive_.store(scalar.passive_.storage());
  }

  /// Per lane the smallest pivot; see Actuation::look.
  T factorise(const KinematicEquations<L>& equations) {
    if (closures_ == 0) return 1.0;
    for (const EntryCopy& entry : passive_entries_) passive_.storage()[entry.to] = equations.entry_at(entry.from);
    passive_.factorise();
    return passive_.min_pivot();
  }
  bool near_kept(double limit) { return closures_ == 0 || passive_.is_near_stored(limit); }
  void keep() {
    if (closures_ > 0) passive_.store();
  }

  /// After look(), which found regular matrices. @param tau per tree coordinate
  void solve(const KinematicEquations<L>& equations, const T* tau) {
    const std::vector<double>&columns = equations.column_scale(), &rows = equations.row_scale();
    for (int k = 0; k < closures_; ++k) multipliers_[k] = columns[passive_columns_[k]] * tau[passive_columns_[k]];
    if (closures_ > 0) passive_.solve_transposed(multipliers_.data());
    for (std::size_t a = 0; a < motors_.size(); ++a) {
      const Motor& motor = motors_[a];
      T sum = 0.0;
      for (const EntryCopy& entry : motor.entries) sum += equations.entry_at(entry.from) * multipliers_[entry.to];
      efforts_[a] = (tau[motor.column] - sum / columns[motor.column]) / motor.ratio;
    }
    for (int r = 0; r < closures_; ++r) multipliers_[r] *= rows[r];
  }

  const std::vector<T>& efforts() const { return efforts_; }          ///< per actuator [N m or N]
  const std::vector<T>& multipliers() const { return multipliers_; }  ///< per closure row [N or N m]

 private:
  struct EntryCopy {
    int from;  ///< among the equations' values
    int to;    ///< in the passive matrix, or the row
  };
  struct Motor {
    ColumnId column;
    double ratio;
    std::vector<EntryCopy> entries;
  };

  int position(ColumnId column) const {
    return static_cast<int>(std::find(passive_columns_.begin(), passive_columns_.end(), column) -
                            passive_columns_.begin());
  }

  int closures_;
  std::vector<ColumnId> passive_columns_;
  std::vector<Motor> motors_;
  std::vector<EntryCopy> passive_entries_;
  LaneSquareSystem<T::lanes> passive_;
  std::vector<T> efforts_, multipliers_;
};

}  // namespace balance
