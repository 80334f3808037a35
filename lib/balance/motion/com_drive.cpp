#include "balance/motion/com_drive.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/kinematics/system.hpp"

#include <cmath>
#include <cstdio>

namespace balance {

namespace {

/// Of the way that the masses go, what their centre may still go and count as standing: below it the equations count as singular
/// anyway (least_regularity), and designs written with a few digits fall under it.
constexpr double standing = 1e-5;

constexpr const char* cure = "; use drive tool or joints";

/// Rates of the centre of mass per unit of each freedom, in units of what they would be if the terms did not cancel.
template <class S>
class ComRates {
 public:
  explicit ComRates(const Tree<S>& tree) : tree_(tree), masses_(tree), state_(tree.nodes.size()) {}

  /// @param freedoms null space of the scaled closures, columns × freedoms
  MatrixX at(const VectorX& y, const MatrixX& freedoms) {
    poses(tree_, y.data(), state_);
    masses_.update(tree_, state_);
    MatrixX gradient = MatrixX::Zero(S::dimension, tree_.columns);
    VectorX size = VectorX::Zero(tree_.columns);
    for (std::size_t k = 1; k < tree_.nodes.size(); ++k) {
      const Node<S>& node = tree_.nodes[k];
      const int n = static_cast<int>(k);
      if (node.motion == NodeMotion::weld) continue;
      const double unit = tree_.column_kind_length[node.column] ? tree_.length : 1;
      gradient.col(node.column) += unit * masses_.com_gradient(node, state_[k], n);
      size[node.column] += unit * std::abs(node.ratio) * reach(n);
    }
    MatrixX rates = gradient * freedoms;
    const VectorX scale = freedoms.cwiseAbs().transpose() * size;
    for (Eigen::Index f = 0; f < rates.cols(); ++f)
      rates.col(f) = scale[f] > 0 ? VectorX(rates.col(f) / scale[f]) : VectorX(VectorX::Zero(S::dimension));
    return rates;
  }

 private:
  /// Σ m |rate of what it carries| / Σ m, per unit of a node's own turn or slide.
  double reach(NodeId moving) const {
    double sum = 0;
    for (std::size_t k = 1; k < tree_.nodes.size(); ++k) {
      if (!carried_by(static_cast<int>(k), moving)) continue;
      const auto& inertia = tree_.nodes[k].inertia;
      sum += tree_.nodes[moving].motion == NodeMotion::slide
                 ? std::abs(inertia.mass)
                 : inertia.moment.norm() + std::abs(inertia.mass) * (state_[k].p_WN - state_[moving].p_WN).norm();
    }
    return sum / tree_.mass;
  }

  bool carried_by(NodeId node, NodeId moving) const {
    while (node > moving) node = tree_.nodes[node].parent;
    return node == moving;
  }

  const Tree<S>& tree_;
  MassDistribution<S> masses_;
  State<S> state_;
};

bool moves_every_way(const MatrixX& rates) {
  if (rates.cols() < rates.rows()) return false;
  return singular_values(rates)[rates.rows() - 1] > standing;
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
std::string com_stands_still(const Tree<S>& tree, const VectorX& y, const std::vector<int>& components) {
  if (components.empty() || tree.columns == 0) return "";
  System<S> closures(tree, Drive<S>{});
  const VectorX scale = column_scale(tree);
  ComRates<S> com(tree);
  const auto asked = [&](const MatrixX& rates) {
    MatrixX rows(static_cast<Eigen::Index>(components.size()), rates.cols());
    for (Eigen::Index k = 0; k < rows.rows(); ++k) rows.row(k) = rates.row(components[static_cast<std::size_t>(k)]);
    return rows;
  };
  MatrixX rates(S::dimension, 0), jacobian;
  bool independent = false;
  VectorX here = y;
  const int generic = generic_closure_rank(tree, y);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    closures.rates(here, {}, jacobian);
    const RankReport loops = rank_of(jacobian);
    if (loops.null_space.cols() == 0) break;
    if (loops.rank == generic) {  // elsewhere it says more than the motion can do
      const MatrixX there = com.at(here, loops.null_space);
      rates.conservativeResize(Eigen::NoChange, rates.cols() + there.cols());
      rates.rightCols(there.cols()) = there;
      independent = independent || moves_every_way(asked(there));
    }
    const VectorX random = random_coordinates(tree, seed).cwiseQuotient(scale);
    const VectorX aside = loops.null_space * (loops.null_space.transpose() * random);
    const Solution moved = solve(closures, here + scale.cwiseProduct(0.2 / std::max(1e-12, aside.norm()) * aside), {});
    if (moved.found) here = moved.y;
  }
  if (rates.cols() == 0) return "";
  if (max_abs(rates) <= standing)
    return std::string("the mechanism is force balanced: its centre of mass stands still and cannot drive it") + cure;
  if (independent) return "";
  if (moves_every_way(asked(rates)))
    return std::string(
               "the centre of mass moves in fewer directions at once than are prescribed of it and cannot drive the "
               "mechanism") +
           cure;
  const SingularValueDecomposition directions(asked(rates), Eigen::ComputeFullU);
  return "the mechanism is force balanced along " + direction_text(components, directions.matrixU().rightCols<1>()) +
         ": its centre of mass does not move in that direction and cannot drive it" + cure;
}

template std::string com_stands_still<Planar>(const Tree<Planar>&, const VectorX&, const std::vector<int>&);
template std::string com_stands_still<Spatial>(const Tree<Spatial>&, const VectorX&, const std::vector<int>&);

}  // namespace balance
