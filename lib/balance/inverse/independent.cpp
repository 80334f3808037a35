#include "balance/inverse/independent.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/base/nearest.hpp"
#include "balance/motion/missing_start.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance {

int require_coordinate(const Mechanism& mechanism, const std::string& name, const char* what) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    names.push_back(mechanism.coordinates[c].name);
    if (names.back() == name) return static_cast<int>(c);
  }
  const std::string hint = format_nearest_name(name, names);
  throw std::invalid_argument(std::string(what) + ": there is no coordinate '" + name + "'" +
                              (hint.empty() ? "" : "; " + hint));
}

namespace {

constexpr double min_independent_rate =
    1e-6;  // of a coordinate's rate, in radians or characteristic lengths per unit of all coordinates

/// The loops of a compiled mechanism, and the velocities that they allow at some of its configurations.
template <class S>
struct SampledLoopVelocities {
  Tree<S> tree;
  std::vector<CoordinateId> needed;  ///< it was compiled with
  int freedoms = 0;
  std::vector<MatrixX>
      velocities;  ///< scaled columns × freedoms; the first one where the mechanism assembles, if it is generic
};

/// Looks on at configurations near by: the first one may be singular by accident.
template <class S>
void sample_configurations(const VectorX& start, SampledLoopVelocities<S>& loops) {
  ConstraintSystem<S> closures(loops.tree, Drive<S>{});
  const VectorX scale = column_scale(loops.tree);
  VectorX here = start;
  MatrixX jacobian;
  for (std::uint64_t seed = 0; seed <= 4; ++seed) {
    closures.velocity_jacobian(here, {}, jacobian);
    const MatrixX allowed = decompose_rank(jacobian).null_space;
    if (allowed.cols() == loops.freedoms) loops.velocities.push_back(allowed);
    const VectorX random = random_coordinates(loops.tree, seed + 1).cwiseQuotient(scale);
    const VectorX aside = allowed * (allowed.transpose() * random);
    if (aside.norm() < 1e-12) return;
    const AssemblySolution moved = solve_assembly(closures, here + scale.cwiseProduct(0.2 / aside.norm() * aside), {});
    if (moved.found) here = moved.y;
  }
}

template <class S>
SampledLoopVelocities<S> sample_loop_velocities(const Mechanism& mechanism, const std::vector<CoordinateId>& needed) {
  SampledLoopVelocities<S> loops{compile_tree<S>(mechanism, needed), needed, 0, {}};
  ConstraintSystem<S> closures(loops.tree, Drive<S>{});
  const AssemblySolution start = solve_pose(mechanism, loops.tree, closures, {});
  if (!start.found) throw UnsolvableMechanism(explain_assembly_failure(mechanism, loops.tree, start, {}));
  loops.freedoms = loops.tree.columns - find_generic_closure_rank(loops.tree, start.y);
  sample_configurations(start.y, loops);
  return loops;
}

/// Rates of coordinates, in their units, per unit of each allowed velocity; a coordinate that is none of the tree's has none.
template <class S>
MatrixX compute_coordinate_rates(const Tree<S>& tree, const std::vector<CoordinateId>& coordinates,
                                 const MatrixX& velocities) {
  MatrixX rates = MatrixX::Zero(static_cast<Eigen::Index>(coordinates.size()), velocities.cols());
  const VectorX scale = column_scale(tree);
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    const LinearQuantity& source = tree.coordinate_expressions[coordinates[k]];
    for (const auto& [column, ratio] : source.terms)
      rates.row(static_cast<Eigen::Index>(k)) +=
          ratio * scale[column] / (source.is_length ? tree.characteristic_length : 1) * velocities.row(column);
  }
  return rates;
}

template <class S>
bool can_determine_motion(const SampledLoopVelocities<S>& loops, const std::vector<CoordinateId>& coordinates) {
  if (static_cast<int>(coordinates.size()) != loops.freedoms) return false;
  if (loops.freedoms == 0) return true;
  return std::any_of(loops.velocities.begin(), loops.velocities.end(), [&](const MatrixX& velocities) {
    const MatrixX rates = compute_coordinate_rates(loops.tree, coordinates, velocities);
    return singular_values(rates)[loops.freedoms - 1] > min_independent_rate;
  });
}

/// Takes what independent rates a coordinate still has out of all others'.
void project_out(MatrixX& rates, Eigen::Index row) {
  const VectorX direction = rates.row(row).transpose().normalized();
  rates -= rates * direction * direction.transpose();
}

