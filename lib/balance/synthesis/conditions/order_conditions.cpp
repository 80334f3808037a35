#include "balance/synthesis/conditions/order_conditions.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"
#include "balance/synthesis/conditions/row_reduction.hpp"

#include <algorithm>
#include <cmath>

namespace balance::conditions {

namespace {

/// Relative to the magnitude of the quantity: up to here a row is round-off.
constexpr double row_round_off = 2e-12;
/// Relative to that magnitude times the masses: of an amplitude.
constexpr double amplitude_round_off = 2e-14;
/// Relative to a row's largest coefficient: of the parameter that it is solved for, and of what is round-off.
constexpr double min_pivot = 1e-4, coefficient_round_off = 1e-10;

/// Per term: 0 for known terms that are zero and for what the goals exclude.
VectorX make_term_mask(const Mechanism& mechanism, const Conditions& like, const ConditionOptions& options) {
  VectorX mask = VectorX::Ones(static_cast<Eigen::Index>(like.parameters.size()));
  for (Eigen::Index p = 0; p < mask.size(); ++p) {
    const Eigen::Index k = p - like.parameter_columns();
    if ((k >= 0 && like.known_term_values[k] == 0 && !like.is_variable_term(k)) ||
        is_excluded(mechanism, like.parameters[static_cast<std::size_t>(p)], options.excluded))
      mask[p] = 0;
  }
  return mask;
}

/// @return 0 if nothing is large enough
int choose_pivot(const Eigen::RowVectorXd& row, const std::vector<int>& order) {
  const double largest = numerics::max_abs(row);
  for (const int p : order)
    if (std::abs(row[p]) > min_pivot * largest) return p;
  return 0;
}

/// Solves a row in natural units for a parameter and appends it. @param amplitude the row in SI
void append_condition(const Eigen::RowVectorXd& row, const Eigen::RowVectorXd& amplitude, int pivot,
                      const NaturalUnits& units, Conditions& out) {
  const Eigen::Index r = out.matrix.rows();
  const double largest = numerics::max_abs(row);
  out.matrix.conservativeResize(r + 1, row.size());
  out.matrix.row(r) =
      (row.array().abs() > coefficient_round_off * largest).select(amplitude.array() / amplitude[pivot], 0.0);
  out.matrix(r, pivot) = 1;
  out.pivots.push_back(pivot);
  out.row_scales.conservativeResize(r + 1);
  out.row_scales[r] = units.mass * units.parameter[pivot] * largest / std::abs(row[pivot]);
  ++out.rank;
}

Conditions without_rows(const Conditions& like) {
  Conditions out;
  out.status = ConditionsStatus::done;
  out.goals = like.goals;
  out.parameters = like.parameters;
  out.known_term_values = like.known_term_values;
  out.variable_terms = like.variable_terms;
  out.matrix.resize(0, static_cast<Eigen::Index>(like.parameters.size()));
  out.row_scales.resize(0);
  return out;
}

}  // namespace

OrderConditions list_order_conditions(const Mechanism& mechanism, const Conditions& derived,
                                      const ConditionOptions& options) {
  const NaturalUnits units(mechanism, derived.parameters);
  const VectorX mask = make_term_mask(mechanism, derived, options);
  const MatrixX scaled = scale_order_rows(derived.orders, units.parameter, mask);
  const std::vector<int> order = order_pivots(mechanism, derived.parameters);
  OrderConditions listed{without_rows(derived), VectorX(0), {}};
  for (std::size_t r = 0; r < derived.orders.rows.size(); ++r) {
    const Eigen::RowVectorXd row = scaled.row(static_cast<Eigen::Index>(r));
    if (row.norm() <= row_round_off) continue;
    const Eigen::RowVectorXd amplitude = derived.orders.rows[r].coefficients.cwiseProduct(mask).transpose();
    const int pivot = choose_pivot(row, order);
    append_condition(row, amplitude, pivot, units, listed.conditions);
    listed.factors.conservativeResize(listed.factors.size() + 1);
    listed.factors[listed.factors.size() - 1] = amplitude[pivot];
    listed.rows.push_back(r);
  }
  return listed;
}

VectorX evaluate_order_rows(const Mechanism& mechanism, const Conditions& derived, const ConditionOptions& options) {
  const VectorX values = term_values(mechanism, options.loose_springs);
  const double size = values.cwiseQuotient(NaturalUnits(mechanism, derived.parameters).parameter).cwiseAbs().sum();
  VectorX amplitudes(static_cast<Eigen::Index>(derived.orders.rows.size()));
  for (std::size_t r = 0; r < derived.orders.rows.size(); ++r) {
    const OrderRow& row = derived.orders.rows[r];
    const double amplitude = row.coefficients.dot(values);
    amplitudes[static_cast<Eigen::Index>(r)] =
        std::abs(amplitude) <= amplitude_round_off * row.magnitude * size ? 0 : amplitude;
  }
  return amplitudes;
}

Conditions rederive_order_conditions(const Mechanism& mechanism, const OrderConditions& known,
                                     const ConditionOptions& options) {
  Conditions out = without_rows(known.conditions);
  const NaturalUnits units(mechanism, out.parameters);
  out.orders = compute_order_rows(mechanism, out.goals, options.motions, options.loose_springs, units.parameter);
  if (!out.orders.mismatch.empty()) {
    out.status = ConditionsStatus::mismatch;
    out.reason = out.orders.mismatch;
    return out;
  }
  const VectorX mask = make_term_mask(mechanism, out, options);
  const MatrixX scaled = scale_order_rows(out.orders, units.parameter, mask);
  for (std::size_t c = 0; c < known.rows.size(); ++c) {
    const std::size_t r = known.rows[c];
    append_condition(scaled.row(static_cast<Eigen::Index>(r)),
                     out.orders.rows[r].coefficients.cwiseProduct(mask).transpose(), known.conditions.pivots[c], units,
                     out);
  }
  return out;
}

}  // namespace balance::conditions
