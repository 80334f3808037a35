#include "balance/mechanics/results/round_off.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"

#include <algorithm>

namespace balance {

void set_round_off(RunResult& result, const TermMagnitudes& terms, const TermMagnitudes& grown) {
  result.term_magnitudes = terms;
  result.round_off = {};
  result.round_off.raise_to(grown, round_off_factor);
}

VectorX TermMagnitudes::*term_magnitude_of(Samples RunResult::*array) {
  const auto table = quantity_table();
  const auto found = std::find_if(table.begin(), table.end(), [&](const auto& kind) { return kind.member == array; });
  return found == table.end() ? nullptr : found->terms;
}

double column_term_magnitude(const RunResult& result, const TermMagnitudes& sizes, Samples RunResult::*array,
                             Eigen::Index column) {
  VectorX TermMagnitudes::*const size = term_magnitude_of(array);
  if (size == nullptr) return 0;
  const VectorX& known = sizes.*size;
  const Eigen::Index columns = (result.*array).cols();
  if (known.size() == 0 || columns == 0) return 0;
  if (known.size() == 1) return known[0];
  return known[std::min(known.size() - 1, column * known.size() / columns)];
}

double column_round_off(const RunResult& result, Samples RunResult::*array, Eigen::Index column) {
  return column_term_magnitude(result, result.round_off, array, column);
}

void clear_column(Samples& values, Eigen::Index column, double round_off) {
  const auto is_small = [round_off](double value) { return suppress_round_off(round_off, value) == 0; };
  if (std::all_of(values.col(column).begin(), values.col(column).end(), is_small)) values.col(column).setZero();
}

void clear_round_off(Samples RunResult::*array, RunResult& result) {
  constexpr double max_cleared_part = 1e-9;  // of the terms: near a singularity round-off is only estimated
  Samples& values = result.*array;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const double terms = column_term_magnitude(result, result.term_magnitudes, array, c);
    clear_column(values, c, std::min(column_round_off(result, array, c), max_cleared_part * terms));
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

}  // namespace balance
