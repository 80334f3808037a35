#include "balance/foundation/base/pack.hpp"
#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/mechanics/lanes/lane_kernels.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

using namespace balance;
using namespace balance::kinematics;
using namespace balance::lanes;

namespace {

using Random = std::mt19937_64;

double number(Random& random) { return std::uniform_real_distribution<double>(-1, 1)(random); }
Vector3 vector(Random& random) { return {number(random), number(random), number(random)}; }

/// Any tree of welds, turns and slides with branches, gears and bodies in general position.
template <class S>
Tree<S> random_tree(Random& random) {
  Tree<S> tree;
  tree.nodes.resize(1);
  const int count = 1 + static_cast<int>(random() % 10);
  for (int n = 1; n <= count; ++n) {
    Node<S> node;
    node.parent = static_cast<int>(random() % n);
    node.motion = static_cast<NodeMotion>(random() % 3);
    if (node.motion != NodeMotion::weld) node.column = tree.columns++;
    if (tree.columns > 1 && random() % 5 == 0) node.column = node.column < 0 ? -1 : 0;  // geared to the first
    node.ratio = 1 + 0.5 * number(random);
    node.offset = number(random);
    const Vector3 axis = is_planar<S> ? Vector3::UnitZ() : Vector3(vector(random).normalized());
    node.R_PF = to_rotation<S>(Eigen::AngleAxisd(3 * number(random), axis).toRotationMatrix());
    node.p_PF = to_vector<S>(vector(random));
    node.massless = random() % 4 == 0;
    if (!node.massless) {
      node.inertia.mass = 2 + number(random);
      node.inertia.first_moment = to_vector<S>(vector(random));
      const Matrix3 half = Matrix3::NullaryExpr([&] { return number(random); });
      if constexpr (is_planar<S>)
        node.inertia.second_moment = 2 + number(random);
      else
        node.inertia.second_moment = half * half.transpose();
    }
    tree.nodes.push_back(node);
  }
  return tree;
}

struct Table {
  std::vector<double> y, dy, ddy, tau;
  Table(int columns, long count, Random& random) : y(columns * count), dy(y), ddy(y), tau(y) {
    for (auto* numbers : {&y, &dy, &ddy})
      for (double& x : *numbers) x = 3 * number(random);
  }
  InverseDynamicsJob job(int columns) {
    return {static_cast<long>(y.size()) / columns, y.data(), dy.data(), ddy.data(), tau.data()};
  }
};

void run(InstructionSet set, const Tree<Planar>& tree, const Vector2& gravity, const InverseDynamicsJob& job) {
  lane_kernels(set).planar_torques(tree, gravity, job);
}
void run(InstructionSet set, const Tree<Spatial>& tree, const Vector3& gravity, const InverseDynamicsJob& job) {
  lane_kernels(set).spatial_torques(tree, gravity, job);
}

template <class S>
void check_torques(std::uint64_t seed) {
  Random random(seed);
  const Tree<S> tree = random_tree<S>(random);
  if (tree.columns == 0) return;
  const typename S::Vector gravity = to_vector<S>(vector(random));
  Table table(tree.columns, 1 + static_cast<long>(random() % 20), random);  // counts that fill no pack
  TreeState<S> state(tree.nodes.size());
  std::vector<dynamics::Wrench<S>> wrenches(tree.nodes.size());
  std::vector<double> scalar(table.tau.size()), baseline;
  for (std::size_t k = 0; k < scalar.size(); k += tree.columns)
    dynamics::open_tree_inverse_dynamics<S>(tree, &table.y[k], &table.dy[k], &table.ddy[k], gravity, state, wrenches,
                                            &scalar[k]);
  double scale = 0;
  for (const double tau : scalar) scale = std::max(scale, std::abs(tau));
  for (const InstructionSet set : list_instruction_sets()) {
    run(set, tree, gravity, table.job(tree.columns));
    double worst = 0;
    for (std::size_t k = 0; k < scalar.size(); ++k) worst = std::max(worst, std::abs(table.tau[k] - scalar[k]));
    CAPTURE(seed);
    CAPTURE(std::string(instruction_set_name(set)));
    CHECK(worst <= 1e-12 * scale);
    if (baseline.empty()) baseline = table.tau;
    CHECK(std::memcmp(baseline.data(), table.tau.data(), baseline.size() * sizeof(double)) == 0);
  }
}

}  // namespace

TEST_CASE("torques in lanes are the recursion's, state by state, and the same bits with every instruction set") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    check_torques<Planar>(seed);
    check_torques<Spatial>(seed);
  }
}

TEST_CASE("an instruction set that is not there is refused") {
  const auto sets = list_instruction_sets();
  for (const InstructionSet set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
    if (std::find(sets.begin(), sets.end(), set) != sets.end())
      CHECK_NOTHROW(lane_kernels(set));
    else
      CHECK_THROWS_AS(lane_kernels(set), std::invalid_argument);
  }
}
