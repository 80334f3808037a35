#include "balance/result/round_off.hpp"

#include "balance/dynamics/round_off_part.hpp"
#include "balance/result/quantities.hpp"

#include <algorithm>

namespace balance {

void set_round_off(Result& result, const TermSizes& terms, const TermSizes& grown) {
  result.term_sizes = terms;
  result.round_off = {};
  result.round_off.raise(grown, round_off_part);
}

VectorX TermSizes::*term_size_of(Samples Result::*array) {
  const auto table = quantity_table();
  const auto found = std::find_if(table.begin(), table.end(), [&](const auto& kind) { return kind.member == array; });
  return found == table.end() ? nullptr : found->terms;
}

double of_column(const Result& result, const TermSizes& sizes, Samples Result::*array, Eigen::Index column) {
  VectorX TermSizes::*const size = term_size_of(array);
  if (size == nullptr) return 0;
  const VectorX& known = sizes.*size;
  const Eigen::Index columns = (result.*array).cols();
  if (known.size() == 0 || columns == 0) return 0;
  if (known.size() == 1) return known[0];
  return known[std::min(known.size() - 1, column * known.size() / columns)];
}

double round_off_of(const Result& result, Samples Result::*array, Eigen::Index column) {
  return of_column(result, result.round_off, array, column);
}

void clear_column(Samples& values, Eigen::Index column, double round_off) {
  const auto is_small = [round_off](double value) { return above(round_off, value) == 0; };
  if (std::all_of(values.col(column).begin(), values.col(column).end(), is_small)) values.col(column).setZero();
}

void clear_round_off(Samples Result::*array, Result& result) {
  constexpr double max_cleared_part = 1e-9;  // of the terms: near a singularity round-off is only estimated
  Samples& values = result.*array;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const double terms = of_column(result, result.term_sizes, array, c);
    clear_column(values, c, std::min(round_off_of(result, array, c), max_cleared_part * terms));
  }
}

void clear_round_off(Result& result) {
  for (const QuantityKind& kind : quantity_table())
    if (kind.terms != nullptr && (result.*kind.member).size() > 0) clear_round_off(kind.member, result);
}

Samples above_round_off(const Result& result, Samples Result::*array) {
  Samples values = result.*array;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const double round_off = round_off_of(result, array, c);
    if (round_off == 0) continue;
    for (Eigen::Index k = 0; k < values.rows(); ++k) values(k, c) = above(round_off, values(k, c));
  }
  return values;
}

}  // namespace balance
