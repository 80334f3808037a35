#pragma once
/// Several runs side by side, each against the first.

#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/result.hpp"

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace balance {

/// The figures of one run under the name that comparisons and requirements call it by.
struct MetricTable {
  std::string name;             ///< of the run: a file's stem, a case of a suite
  std::vector<Metric> metrics;  ///< SI; a quantity that is not there is missing in this run
  double energy = std::numeric_limits<double>::quiet_NaN();  ///< as RunResult::energy [J]; NaN: missing
};

/// The run's own metrics and, behind those of the joints, the worst reaction of all: `joint_force`, `joint_moment`.
MetricTable make_metric_table(std::string name, const RunResult& result);

/// Null if the run has no such quantity. A slide's force is found by its older name, `torque[S]`, too.
const Metric* find_metric(const MetricTable& table, std::string_view quantity);

/// NaN if the run has no such quantity.
double find_figure(const MetricTable& table, Statistic figure, std::string_view quantity);

/// Every quantity that at least one of the runs has, in the order in which they first appear.
std::vector<std::string> list_quantity_names(const std::vector<MetricTable>& tables);

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
  std::string quantity, unit;                  ///< as in RunResult::metrics
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

// Short names for runs that come from files.

/// Where a run is stored.
struct RunLocation {
  std::string path;   ///< of the file
  std::string group;  ///< in a file with several runs; "": the file is one run
};

/// One name per run, no two alike: the file's stem, or the group; where that is not enough with the file or the folder before it,
/// and where nothing tells them apart with a number behind it. Only the first may be called `base`.
std::vector<std::string> make_run_names(const std::vector<RunLocation>& places);

}  // namespace balance
