#pragma once
/// Several runs side by side, each against the first.

#include "balance/compare/metric_table.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

struct NamedRun {
  std::string name;  ///< no two alike
  std::string file;  ///< as named by the user; "": none
  std::string title, trajectory, law, drive;
  RunResult result;
};

/// How far two runs' samples of a quantity are apart, at the samples of the run that has fewer; the other is interpolated.
struct Difference {
  double largest = 0;  ///< magnitude of the difference, in the quantity's unit
  double time = 0;     ///< where, in the base's time [s]
  double rms = 0;      ///< root of the time average of its square
};

struct ComparedQuantity {
  std::string quantity, unit;                  ///< as in Result::metrics
  std::vector<std::optional<Metric>> metrics;  ///< one per run; nothing: the run does not have it, or in another unit
  /// One per run; nothing for the base and where one of both does not have the quantity or has another number of components.
  std::vector<std::optional<Difference>> differences;
};

struct ComparedRuns {
  struct Run {
    std::string name, file, title, trajectory, law, drive;
    long samples = 0;
    double duration = 0;  ///< [s]
    double energy = 0;    ///< [J]
  };
  std::vector<Run> runs;                     ///< the first is the base
  std::vector<ComparedQuantity> quantities;  ///< the base's in its order, then those that only others have
  std::vector<std::string> notes;            ///< what makes runs less comparable than they look
};

/// Runs of different durations are compared at equal fractions of their durations.
/// @throws std::invalid_argument if there are no runs
ComparedRuns compare_runs(const std::vector<NamedRun>& runs);

/// A figure of a run as a multiple of the base's. NaN where one of both is missing or the base's is zero but for round-off.
double ratio_to_base(const ComparedQuantity& quantity, std::size_t run, Statistic figure);

std::vector<MetricTable> make_metric_tables(const std::vector<NamedRun>& runs);

}  // namespace balance
