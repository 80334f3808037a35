#include "balance/synthesis/certificate/length_geometry.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/certificate/linkage_check.hpp"
#include "balance/synthesis/certificate/special_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace balance::certificate {
namespace {

/// Relative to the fixed masses' terms: residuals of conditions that count as met.
constexpr double residual_tolerance = 1e-10;
/// Of the largest polynomial: programs with more take longer than they are worth.
constexpr Eigen::Index max_coefficients = 1100;
/// With more lengths, polynomials of moments have too many coefficients in any case.
constexpr int max_moment_lengths = 8;

/// Free numbers that the links, their masses and their places depend on.
int count_lengths(const PlanarLinkage& linkage) {
  int count = 0;
  for (int number = 0; number < linkage.variables; ++number) {
    const auto varies = [&](const VectorSum& sum) {
      return std::any_of(sum.begin(), sum.end(), [&](const auto& term) { return term.second.has_variable(number); });
    };
    const bool occurs = std::any_of(linkage.closures.begin(), linkage.closures.end(),
                                    [&](const LoopClosure& closure) { return varies(closure.links); }) ||
                        std::any_of(linkage.tree_joints.begin(), linkage.tree_joints.end(), varies) ||
                        std::any_of(linkage.masses.begin(), linkage.masses.end(), [&](const CarriedMass& carried) {
                          return carried.place.has_variable(number) || carried.mass.has_variable(number);
                        });
    count += occurs ? 1 : 0;
  }
  return count;
}

class GeometryLister {
 public:
  GeometryLister(const DesignSpace& space, const std::vector<int>& required_trajectories)
      : space_(space), required_trajectories_(required_trajectories) {}

  /// @param has_moments whether the conditions of moments are included, if the goals require them
  LengthGeometries list(bool has_moments) {
    const LengthBox box = list_number_bounds(space_);
    if (!box.lower.allFinite() || !box.upper.allFinite()) {
      result_.reason = "a free number has no bounds";
      return std::move(result_);
    }
    LinkageReading reading = read_linkage(space_, {}, has_moments);
    if (result_.reason = reading.reason; !reading.linkage) return std::move(result_);
    SpecialGeometries special = find_special_geometries(*reading.linkage, box);
    result_.uncovered = std::move(special.uncovered);
    result_.reason = add(general_lengths_name, {}, std::move(*reading.linkage), nullptr, box);
    if (!result_.reason.empty()) return std::move(result_);
    for (const SpecialGeometry& geometry : special.geometries) {
      LinkageReading own = read_linkage(space_, geometry.substitution);  // whose moments have further relations
      if (!own.linkage ||
          !add(geometry.name, geometry.substitution, std::move(*own.linkage), &geometry, geometry.box).empty())
        result_.uncovered.push_back(geometry.name);
    }
    check_geometries();
    return std::move(result_);
  }

 private:
  /// @param special null for general lengths
  /// @return why it cannot be bounded; empty if it was added
  std::string add(const std::string& name, const LengthSubstitution& substitution, PlanarLinkage linkage,
                  const SpecialGeometry* special, const LengthBox& box) {
    if (linkage.counterweights.empty()) return "no counterweight is free";
    LengthGeometry geometry;
    geometry.name = name;
    geometry.substitution = substitution;
    geometry.box = box;
    geometry.conditions = list_assembly_conditions(space_, linkage, required_trajectories_, box);
    if (special != nullptr) {
      geometry.conditions.insert(geometry.conditions.begin(), special->equalities.begin(), special->equalities.end());
      linkage.closures = special->closures;
      for (LoopClosure& closure : linkage.closures) substitute(substitution, closure);
    }
    if (linkage.balances_moments && count_lengths(linkage) > max_moment_lengths)
      return "it has too many lengths for conditions of moments";
    VirtualLinkageResult dual = make_virtual_linkage(linkage, box);
    if (!dual.linkage) return dual.reason;
    geometry.linkage = std::move(linkage);
    geometry.dual = std::move(*dual.linkage);
    const auto is_positive = [&](const LengthPolynomial& scale) { return enclose_range(scale, box).first > 0; };
    if (!std::all_of(geometry.dual.positive.begin(), geometry.dual.positive.end(), is_positive))
      return "a length may vanish";
    if (geometry.linkage.balances_moments && count_coefficients(geometry.dual, geometry.conditions) > max_coefficients)
      return "its polynomials have too many coefficients";
    std::tie(geometry.min_value, geometry.max_fixed_size) = enclose_range(geometry.linkage.fixed_size, box);
    geometry.impossibility_margin = residual_tolerance * max_multiplier * fixed_moment(geometry, box);
    geometry.max_value = geometry.max_fixed_size + geometry.impossibility_margin;
    for (const FreeCounterweight& counterweight : geometry.linkage.counterweights) {
      geometry.min_value += counterweight.lower * (1 - mass_sum_tolerance);
      geometry.max_value += counterweight.upper * (1 + mass_sum_tolerance);
    }
    result_.geometries.push_back(std::move(geometry));
    return {};
  }

