#include "balance/conditions/definition.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// A disc with one moment of inertia about its axis and another across it.
Disc make_symmetric_disc(const Disc& disc, double mass, double axial, double transverse) {
  Disc result = disc;
  result.mass = mass;
  result.inertia = transverse * Matrix3::Identity() + (axial - transverse) * disc.axis * disc.axis.transpose();
  return result;
}

/// Parameters of a mechanism in which only one disc has mass or inertia.
VectorX single_disc_parameters(const Mechanism& mechanism, std::size_t which, double mass, double axial,
                               double transverse) {
  Mechanism alone = mechanism;
  for (Disc& disc : alone.discs) disc = make_symmetric_disc(disc, 0, 0, 0);
  alone.discs[which] = make_symmetric_disc(mechanism.discs[which], mass, axial, transverse);
  return parameter_values(alone);
}

}  // namespace

bool is_met_by_symmetric_discs(const Conditions& conditions, int row, const Mechanism& mechanism) {
  const VectorX coefficients = conditions.matrix.row(row);
  const double largest = max_abs(coefficients);
  Eigen::Index begin = coefficients.size(), end = 0;
  for (Eigen::Index p = 0; p < coefficients.size(); ++p) {
    if (std::abs(coefficients[p]) <= 1e-12 * largest) continue;
    if (conditions.parameters[static_cast<std::size_t>(p)].owner_kind != ParameterOwner::disc) return false;
    begin = std::min(begin, p);
    end = p + 1;
  }
  const auto vanishes = [&](std::size_t disc, double mass, double axial, double transverse) {
    // Springs come last, so that discs' parameters have the same places however springs are described.
    const VectorX values = single_disc_parameters(mechanism, disc, mass, axial, transverse);
    return begin >= end ||
           std::abs(coefficients.segment(begin, end - begin).dot(values.segment(begin, end - begin))) <= 1e-9 * largest;
  };
  for (std::size_t d = 0; d < mechanism.discs.size(); ++d)
    if (!vanishes(d, 1, 0, 0) || !vanishes(d, 0, 1, 0) || !vanishes(d, 0, 0, 1)) return false;
  return true;
}

}  // namespace balance
