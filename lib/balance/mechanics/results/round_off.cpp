#include "balance/mechanics/results/round_off.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"

#include <algorithm>

namespace balance::results {

void TermMagnitudes::raise_to(const TermMagnitudes& other, double factor) {
  for (VectorX TermMagnitudes::*member : term_magnitude_members) {
    VectorX& own_values = this->*member;
    const VectorX& other_values = other.*member;
    if (own_values.size() != other_values.size()) own_values.setZero(other_values.size());
    own_values = own_values.cwiseMax(factor * other_values);
  }
}

void set_round_off(RunResult& result, const TermMagnitudes& terms, const TermMagnitudes& amplified) {
  result.term_magnitudes = terms;
  result.round_off = {};
  result.round_off.raise_to(amplified, round_off_factor);
}

VectorX TermMagnitudes::*term_magnitude_of(Samples RunResult::*array) {
  const auto table = quantity_table();
  const auto definition =
      std::find_if(table.begin(), table.end(), [&](const auto& kind) { return kind.member == array; });
  return definition == table.end() ? nullptr : definition->terms;
}

double column_term_magnitude(const RunResult& result, const TermMagnitudes& magnitudes, Samples RunResult::*array,
                             Eigen::Index column) {
  VectorX TermMagnitudes::*const member = term_magnitude_of(array);
  if (member == nullptr) return 0;
  const VectorX& values = magnitudes.*member;
  const Eigen::Index columns = (result.*array).cols();
  if (values.size() == 0 || columns == 0) return 0;
  if (values.size() == 1) return values[0];
  return values[std::min(values.size() - 1, column * values.size() / columns)];
}

double column_round_off(const RunResult& result, Samples RunResult::*array, Eigen::Index column) {
  return column_term_magnitude(result, result.round_off, array, column);
}

void clear_column(Samples& values, Eigen::Index column, double round_off) {
  const auto is_small = [round_off](double value) { return suppress_round_off(round_off, value) == 0; };
  if (std::all_of(values.col(column).begin(), values.col(column).end(), is_small)) values.col(column).setZero();
}

void clear_round_off(Samples RunResult::*array, RunResult& result) {
  constexpr double max_cleared_fraction = 1e-9;  // of the terms: near a singularity, round-off is only an estimate
  Samples& values = result.*array;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const double terms = column_term_magnitude(result, result.term_magnitudes, array, c);
    clear_column(values, c, std::min(column_round_off(result, array, c), max_cleared_fraction * terms));
  }
}

void clear_round_off(RunResult& result) {
  for (const QuantityDefinition& kind : quantity_table())
    if (kind.terms != nullptr && (result.*kind.member).size() > 0) clear_round_off(kind.member, result);
}

Samples suppress_round_off(const RunResult& result, Samples RunResult::*array) {
  Samples values = result.*array;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const double round_off = column_round_off(result, array, c);
    if (round_off == 0) continue;
    for (Eigen::Index k = 0; k < values.rows(); ++k) values(k, c) = suppress_round_off(round_off, values(k, c));
  }
  return values;
}

}  // namespace balance::results
