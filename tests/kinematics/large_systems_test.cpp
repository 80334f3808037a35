// Large systems are stored and solved as sparse ones: the same answers as of dense matrices.

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace balance;
using namespace balance::kinematics;

namespace {

constexpr double tilt = 1.2;

Joint pin(const std::string& name, int first, int second, const Vector3& P, const Vector3& Q) {
  Joint joint;
  joint.name = name;
  joint.first = first, joint.second = second, joint.point_first = P, joint.point_second = Q;
  return joint;
}

/// Four-bars in a row, the rocker of each the crank of the next; the tool is on the last rocker.
Mechanism ladder(int loops) {
  const double crank = 0.2, base = 0.3;
  Mechanism m;
  m.bodies.resize(static_cast<std::size_t>(2 * loops + 2));
  m.bodies[0].name = "ground";
  for (std::size_t b = 1; b < m.bodies.size(); ++b) {
    m.bodies[b].name = "body" + std::to_string(b);
    m.bodies[b].mass = 1;
    m.bodies[b].com = {0.1, 0.02, 0};
    m.bodies[b].inertia(2, 2) = 0.01;
  }
  m.joints.push_back(pin("G0", 0, 1, Vector3::Zero(), Vector3::Zero()));
  m.assembly.push_back({0, tilt});
  for (int k = 1; k <= loops; ++k) {
    const int before = k == 1 ? 1 : 2 * k - 1, coupler = 2 * k, rocker = 2 * k + 1;
    m.joints.push_back(pin("G" + std::to_string(k), 0, rocker, {k * base, 0, 0}, Vector3::Zero()));
    m.joints.push_back(pin("C" + std::to_string(k), before, coupler, {crank, 0, 0}, Vector3::Zero()));
    m.joints.push_back(pin("D" + std::to_string(k), coupler, rocker, {base, 0, 0}, {crank, 0, 0}));
    m.assembly.push_back({3 * k - 2, tilt});
    m.assembly.push_back({3 * k - 1, -tilt});
  }
  m.coordinates = list_coordinates(m.space, m.joints);
  m.actuators = {0};
  m.tool = Tool{2 * loops + 1, "", {crank, 0, 0}};
  return m;
}

/// Where all four-bars are parallelograms.
VectorX parallel(const Mechanism& m, const Tree<Planar>& tree, double angle) {
  VectorX y = VectorX::Zero(tree.columns);
  for (const CoordinateValue& rough : m.assembly) {
    REQUIRE(tree.coordinate_expressions[rough.coordinate].has_terms());
    y[tree.coordinate_expressions[rough.coordinate].terms[0].first] = rough.value > 0 ? angle : -angle;
  }
  return y;
}

}  // namespace

TEST_CASE("the sparse matrix of all equations is the dense one") {
  const Mechanism m = ladder(12);
  const Tree<Planar> tree = compile_tree<Planar>(m, {});
  Drive<Planar> drive;
  set_tool_frame(m, tree, drive);
  drive.point = {0, 1};
  drive.com = {0, 1};
  drive.linear = {find_coordinate_expression(m, tree, 0)};
  ConstraintSystem<Planar> system(tree, drive);
  trajectory::DriveSample target;
  target.value = VectorX::LinSpaced(5, 0.1, 0.9);
  VectorX y = parallel(m, tree, tilt), residual, other;
  y += 0.1 * VectorX::Random(y.size());
  MatrixX dense;
  numerics::SparseMatrix sparse;
  system.evaluate(y, target, residual, dense);
  system.evaluate(y, target, other, sparse);
  CHECK(residual == other);
  CHECK((MatrixX(sparse) - dense).cwiseAbs().maxCoeff() <= 1e-15 * dense.cwiseAbs().maxCoeff());
}

TEST_CASE("twice as many loops have twice as many numbers to be stored and worked on") {
  const auto numbers = [](int loops) {
    const Mechanism m = ladder(loops);
    const Tree<Planar> tree = compile_tree<Planar>(m, {});
    ConstraintSystem<Planar> closures(tree, Drive<Planar>{});
    VectorX residual;
    numerics::SparseMatrix jacobian;
    closures.evaluate(parallel(m, tree, tilt), {}, residual, jacobian);
    return static_cast<double>(jacobian.nonZeros());
  };
  CHECK(numbers(200) <= 2.02 * numbers(100));
  CHECK(numbers(400) <= 2.02 * numbers(200));
}

