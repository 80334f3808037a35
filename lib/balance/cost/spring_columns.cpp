#include "balance/cost/spring_columns.hpp"

namespace balance {

namespace {

/// End points of a loose spring that are tried: the origin and one on every axis.
template <class S>
constexpr int spring_end_points = S::dimension + 1;

/// End point number i, at the distance `length` from the origin.
Vector3 end_point(int i, double length) { return i == 0 ? Vector3(Vector3::Zero()) : length * Vector3::Unit(i - 1); }

}  // namespace

template <class S>
SpringRegressor<S>::SpringRegressor(const Mechanism& mechanism, const Tree<S>& tree, const FreeSprings& loose)
    : tree_(tree), mechanism_(mechanism), wrenches_(tree.nodes.size()) {
  constexpr Eigen::Index d = S::dimension;
  for (std::size_t s = 0; s < mechanism.springs.size(); ++s) {
    Spring spring = mechanism.springs[s];
    const bool free_ends = s < loose.size() && loose[s];
    forms_.push_back(spring.is_joint_spring() ? SpringKind::in_joint
                     : free_ends              ? SpringKind::loose
                                              : SpringKind::fixed);
    spring.stiffness = 1;
    if (forms_.back() == SpringKind::in_joint) {
      count_ += 2;
      continue;
    }
    if (forms_.back() == SpringKind::fixed) {
      add(spring);
      ++count_;
      continue;
    }
    spring.free_length = 0;
    for (int i = 0; i < spring_end_points<S>; ++i)
      for (int j = 0; j < spring_end_points<S>; ++j) {
        spring.point_first = end_point(i, tree.characteristic_length);
        spring.point_second = end_point(j, tree.characteristic_length);
        add(spring);
      }
    count_ += 1 + 2 * d + d * d;
  }
}

template <class S>
void SpringRegressor<S>::add(const Spring& spring) {
  Mechanism alone;
  alone.springs.push_back(spring);
  units_.emplace_back(alone, tree_);
}

template <class S>
VectorX SpringRegressor<S>::torque_of(const UnitSpring& spring, const TreeState<S>& state) {
  for (auto& wrench : wrenches_) wrench = {};
  Wrench<S> total, loads;
  spring.subtract(state, 0, wrenches_, total, loads);
  VectorX torque(tree_.columns);
  compute_wrench_forces(tree_, state, wrenches_, torque.data());
  return torque;
}

template <class S>
void SpringRegressor<S>::evaluate(const TreeState<S>& state, const double* y, Eigen::Ref<MatrixX> torque) {
  constexpr Eigen::Index d = S::dimension;
  std::size_t unit = 0;
  Eigen::Index column = 0;
  for (std::size_t s = 0; s < forms_.size(); ++s) {
    if (forms_[s] == SpringKind::in_joint) {  // k q − preload
      const LinearQuantity& source = tree_.coordinate_expressions[mechanism_.springs[s].coordinate];
      torque.middleCols(column, 2).setZero();
      source.add_generalised_force(source.value(y), torque.col(column).data());
      source.add_generalised_force(-1, torque.col(column + 1).data());
      column += 2;
      continue;
    }
    if (forms_[s] == SpringKind::fixed) {
      torque.col(column++) = torque_of(units_[unit++], state);
      continue;
    }
    const Eigen::Index width = 1 + 2 * d + d * d;
    loose_at(unit, state, torque.middleCols(column, width));
    unit += spring_end_points<S> * spring_end_points<S>;
    column += width;
  }
}

/// Without a free length the torque is k times a function T(a, b) of the end points that is linear in each of them (the part
/// that is quadratic in one end point is constant in the energy). Its coefficients are differences between unit end points.
template <class S>
void SpringRegressor<S>::loose_at(std::size_t first, const TreeState<S>& state, Eigen::Ref<MatrixX> torque) {
  constexpr Eigen::Index d = S::dimension;
  MatrixX T(tree_.columns, spring_end_points<S> * spring_end_points<S>);
  for (int i = 0; i < spring_end_points<S> * spring_end_points<S>; ++i)
    T.col(i) = torque_of(units_[first + static_cast<std::size_t>(i)], state);
  const auto at = [&](Eigen::Index i, Eigen::Index j) { return T.col(i * spring_end_points<S> + j); };
  const double L = tree_.characteristic_length;
  torque.col(0) = at(0, 0);
  for (Eigen::Index i = 1; i <= d; ++i) {
    torque.col(i) = (at(i, 0) - at(0, 0)) / L;
    torque.col(d + i) = (at(0, i) - at(0, 0)) / L;
    for (Eigen::Index j = 1; j <= d; ++j)
      torque.col(2 * d + (i - 1) * d + j) = (at(i, j) - at(i, 0) - at(0, j) + at(0, 0)) / (L * L);
  }
}

template class SpringRegressor<Planar>;
template class SpringRegressor<Spatial>;

}  // namespace balance
