#include "balance/analysis/equations_round_off.hpp"

#include "balance/base/extrema.hpp"
#include "balance/model/coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace balance {

namespace {

/// Of what entries are made of: products of a hundred terms with inverses of the closures.
constexpr double round_off = 1e-12;

void clear(double& value, double size) {
  if (std::abs(value) <= round_off * size) value = 0;
}

void clear(VectorX& values, const VectorX& sizes) {
  for (Eigen::Index i = 0; i < values.size(); ++i) clear(values[i], sizes[i]);
}

VectorX units_of(const std::vector<bool>& lengths, double length) {
  VectorX units(static_cast<Eigen::Index>(lengths.size()));
  for (Eigen::Index i = 0; i < units.size(); ++i) units[i] = lengths[static_cast<std::size_t>(i)] ? length : 1;
  return units;
}

/// Masses are positive definite: no entry is above the geometric mean of its diagonal ones. Rates of a coordinate turn bodies by its unit.
void clear_inertia(const VectorX& units, MatrixX& mass, std::vector<MatrixX>& velocity) {
  const VectorX root = mass.diagonal().cwiseAbs().cwiseSqrt();
  const double largest = root.size() > 0 ? max_coefficient(root) : 0;
  const Eigen::Index d = std::min(root.size(), units.size());
  for (Eigen::Index r = 0; r < d; ++r)
    for (Eigen::Index s = 0; s < d; ++s) {
      clear(mass(r, s), root[r] * root[s]);
      const double product = std::max(root[r] / units[s], root[s] / units[r]);
      for (std::size_t k = 0; k < velocity.size(); ++k) clear(velocity[k](r, s), largest * product);
    }
}

void clear_rest(const VectorX& units, const EquationSizes& sizes, RestTerms& rest) {
  for (const auto& [part, moment] :
       {std::pair(&rest.weight, sizes.weight), {&rest.springs, sizes.springs}, {&rest.loads, sizes.loads}})
    if (part->size() == units.size()) clear(*part, VectorX(moment * units.cwiseInverse()));
}

}  // namespace

EquationSizes equation_sizes(const Mechanism& mechanism) {
  const double length = characteristic_length(mechanism);
  EquationSizes sizes{length, total_mass(mechanism) * mechanism.gravity.norm() * length, 0, 0};
  for (const Spring& spring : mechanism.springs) {
    const bool turns = spring.in_joint() && !is_length(mechanism, spring.coordinate);
    sizes.springs += std::abs(spring.stiffness) * (turns ? 1 : length * std::max(length, spring.free_length));
    sizes.springs += std::abs(spring.preload) * (turns ? 1 : length);
  }
  for (const Load& load : mechanism.loads)
    for (std::size_t k = 0; k < load.force.size(); ++k)
      sizes.loads += load.force[k].norm() * length + load.moment[k].norm();
  return sizes;
}

void clear_below_largest(MatrixX& matrix) {
  const double largest = max_abs(matrix);
  for (double& value : matrix.reshaped()) clear(value, largest);
}

void clear_round_off(const EquationSizes& sizes, const std::vector<bool>& lengths, IndependentTerms& terms) {
  const VectorX units = units_of(lengths, sizes.length);
  clear_inertia(units, terms.mass, terms.velocity);
  clear_below_largest(terms.viscous);
  clear_below_largest(terms.input);
  clear_rest(units, sizes, terms.rest);
}

void clear_round_off(const EquationSizes& sizes, const std::vector<bool>& lengths, RedundantTerms& terms) {
  const VectorX units = units_of(lengths, sizes.length);
  clear_inertia(units, terms.mass, terms.velocity);
  clear_rest(units, sizes, terms.rest);
  for (MatrixX* matrix : {&terms.viscous, &terms.input, &terms.constraints, &terms.transformation})
    clear_below_largest(*matrix);
  const double largest = max_abs(terms.transformation);
  for (MatrixX& form : terms.acceleration)
    for (double& value : form.reshaped()) clear(value, largest);
}

void clear_round_off(const EquationSizes& sizes, SpeedTerms& terms) {
  clear_below_largest(terms.rows);
  clear_below_largest(terms.rates);
  const double inertia = std::max(max_abs(terms.own.mass), max_abs(terms.held.mass));
  for (IndependentTerms* part : {&terms.own, &terms.held}) {
    for (double& value : part->mass.reshaped()) clear(value, inertia);
    for (MatrixX& form : part->velocity)
      for (double& value : form.reshaped()) clear(value, inertia * std::max(1.0, 1 / sizes.length));
    clear_below_largest(part->viscous);
    clear_below_largest(part->input);
    clear_rest(VectorX::Constant(part->rest.weight.size(), std::max(1.0, sizes.length)), sizes, part->rest);
  }
}

void clear_round_off(const EquationSizes& sizes, const std::vector<bool>& forces, EffortSplit& split) {
  for (Eigen::Index k = 0; k < split.parts.rows(); ++k) {
    const double unit = forces[static_cast<std::size_t>(k)] ? sizes.length : 1;
    const double size = std::max(sizes.weight / unit, max_abs(split.parts.row(k)));
    for (double& value : split.parts.row(k)) clear(value, size);
    clear(split.effort[k], size);
  }
}

}  // namespace balance
