#include "balance/kinematics/assembly_modes.hpp"

#include "balance/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace balance {

namespace {

constexpr double mode_distance_tolerance = 1e-4;  // radians or characteristic lengths
constexpr int max_mode_iterations = 60;
constexpr std::uint64_t first_mode_seed = 1000;  // the first seeds are those of the search for the selected mode

/// @param scale what counts as one: a radian, the characteristic length
/// @param unit what the spec tells it in
std::string rounded_value_text(double value, double scale, double unit) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", std::abs(value) < 1e-6 * scale ? 0.0 : value / unit);
  return text;
}

template <class S>
bool is_given_by_pose(const Tree<S>& tree, const Drive<S>& drive, CoordinateId coordinate) {
  const LinearQuantity& source = tree.coordinate_expressions[coordinate];
  return std::any_of(drive.linear.begin(), drive.linear.end(), [&](const LinearQuantity& quantity) {
    return quantity.has_single_term() && source.has_single_term() && quantity.terms[0].first == source.terms[0].first;
  });
}

bool is_follower(const Mechanism& mechanism, CoordinateId coordinate) {
  return std::any_of(mechanism.couplings.begin(), mechanism.couplings.end(),
                     [&](const Coupling& coupling) { return coupling.follower == coordinate; });
}

}  // namespace

template <class S>
AssemblyModes<S>::AssemblyModes(const Mechanism& mechanism, const Tree<S>& tree, ConstraintSystem<S>& system,
                                const DriveSample& target, const VectorX& selected)
    : mechanism_(mechanism),
      tree_(tree),
      system_(system),
      target_(target),
      modes_{compute_coordinates(mechanism, tree, selected)} {}

template <class S>
long AssemblyModes<S>::search_from(std::uint64_t start) {
  const AssemblySolution other =
      solve_assembly(system_, random_coordinates(tree_, first_mode_seed + start), target_, max_mode_iterations);
  if (other.found) {
    std::vector<double> mode = compute_coordinates(mechanism_, tree_, other.y);
    if (std::none_of(modes_.begin(), modes_.end(), [&](const auto& known) { return is_same_mode(known, mode); }))
      modes_.push_back(std::move(mode));
  }
  return static_cast<long>(other.iterations) * tree_.columns;
}

template <class S>
bool AssemblyModes<S>::is_same_mode(const std::vector<double>& a, const std::vector<double>& b) const {
  for (std::size_t c = 0; c < a.size(); ++c) {
    const bool angle = mechanism_.coordinates[c].kind == CoordinateKind::angle;
    const double off = angle ? unwrap_angle(a[c], b[c]) - b[c] : (a[c] - b[c]) / tree_.characteristic_length;
    if (std::abs(off) > mode_distance_tolerance) return false;
  }
  return true;
}

template <class S>
std::string format_assembly_line(const Mechanism& mechanism, const Tree<S>& tree, const Drive<S>& drive,
                                 const std::vector<double>& mode) {
  std::string line;
  for (std::size_t c = 0; c < mode.size(); ++c) {
    const auto coordinate = static_cast<int>(c);
    if (!tree.coordinate_expressions[c].has_terms() || is_given_by_pose(tree, drive, coordinate) ||
        is_follower(mechanism, coordinate))
      continue;
    const bool length = mechanism.coordinates[c].kind == CoordinateKind::length;
    line += (line.empty() ? "" : ", ") + mechanism.coordinates[c].name + ": " +
            rounded_value_text(mode[c], length ? tree.characteristic_length : 1,
                               length ? mechanism.units.length : mechanism.units.angle);
  }
  return "assembly: {" + line + "}";
}

#define BALANCE_DEFINE(S)                                                                         \
  template class AssemblyModes<S>;                                                                \
  template std::string format_assembly_line<S>(const Mechanism&, const Tree<S>&, const Drive<S>&, \
                                               const std::vector<double>&);
BALANCE_DEFINE(Planar)
BALANCE_DEFINE(Spatial)
#undef BALANCE_DEFINE

}  // namespace balance
