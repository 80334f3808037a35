#include "balance/motion/com_drive.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/kinematics/system.hpp"

#include <cmath>
#include <cstdio>

namespace balance {

namespace {

/// Of the way that the masses go, what their centre may still go and count as standing: below it the equations count as singular
/// anyway (singular_pivot_threshold), and designs written with a few digits fall under it.
constexpr double static_com_tolerance = 1e-5;

constexpr const char* drive_hint = "; use drive tool or joints";

/// Rates of the centre of mass per unit of each freedom, in units of what they would be if the terms did not cancel.
template <class S>
class ScaledComJacobian {
 public:
  explicit ScaledComJacobian(const Tree<S>& tree) : tree_(tree), masses_(tree), state_(tree.nodes.size()) {}

  /// @param freedoms null space of the scaled closures, columns × freedoms
  MatrixX at(const VectorX& y, const MatrixX& freedoms) {
    compute_poses(tree_, y.data(), state_);
    masses_.update(tree_, state_);
    MatrixX gradient = MatrixX::Zero(S::dimension, tree_.columns);
    VectorX size = VectorX::Zero(tree_.columns);
    for (std::size_t k = 1; k < tree_.nodes.size(); ++k) {
      const Node<S>& node = tree_.nodes[k];
      const int n = static_cast<int>(k);
      if (node.motion == NodeMotion::weld) continue;
      const double unit = tree_.is_length_column[node.column] ? tree_.characteristic_length : 1;
      gradient.col(node.column) += unit * masses_.com_gradient(node, state_[k], n);
      size[node.column] += unit * std::abs(node.ratio) * mass_weighted_arm(n);
    }
    MatrixX rates = gradient * freedoms;
    const VectorX scale = freedoms.cwiseAbs().transpose() * size;
    for (Eigen::Index f = 0; f < rates.cols(); ++f)
      rates.col(f) = scale[f] > 0 ? VectorX(rates.col(f) / scale[f]) : VectorX(VectorX::Zero(S::dimension));
    return rates;
  }

 private:
  /// Σ m |rate of what it carries| / Σ m, per unit of a node's own turn or slide.
  double mass_weighted_arm(NodeId moving) const {
    double sum = 0;
    for (std::size_t k = 1; k < tree_.nodes.size(); ++k) {
      if (!is_descendant_of(static_cast<int>(k), moving)) continue;
      const auto& inertia = tree_.nodes[k].inertia;
      sum += tree_.nodes[moving].motion == NodeMotion::prismatic
                 ? std::abs(inertia.mass)
                 : inertia.first_moment.norm() + std::abs(inertia.mass) * (state_[k].p_WN - state_[moving].p_WN).norm();
    }
    return sum / tree_.mass;
  }

  bool is_descendant_of(NodeId node, NodeId moving) const {
    while (node > moving) node = tree_.nodes[node].parent;
    return node == moving;
  }

  const Tree<S>& tree_;
  MassDistribution<S> masses_;
  TreeState<S> state_;
};

bool has_full_row_rank(const MatrixX& rates) {
  if (rates.cols() < rates.rows()) return false;
  return singular_values(rates)[rates.rows() - 1] > static_com_tolerance;
}

std::string direction_text(const std::vector<int>& components, VectorX direction) {
  const Eigen::Index largest = max_index(direction.cwiseAbs());
  if (std::abs(direction[largest]) > 1 - 1e-9)
    return std::string(1, "xyz"[components[static_cast<std::size_t>(largest)]]);
  direction *= direction[largest] > 0 ? 1 : -1;
  Vector3 all = Vector3::Zero();
  for (Eigen::Index k = 0; k < direction.size(); ++k) all[components[static_cast<std::size_t>(k)]] = direction[k];
  char text[80];
  std::snprintf(text, sizeof text, "[%.4g, %.4g, %.4g]", all[0], all[1], all[2]);
  return text;
}

}  // namespace

template <class S>
std::string check_com_mobility(const Tree<S>& tree, const VectorX& y, const std::vector<int>& components) {
  if (components.empty() || tree.columns == 0) return "";
  ConstraintSystem<S> closures(tree, Drive<S>{});
  const VectorX scale = column_scale(tree);
  ScaledComJacobian<S> com(tree);
  const auto asked = [&](const MatrixX& rates) {
    MatrixX rows(static_cast<Eigen::Index>(components.size()), rates.cols());
    for (Eigen::Index k = 0; k < rows.rows(); ++k) rows.row(k) = rates.row(components[static_cast<std::size_t>(k)]);
    return rows;
  };
  MatrixX rates(S::dimension, 0), jacobian;
  bool independent = false;
  VectorX here = y;
  const int generic = find_generic_closure_rank(tree, y);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    closures.velocity_jacobian(here, {}, jacobian);
    const RankDecomposition loops = decompose_rank(jacobian);
    if (loops.null_space.cols() == 0) break;
    if (loops.rank == generic) {  // elsewhere it says more than the motion can do
      const MatrixX there = com.at(here, loops.null_space);
      rates.conservativeResize(Eigen::NoChange, rates.cols() + there.cols());
      rates.rightCols(there.cols()) = there;
      independent = independent || has_full_row_rank(asked(there));
    }
    const VectorX random = random_coordinates(tree, seed).cwiseQuotient(scale);
    const VectorX aside = loops.null_space * (loops.null_space.transpose() * random);
    const AssemblySolution moved =
        solve_assembly(closures, here + scale.cwiseProduct(0.2 / std::max(1e-12, aside.norm()) * aside), {});
    if (moved.found) here = moved.y;
  }
  if (rates.cols() == 0) return "";
  if (max_abs(rates) <= static_com_tolerance)
    return std::string("the mechanism is force balanced: its centre of mass stands still and cannot drive it") +
           drive_hint;
  if (independent) return "";
  if (has_full_row_rank(asked(rates)))
    return std::string(
               "the centre of mass moves in fewer directions at once than are prescribed of it and cannot drive the "
               "mechanism") +
           drive_hint;
  const SingularValueDecomposition directions(asked(rates), Eigen::ComputeFullU);
  return "the mechanism is force balanced along " + direction_text(components, directions.matrixU().rightCols<1>()) +
         ": its centre of mass does not move in that direction and cannot drive it" + drive_hint;
}

template std::string check_com_mobility<Planar>(const Tree<Planar>&, const VectorX&, const std::vector<int>&);
template std::string check_com_mobility<Spatial>(const Tree<Spatial>&, const VectorX&, const std::vector<int>&);

}  // namespace balance
