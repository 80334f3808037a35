#include "balance/analysis/equations_round_off.hpp"

#include "balance/base/extrema.hpp"
#include "balance/model/coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace balance {

namespace {

/// Of what entries are made of: products of a hundred terms with inverses of the closures.
constexpr double relative_entry_tolerance = 1e-12;

void clear_if_round_off(double& value, double size) {
  if (std::abs(value) <= relative_entry_tolerance * size) value = 0;
}

void clear_if_round_off(VectorX& values, const VectorX& sizes) {
  for (Eigen::Index i = 0; i < values.size(); ++i) clear_if_round_off(values[i], sizes[i]);
}

VectorX coordinate_scales(const std::vector<bool>& lengths, double length) {
  VectorX units(static_cast<Eigen::Index>(lengths.size()));
  for (Eigen::Index i = 0; i < units.size(); ++i) units[i] = lengths[static_cast<std::size_t>(i)] ? length : 1;
  return units;
}

/// Masses are positive definite: no entry is above the geometric mean of its diagonal ones. Rates of a coordinate turn bodies by its unit.
void clear_inertia_round_off(const VectorX& units, MatrixX& mass, std::vector<MatrixX>& velocity) {
  const VectorX root = mass.diagonal().cwiseAbs().cwiseSqrt();
  const double largest = root.size() > 0 ? max_coefficient(root) : 0;
  const Eigen::Index d = std::min(root.size(), units.size());
  for (Eigen::Index r = 0; r < d; ++r)
    for (Eigen::Index s = 0; s < d; ++s) {
      clear_if_round_off(mass(r, s), root[r] * root[s]);
      const double product = std::max(root[r] / units[s], root[s] / units[r]);
      for (std::size_t k = 0; k < velocity.size(); ++k) clear_if_round_off(velocity[k](r, s), largest * product);
    }
}

void clear_static_round_off(const VectorX& units, const EquationScales& sizes, StaticTerms& rest) {
  for (const auto& [part, moment] : {std::pair(&rest.weight, sizes.gravity_moment),
                                     {&rest.springs, sizes.spring_moment},
                                     {&rest.loads, sizes.load_moment}})
    if (part->size() == units.size()) clear_if_round_off(*part, VectorX(moment * units.cwiseInverse()));
}

}  // namespace

EquationScales compute_equation_scales(const Mechanism& mechanism) {
  const double length = characteristic_length(mechanism);
  EquationScales sizes{length, total_mass(mechanism) * mechanism.gravity.norm() * length, 0, 0};
  for (const Spring& spring : mechanism.springs) {
    const bool turns = spring.is_joint_spring() && !is_length_coordinate(mechanism, spring.coordinate);
    sizes.spring_moment += std::abs(spring.stiffness) * (turns ? 1 : length * std::max(length, spring.free_length));
    sizes.spring_moment += std::abs(spring.preload) * (turns ? 1 : length);
  }
  for (const Load& load : mechanism.loads)
    for (std::size_t k = 0; k < load.force.size(); ++k)
      sizes.load_moment += load.force[k].norm() * length + load.moment[k].norm();
  return sizes;
}

void clear_relative_round_off(MatrixX& matrix) {
  const double largest = max_abs(matrix);
  for (double& value : matrix.reshaped()) clear_if_round_off(value, largest);
}

void clear_round_off(const EquationScales& sizes, const std::vector<bool>& lengths, IndependentTerms& terms) {
  const VectorX units = coordinate_scales(lengths, sizes.length);
  clear_inertia_round_off(units, terms.mass, terms.velocity);
  clear_relative_round_off(terms.viscous);
  clear_relative_round_off(terms.input);
  clear_static_round_off(units, sizes, terms.static_terms);
}

void clear_round_off(const EquationScales& sizes, const std::vector<bool>& lengths, RedundantTerms& terms) {
  const VectorX units = coordinate_scales(lengths, sizes.length);
  clear_inertia_round_off(units, terms.mass, terms.velocity);
  clear_static_round_off(units, sizes, terms.rest);
  for (MatrixX* matrix : {&terms.viscous, &terms.input, &terms.constraints, &terms.transformation})
    clear_relative_round_off(*matrix);
  const double largest = max_abs(terms.transformation);
  for (MatrixX& form : terms.acceleration)
    for (double& value : form.reshaped()) clear_if_round_off(value, largest);
}

void clear_round_off(const EquationScales& sizes, SpeedTerms& terms) {
  clear_relative_round_off(terms.rows);
  clear_relative_round_off(terms.rates);
  const double inertia = std::max(max_abs(terms.speed_equations.mass), max_abs(terms.constraint_equations.mass));
  for (IndependentTerms* part : {&terms.speed_equations, &terms.constraint_equations}) {
    for (double& value : part->mass.reshaped()) clear_if_round_off(value, inertia);
    for (MatrixX& form : part->velocity)
      for (double& value : form.reshaped()) clear_if_round_off(value, inertia * std::max(1.0, 1 / sizes.length));
    clear_relative_round_off(part->viscous);
    clear_relative_round_off(part->input);
    clear_static_round_off(VectorX::Constant(part->static_terms.weight.size(), std::max(1.0, sizes.length)), sizes,
                           part->static_terms);
  }
}

void clear_round_off(const EquationScales& sizes, const std::vector<bool>& forces, EffortBreakdown& split) {
  for (Eigen::Index k = 0; k < split.parts.rows(); ++k) {
    const double unit = forces[static_cast<std::size_t>(k)] ? sizes.length : 1;
    const double size = std::max(sizes.gravity_moment / unit, max_abs(split.parts.row(k)));
    for (double& value : split.parts.row(k)) clear_if_round_off(value, size);
    clear_if_round_off(split.effort[k], size);
  }
}

}  // namespace balance
