#include "balance/synthesis/formulas/closed_poses.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <cmath>
#include <numbers>
#include <random>

namespace balance::formulas {

namespace {

/// Redundant closures depend on the others only up to the round-off of the pose.
constexpr double jacobian_rank_threshold = 1e-7;
constexpr int max_closing_steps = 50;
constexpr double closing_step_tolerance = 1e-14, closure_tolerance = 1e-12;
/// Of the engine's pose from the tree's [rad or m].
constexpr double max_pose_difference = 1e-6;
/// Random poses differ from the rough values by up to this [rad or m].
constexpr double max_start_offset = 0.4;
constexpr std::size_t max_attempts_per_pose = 15;

}  // namespace

std::map<std::string, double> evaluate_names(const Ring& ring, const SymbolicEquations& e,
                                             const std::vector<double>& y) {
  std::map<std::string, double> values;
  for (const Symbol& symbol : ring.symbols()) values[symbol.name] = symbol.value;
  for (const Angle& angle : ring.angles()) values[angle.name] = angle.value;
  for (const JointVariable& variable : e.tree.variables) {
    double x = evaluate_polynomial(variable.offset);
    for (const auto& [column, ratio] : variable.follows)
      x += evaluate_polynomial(ratio) * y[static_cast<std::size_t>(column)];
    if (variable.index < 0) continue;
    values[variable.is_angle ? ring.angle(variable.index).name : ring.symbol(variable.index).name] = x;
  }
  for (const AngleRelation& relation : e.tree.relations) {
    double sum = 0;
    for (const auto& [angle, multiple] : relation.multiples) sum += multiple * values[ring.angle(angle).name];
    values[ring.angle(relation.angle).name] = sum;
  }
  PoseValues pose = evaluate_pose(ring, values);
  for (const auto& [symbol, square] : e.lengths)
    values[ring.symbol(symbol).name] = std::sqrt(evaluate_polynomial(square, pose.symbols, pose.angles));
  return values;
}

MatrixX PoseValues::operator()(const Matrix& matrix, Eigen::Index columns) const {
  MatrixX value(static_cast<Eigen::Index>(matrix.size()), columns);
  for (std::size_t i = 0; i < matrix.size(); ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      value(static_cast<Eigen::Index>(i), j) = (*this)(matrix[i][static_cast<std::size_t>(j)]);
  return value;
}

PoseValues evaluate_pose(const Ring& ring, const std::map<std::string, double>& names) {
  PoseValues pose;
  for (const Symbol& symbol : ring.symbols()) pose.symbols.push_back(names.at(symbol.name));
  for (const Angle& angle : ring.angles()) pose.angles.push_back(names.at(angle.name));
  return pose;
}

PoseValues evaluate_pose(const Ring& ring, const SymbolicEquations& e, const VectorX& y) {
  return evaluate_pose(ring, evaluate_names(ring, e, to_list(y)));
}

VectorX rough_pose(const SymbolicTree& tree, const std::vector<CoordinateValue>& values) {
  VectorX y = VectorX::Zero(static_cast<Eigen::Index>(tree.columns.size()));
  for (const CoordinateValue& rough : values)
    for (Eigen::Index c = 0; c < y.size(); ++c)
      if (tree.coordinates[static_cast<std::size_t>(c)] == rough.coordinate) y[c] = rough.value;
  return y;
}

bool close_loops(const Ring& ring, const SymbolicEquations& e, VectorX& y) {
  if (e.closure.empty()) return true;
  VectorX h(static_cast<Eigen::Index>(e.closure.size()));
  const auto evaluate_closures = [&](const PoseValues& pose) {
    for (std::size_t i = 0; i < e.closure.size(); ++i) h[static_cast<Eigen::Index>(i)] = pose(e.closure[i]);
  };
  for (int step = 0; step < max_closing_steps; ++step) {
    const PoseValues pose = evaluate_pose(ring, e, y);
    evaluate_closures(pose);
    numerics::CompleteOrthogonalDecomposition solver;
    solver.setThreshold(jacobian_rank_threshold);
    solver.compute(pose(e.A, y.size()));
    const VectorX newton_step = solver.solve(h);
    y -= newton_step;
    if (numerics::max_abs(newton_step) < closing_step_tolerance) break;
  }
  evaluate_closures(evaluate_pose(ring, e, y));
  return numerics::max_abs(h) < closure_tolerance;
}

std::vector<VectorX> find_closed_poses(const VectorX& rough, std::size_t count, std::uint64_t seed,
                                       const std::function<bool(VectorX&)>& close_loops) {
  std::vector<VectorX> poses;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (std::size_t attempt = 0; attempt < max_attempts_per_pose * count && poses.size() < count; ++attempt) {
    VectorX y = rough;
    for (double& x : y) x += attempt == 0 ? 0 : max_start_offset * uniform(random);
    if (close_loops(y)) poses.push_back(std::move(y));
  }
  return poses;
}

std::optional<VectorX> assemble_engine(InverseDynamics& engine, const Mechanism& mechanism, const SymbolicTree& tree,
                                       const VectorX& q, const VectorX& y) {
  const std::vector<std::string> names = coordinate_names(mechanism, tree);
  std::vector<dynamics::CoordinateGuess> guesses;
  for (std::size_t c = 0; c < names.size(); ++c) guesses.push_back({names[c], y[static_cast<Eigen::Index>(c)]});
  const auto found = engine.assemble(q, guesses);
  if (!found) return std::nullopt;
  for (Eigen::Index c = 0; c < y.size(); ++c) {
    const double deviation = found.value[tree.coordinates[static_cast<std::size_t>(c)]] - y[c];
    if (std::abs(std::remainder(deviation, 2 * std::numbers::pi)) > max_pose_difference) return std::nullopt;
  }
  return found.value;
}

}  // namespace balance::formulas