TEST_CASE(
    "a large row of loops is assembled where every parallelogram closes, and has full rank as singular values say") {
  for (const int loops : {20, 40}) {  // 41 coordinates are solved for as dense, 81 as sparse
    const Mechanism m = ladder(loops);
    const Tree<Planar> tree = compile_tree<Planar>(m, {});
    trajectory::PoseTarget pose;
    pose.joints = {{0, 1.3}};
    const PoseEquations<Planar> from = make_pose_equations(m, tree, pose);
    ConstraintSystem<Planar> system(tree, from.drive);
    const AssemblySolution found = solve_pose(m, tree, system, from.target);
    REQUIRE(found.found);
    CHECK((found.y - parallel(m, tree, 1.3)).cwiseAbs().maxCoeff() < 1e-10);
    ConstraintSystem<Planar> closures(tree, Drive<Planar>{});
    VectorX residual;
    MatrixX jacobian;
    closures.evaluate(found.y, {}, residual, jacobian);
    CHECK(find_generic_closure_rank(tree, found.y) == decompose_rank(jacobian).rank);
  }
}

TEST_CASE("a large row of loops with a rod too many has a rank that is one short") {
  Mechanism m = ladder(26);
  m.bodies.push_back(m.bodies[2]);  // beside the first coupler, as long as it
  const int rod = static_cast<int>(m.bodies.size()) - 1;
  m.joints.push_back(pin("E", 1, rod, {0.1, 0, 0}, Vector3::Zero()));
  m.joints.push_back(pin("F", rod, 3, {0.3, 0, 0}, {0.1, 0, 0}));
  m.coordinates = list_coordinates(m.space, m.joints);
  m.assembly.push_back({static_cast<int>(m.coordinates.size()) - 2, -tilt});
  const Tree<Planar> tree = compile_tree<Planar>(m, {});
  REQUIRE(tree.columns > numerics::max_dense_columns);
  const VectorX y = parallel(m, tree, tilt);
  CHECK(find_generic_closure_rank(tree, y) == tree.closure_rows - 1);
}

TEST_CASE(
    "how far a large mechanism is from a singular configuration is reported by sparse factors as by singular values") {
  const Mechanism m = ladder(40);
  const Tree<Planar> tree = compile_tree<Planar>(m, {});
  Drive<Planar> drive;
  drive.linear = {find_coordinate_expression(m, tree, 0)};
  KinematicEquations<Planar> equations(tree, drive, false);
  dynamics::Actuation<Planar> actuation(m, tree, 1);
  TreeState<Planar> state(tree.nodes.size());
  trajectory::DriveSample target;
  std::vector<double> residual(static_cast<std::size_t>(tree.columns));
  for (const double angle : {1.2, 0.6, 0.01}) {  // flat, all of them are singular
    const VectorX y = parallel(m, tree, angle);
    target.value = VectorX::Constant(1, angle);
    compute_poses(tree, y.data(), state);
    equations.evaluate(state, y.data(), target, residual.data());
    REQUIRE(equations.factorise());
    const double expected = Eigen::JacobiSVD<MatrixX>(equations.dense()).singularValues()[tree.columns - 1];
    CHECK(equations.min_singular_value() == doctest::Approx(expected).epsilon(1e-8));
    CHECK(equations.distance_to_singularity() == doctest::Approx(expected).epsilon(1e-8));
    CHECK(actuation.mobility(equations) == doctest::Approx(expected).epsilon(1e-8));  // the motor is what is driven
  }
}

TEST_CASE("the characteristic length is the largest distance of any two places of a body") {
  Mechanism m = ladder(3);
  CHECK(characteristic_length(m) == doctest::Approx(0.9).epsilon(1e-14));
  for (int k = 0; k < 300; ++k)
    m.bodies[0].points.push_back({"p", {std::cos(0.37 * k) * (1 + k % 7), std::sin(0.53 * k) * (1 + k % 5), 0}});
  double largest = 0;
  for (const model::NamedPoint& p : m.bodies[0].points)
    for (const model::NamedPoint& q : m.bodies[0].points) largest = std::max(largest, (p.position - q.position).norm());
  CHECK(characteristic_length(m) == largest);
}
