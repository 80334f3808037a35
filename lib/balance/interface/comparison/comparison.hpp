#pragma once
/// Several runs side by side, each compared with the first.

#include "balance/interface/comparison/figure.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/result.hpp"

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace balance::comparison {

/// The figures of a run, with the name by which comparisons and requirements refer to it.
struct MetricTable {
  std::string name;             ///< of the run: a file's stem, a case of a suite
  std::vector<Metric> metrics;  ///< in SI units; quantities that the run does not have are absent
  double energy = std::numeric_limits<double>::quiet_NaN();  ///< as RunResult::energy [J]; NaN: missing
  std::vector<EvaluatedFigure> figures;  ///< those that were asked for and do not follow from the above
};

/// The run's own metrics and, before those of the joints, the worst reaction of all: `joint_force`, `joint_moment`.
MetricTable make_metric_table(std::string name, const RunResult& result);

/// nullptr if the run has no such quantity. Also finds a slide's force by its older name, `torque[S]`.
const Metric* find_metric(const MetricTable& table, std::string_view quantity);

/// nullptr if it was not evaluated. @param text FigureReference::text()
const EvaluatedFigure* find_evaluated_figure(const MetricTable& table, std::string_view text);

/// NaN if the run has no such quantity.
double find_figure(const MetricTable& table, Statistic figure, std::string_view quantity);

/// Every quantity of at least one of the runs, in the order of first appearance.
std::vector<std::string> list_quantity_names(const std::vector<MetricTable>& tables);

struct NamedRun {
  std::string name;  ///< unique
  std::string file;  ///< as named by the user; "": none
  std::string title, trajectory, law, drive;
  RunResult result;
  std::shared_ptr<const Mechanism> mechanism;  ///< null: unknown; figures of bodies need it
};

/// The difference of two runs' samples of a quantity, at the samples of the run with fewer; the other is interpolated.
struct Difference {
  double largest = 0;  ///< maximum magnitude of the difference, in the quantity's unit
  double time = 0;     ///< of the maximum, in the base's time [s]
  double rms = 0;      ///< root mean square over time
};

struct ComparedQuantity {
  std::string quantity, unit;                  ///< as in RunResult::metrics
  std::vector<std::optional<Metric>> metrics;  ///< one per run; std::nullopt if it is missing or in another unit
  /// One per run; std::nullopt for the base, and if either run does not have the quantity or the numbers of components
  /// differ.
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
  std::vector<ComparedQuantity> quantities;  ///< those of the base in its order, then those that only others have
  std::vector<std::string> notes;            ///< what makes runs less comparable than they look
};

/// Runs of different durations are compared at equal fractions of their durations.
/// @throws std::invalid_argument if there are no runs
ComparedRuns compare_runs(const std::vector<NamedRun>& runs);

/// A figure of a run divided by the base's. NaN if either is missing or the base's is zero up to round-off.
double ratio_to_base(const ComparedQuantity& quantity, std::size_t run, Statistic figure);

std::vector<MetricTable> make_metric_tables(const std::vector<NamedRun>& runs);

// Short names for runs that come from files.

/// Location of a stored run.
struct RunLocation {
  std::string path;   ///< of the file
  std::string group;  ///< in a file with several runs; "" if the file is one run
};

/// One unique name per run: the file's stem or the group; if that is ambiguous, preceded by the file or folder; if that
/// is still ambiguous, followed by a number. Only the first run may be called `base`.
std::vector<std::string> make_run_names(const std::vector<RunLocation>& locations);

}  // namespace balance::comparison