/// Actuated coordinates in their order, then those with the largest rates; floating ones only if there are no others.
template <class S>
std::vector<CoordinateId> pick_independent(const Mechanism& mechanism, const SampledLoopVelocities<S>& loops) {
  std::vector<CoordinateId> all(mechanism.coordinates.size()), chosen;
  for (std::size_t c = 0; c < all.size(); ++c) all[c] = static_cast<int>(c);
  if (loops.velocities.empty()) return chosen;
  MatrixX rates = compute_coordinate_rates(loops.tree, all, loops.velocities.front());
  const auto take = [&](CoordinateId coordinate) {
    project_out(rates, coordinate);
    chosen.push_back(coordinate);
  };
  const auto missing = [&] { return static_cast<int>(chosen.size()) < loops.freedoms; };
  for (const CoordinateId coordinate : mechanism.actuators)
    if (missing() && rates.row(coordinate).norm() > min_independent_rate) take(coordinate);
  for (const bool floating : {false, true})
    while (missing()) {
      int best = -1;
      for (const int c : all)
        if (loops.tree.is_floating[c] == floating && rates.row(c).norm() > min_independent_rate &&
            (best < 0 || rates.row(c).norm() > (1 + 1e-9) * rates.row(best).norm()))
          best = c;
      if (best < 0) break;
      take(best);
    }
  return chosen;
}

template <class S>
bool has_floating(const Tree<S>& tree, const std::vector<CoordinateId>& coordinates) {
  return std::any_of(coordinates.begin(), coordinates.end(), [&](int c) { return tree.is_floating[c]; });
}

std::string list_names(const Mechanism& mechanism, const std::vector<CoordinateId>& coordinates) {
  std::string text;
  for (const int c : coordinates) text += (text.empty() ? "" : ", ") + mechanism.coordinates[c].name;
  return text;
}

std::vector<CoordinateId> find_named_coordinates(const Mechanism& mechanism, const std::vector<std::string>& names) {
  std::vector<CoordinateId> coordinates;
  for (const std::string& name : names) {
    coordinates.push_back(require_coordinate(mechanism, name, "independent"));
    if (std::count(coordinates.begin(), coordinates.end(), coordinates.back()) > 1)
      throw std::invalid_argument("independent: '" + name + "' is named twice");
  }
  return coordinates;
}

template <class S>
IndependentCoordinates<S> make_independent_coordinates(SampledLoopVelocities<S>&& loops,
                                                       std::vector<CoordinateId> coordinates, std::string note) {
  const bool redundant = loops.tree.closure_rows > loops.tree.columns - loops.freedoms;
  return {std::move(loops.tree), std::move(loops.needed), std::move(coordinates), loops.freedoms, redundant,
          std::move(note)};
}

template <class S>
IndependentCoordinates<S> use_named(const Mechanism& mechanism, const std::vector<CoordinateId>& coordinates) {
  SampledLoopVelocities<S> loops = sample_loop_velocities<S>(mechanism, coordinates);
  const std::string list = list_names(mechanism, coordinates);
  if (static_cast<int>(coordinates.size()) != loops.freedoms)
    throw std::invalid_argument("independent: " + std::to_string(coordinates.size()) + " coordinates (" + list +
                                ") for " + std::to_string(loops.freedoms) + " degrees of freedom");
  if (!can_determine_motion(loops, coordinates))
    throw std::invalid_argument("independent: " + list + " do not determine the other coordinates");
  return make_independent_coordinates(std::move(loops), coordinates, "");
}

}  // namespace

template <class S>
IndependentCoordinates<S> choose_independent_coordinates(const Mechanism& mechanism,
                                                         const std::vector<std::string>& names) {
  if (!names.empty()) return use_named<S>(mechanism, find_named_coordinates(mechanism, names));
  std::vector<CoordinateId> coordinates;
  for (int rounds = 0; rounds < 4; ++rounds) {
    SampledLoopVelocities<S> loops = sample_loop_velocities<S>(mechanism, coordinates);
    if (rounds == 0 && can_determine_motion(loops, mechanism.actuators))
      return make_independent_coordinates(std::move(loops), mechanism.actuators, "");
    coordinates = pick_independent(mechanism, loops);
    // what is needed does not float: a spin that was held as idle may become a freedom then
    const bool stands = !has_floating(loops.tree, coordinates);
    if (stands && can_determine_motion(loops, coordinates)) {
      const std::string note = "independent coordinates: " + list_names(mechanism, coordinates);
      return make_independent_coordinates(std::move(loops), coordinates, note);
    }
  }
  throw UnsolvableMechanism({MotionStatus::mismatch, 0, "no joint coordinates determine the motion", {}});
}

template IndependentCoordinates<Planar> choose_independent_coordinates<Planar>(const Mechanism&,
                                                                               const std::vector<std::string>&);
template IndependentCoordinates<Spatial> choose_independent_coordinates<Spatial>(const Mechanism&,
                                                                                 const std::vector<std::string>&);

}  // namespace balance
