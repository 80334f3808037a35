#include "balance/report/page_rows.hpp"

#include "balance/base/extrema.hpp"
#include "balance/result/quantities.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace balance {
namespace {

/// How much the rows of a run are needed, raised column by column.
class RowSignificance {
 public:
  RowSignificance(Eigen::Index rows, const std::vector<Eigen::Index>& spread)
      : spread_(spread), worth_(static_cast<std::size_t>(rows), 0) {}

  void add_column(const Samples& samples, Eigen::Index column) {
    if (samples.rows() == 0) return;
    const Eigen::Index low = min_index(samples.col(column)), high = max_index(samples.col(column));
    const double least = samples(low, column), largest = samples(high, column);
    if (!(largest > least)) return;
    raise(low, std::numeric_limits<double>::infinity());
    raise(high, std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i + 1 < spread_.size(); ++i)
      add_segment_extremes(samples, column, spread_[i], spread_[i + 1], largest - least);
  }

  const std::vector<double>& values() const { return worth_; }

 private:
  void raise(Eigen::Index row, double worth) {
    double& value = worth_[static_cast<std::size_t>(row)];
    value = std::max(value, worth);
  }

  /// The two rows between first and last that are farthest above and below the straight line.
  void add_segment_extremes(const Samples& samples, Eigen::Index column, Eigen::Index first, Eigen::Index last,
                            double span) {
    const double start = samples(first, column);
    const double slope = (samples(last, column) - start) / static_cast<double>(last - first);
    double above = 0, below = 0;
    Eigen::Index high = first, low = first;
    for (Eigen::Index k = first + 1; k < last; ++k) {
      const double off = samples(k, column) - start - slope * static_cast<double>(k - first);
      if (off > above) above = off, high = k;
      if (off < below) below = off, low = k;
    }
    if (above > 0) raise(high, above / span);
    if (below < 0) raise(low, -below / span);
  }

  const std::vector<Eigen::Index>& spread_;
  std::vector<double> worth_;
};

}  // namespace

std::vector<Eigen::Index> select_display_rows(const std::vector<const RunResult*>& runs, Eigen::Index most) {
  const Eigen::Index all = runs.front()->time.size();
  std::vector<Eigen::Index> rows;
  if (all <= most) {
    rows.resize(static_cast<std::size_t>(all));
    std::iota(rows.begin(), rows.end(), Eigen::Index{0});
    return rows;
  }
  const Eigen::Index spread = most / 2;
  for (Eigen::Index i = 0; i < spread; ++i) rows.push_back(i * (all - 1) / (spread - 1));
  RowSignificance worth(all, rows);
  for (const RunResult* run : runs)
    for (const Quantity& quantity : list_sampled_quantities(*run))
      for (Eigen::Index c = 0; c < quantity.samples->cols(); ++c) worth.add_column(*quantity.samples, c);
  std::vector<Eigen::Index> wanted;
  for (Eigen::Index k = 0; k < all; ++k)
    if (worth.values()[static_cast<std::size_t>(k)] > 0) wanted.push_back(k);
  const auto more_worth = [&](Eigen::Index a, Eigen::Index b) {
    return worth.values()[static_cast<std::size_t>(a)] > worth.values()[static_cast<std::size_t>(b)];
  };
  const auto room = std::min(static_cast<std::size_t>(most) - rows.size(), wanted.size());
  std::partial_sort(wanted.begin(), wanted.begin() + static_cast<std::ptrdiff_t>(room), wanted.end(), more_worth);
  rows.insert(rows.end(), wanted.begin(), wanted.begin() + static_cast<std::ptrdiff_t>(room));
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

RunResult extract_rows(const RunResult& result, const std::vector<Eigen::Index>& rows) {
  RunResult shown;  // not a copy: of a million samples one is enough
  shown.outcome = result.outcome;
  shown.coordinate_names = result.coordinate_names;
  shown.coordinate_units = result.coordinate_units;
  shown.joint_names = result.joint_names;
  shown.actuator_names = result.actuator_names;
  shown.actuator_units = result.actuator_units;
  shown.body_names = result.body_names;
  shown.constraint_names = result.constraint_names;
  shown.constraint_units = result.constraint_units;
  shown.sliding_names = result.sliding_names;
  shown.sliding_units = result.sliding_units;
  shown.axes = result.axes;
  shown.moment_axes = result.moment_axes;
  shown.moment_reference = result.moment_reference;
  shown.metrics = result.metrics;
  shown.energy = result.energy;
  shown.round_off = result.round_off;
  shown.time = result.time(rows);
  if (result.newton_iterations.size() > 0) shown.newton_iterations = result.newton_iterations(rows);
  for (const Quantity& quantity : list_sampled_quantities(result))
    shown.*quantity.member = (result.*quantity.member)(rows, Eigen::all);
  return shown;
}

}  // namespace balance
