#pragma once
/// Evaluates figures of a run, a design, conditions or a state.

#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/figure.hpp"
#include "balance/interface/comparison/requirement.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/results/run_quantities.hpp"
#include "balance/motion/vibration/speed_sweep.hpp"
#include "balance/synthesis/design/design_study.hpp"
#include "balance/synthesis/formulas/equations_report.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace balance::comparison {

/// A number by its path: a free number of a design, a solved parameter.
struct FigureNumber {
  std::string path;
  double value = 0;
};

/// Of `balance conditions`.
struct ConditionsFigures {
  int rank = 0;   ///< of all conditions, those on known terms alone included
  int count = 0;  ///< independent conditions on parameters
  bool is_impossible = false;
  bool holds = false;
};

/// What figures are about. Whatever it lacks has no figures. It refers to objects that must outlive the evaluator.
struct FigureSubject {
  const RunResult* run = nullptr;            ///< with samples, or a single state: one row
  const Mechanism* mechanism = nullptr;      ///< of the run
  std::vector<results::FigurePoint> points;  ///< of the mechanism
  const DesignReport* design = nullptr;
  std::string objective_unit;  ///< of the design; empty: none, or a sum
  const formulas::EquationsAtConfiguration* equations = nullptr;
  std::optional<ConditionsFigures> conditions;
  const vibration::VibrationModes* modes = nullptr;
  const vibration::SpeedSweep* sweep = nullptr;
  std::vector<FigureNumber> numbers;
};

/// Keeps what several figures of a subject have in common.
class FigureEvaluator {
 public:
  explicit FigureEvaluator(FigureSubject subject);
  FigureEvaluator(const FigureEvaluator&) = delete;
  FigureEvaluator& operator=(const FigureEvaluator&) = delete;

  EvaluatedFigure evaluate(const FigureReference& figure);
  const FigureSubject& subject() const { return subject_; }

  /// A resolved quantity.
  struct NamedCurve {
    std::string unit;
    std::shared_ptr<const SampledCurve> curve;
    double round_off = 0;
  };
  /// nullptr if there is no such quantity: `figure` then says so.
  const NamedCurve* find_curve(const std::string& name, EvaluatedFigure& figure);
  /// The time of a moment; std::nullopt: `figure` says why.
  std::optional<double> find_time(const FigureMoment& moment, EvaluatedFigure& figure);
  bool is_single_state() const { return subject_.run != nullptr && subject_.run->time.size() == 1; }

 private:
  void list_equation_quantities();
  void list_mode_quantities();
  void list_sweep_quantities();

  FigureSubject subject_;
  results::RunQuantities quantities_;
  std::map<std::string, NamedCurve> curves_;
};

/// Adds what requirements ask of a run to its table, as far as the metrics do not answer it.
/// @param figures of the requirements, for this run
void evaluate_figures(const std::vector<FigureReference>& figures, FigureEvaluator& evaluator, MetricTable& table);

/// The mechanism of a stored run, for figures of its bodies, from the spec that the run is stored with.
/// @param trajectory name of the run's
/// @return null if the spec cannot be read, or if it is not the run's: a design stores the spec before it
std::shared_ptr<const Mechanism> read_mechanism_of(const RunResult& run, const std::string& trajectory,
                                                   const std::string& spec_text, const std::string& file_name,
                                                   const std::vector<std::pair<std::string, std::string>>& overrides);

/// Whether a table answers a figure by itself: energy and statistics of RunResult::metrics.
bool has_figure(const MetricTable& table, const FigureReference& figure);

}  // namespace balance::comparison
