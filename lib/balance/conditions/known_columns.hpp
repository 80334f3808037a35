#pragma once
/// What loads and friction ask of the tree's coordinates, per unit of each known term. Private to conditions.

#include "balance/conditions/known_terms.hpp"
#include "balance/kinematics/state.hpp"

namespace balance {

/// Changes since the first times of all loads' components (columns) at all times of all tables (rows); nothing without tables.
MatrixX load_histories(const Mechanism& mechanism);
/// Column of a load's term there and in load_changes.
Eigen::Index load_component(const Parameter& term, bool planar);

template <class S>
class KnownTermColumns {
 public:
  /// @param mechanism, tree must outlive the columns
  KnownTermColumns(const Mechanism& mechanism, const Tree<S>& tree);

  Eigen::Index size() const { return static_cast<Eigen::Index>(terms_.size()); }
  bool has_loads() const { return !mechanism_.loads.empty(); }
  bool has_changes() const { return changes_.size() > 0; }
  bool has_friction() const { return !mechanism_.friction.empty(); }

  /// Columns of the loads as they are at first and, apart from these, of their changes; velocities in `state` are overwritten.
  void load_columns(TreeState<S>& state, MatrixX& constant, MatrixX& changing) const;
  /// @param dy rates of the tree's coordinates
  MatrixX friction_columns(const VectorX& dy) const;

 private:
  MatrixX load_torques(TreeState<S>& state) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  std::vector<Parameter> terms_;
  MatrixX changes_;  ///< load_changes, where there are any
};

extern template class KnownTermColumns<Planar>;
extern template class KnownTermColumns<Spatial>;

}  // namespace balance
