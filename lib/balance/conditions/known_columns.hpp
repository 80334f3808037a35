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
class KnownColumns {
 public:
  /// @param mechanism, tree must outlive the columns
  KnownColumns(const Mechanism& mechanism, const Tree<S>& tree);

  Eigen::Index size() const { return static_cast<Eigen::Index>(terms_.size()); }
  bool has_loads() const { return !mechanism_.loads.empty(); }
  bool has_changes() const { return changes_.size() > 0; }
  bool has_friction() const { return !mechanism_.friction.empty(); }

  /// Columns of the loads as they are at first and, apart from these, of their changes; velocities in `state` are overwritten.
  void loads(State<S>& state, MatrixX& constant, MatrixX& changing) const;
  /// @param dy rates of the tree's coordinates
  MatrixX friction(const VectorX& dy) const;

 private:
  MatrixX load_torques(State<S>& state) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  std::vector<Parameter> terms_;
  MatrixX changes_;  ///< load_changes, where there are any
};

extern template class KnownColumns<Planar>;
extern template class KnownColumns<Spatial>;

}  // namespace balance