  /// Largest coefficient of the fixed masses' height, and of those of the inertias [kg].
  static double fixed_moment(const LengthGeometry& geometry, const LengthBox& box) {
    const VirtualLinkage& dual = geometry.dual;
    double moment = largest_coefficient(dual.fixed_masses.scale, dual.fixed_masses.coefficients, box);
    for (std::size_t i = 0; i < dual.inertias.size(); ++i) {
      const FreeInertia& inertia = geometry.linkage.inertias[i];
      const auto& coefficients = dual.inertias[i].coefficients;
      const double ratio = inertia.spin.ratio_number < 0 ? 0
                                                         : std::max(std::abs(box.lower[inertia.spin.ratio_number]),
                                                                    std::abs(box.upper[inertia.spin.ratio_number]));
      moment +=
          inertia.upper * (largest_coefficient(dual.inertias[i].scale, coefficients[PlacedHeight::constant], box) +
                           ratio * largest_coefficient(dual.inertias[i].scale, coefficients[PlacedHeight::ratio], box));
    }
    return moment;
  }

  static double largest_coefficient(const LengthPolynomial& height_scale,
                                    const std::vector<LengthPolynomial>& coefficients, const LengthBox& box) {
    double largest = 0;
    for (const LengthPolynomial& coefficient : coefficients) {
      const auto [low, high] = enclose_range(coefficient, box);
      largest = std::max({largest, std::abs(low), std::abs(high)});
    }
    const double scale = enclose_range(height_scale, box).first;
    return scale > 0 ? largest / scale : std::numeric_limits<double>::infinity();
  }

  /// General lengths must have the conditions that the library derives. Where an expression of the spec makes all
  /// lengths special, a special geometry must have them instead.
  void check_geometries() {
    for (std::size_t g = 0; g < result_.geometries.size(); ++g) {
      const LengthGeometry& geometry = result_.geometries[g];
      const bool has_equalities = std::any_of(geometry.conditions.begin(), geometry.conditions.end(),
                                              [](const LengthCondition& condition) { return condition.is_equality; });
      if (!geometry.substitution.empty() || has_equalities) continue;
      const BoxProgram program(geometry.linkage, geometry.dual, {});
      const std::string reason =
          program.lengths().empty() ? "no length is free"
                                    : find_disagreement(space_, geometry.linkage, geometry.dual, program, geometry.box);
      if (g == 0) result_.reason = reason;
      if (!reason.empty()) continue;
      result_.reason.clear();
      if (g > 0) result_.geometries.erase(result_.geometries.begin());
      return;
    }
  }

  static void substitute(const LengthSubstitution& substitution, LoopClosure& closure) {
    for (const auto& [number, value] : substitution) {
      for (auto& [body, coefficient] : closure.links) coefficient = coefficient.substitute(number, value);
      closure.ground = closure.ground.substitute(number, value);
    }
  }

  const DesignSpace& space_;
  const std::vector<int>& required_trajectories_;
  LengthGeometries result_;
};

}  // namespace

LengthGeometries list_length_geometries(const DesignSpace& space, const std::vector<int>& required_trajectories) {
  // what the conditions of forces alone imply is a bound as well
  if (requires_moment_balance(space)) {
    LengthGeometries geometries = GeometryLister(space, required_trajectories).list(true);
    if (geometries.reason.empty() || !requires_force_or_static_balance(space)) return geometries;
  }
  return GeometryLister(space, required_trajectories).list(false);
}

}  // namespace balance::certificate
