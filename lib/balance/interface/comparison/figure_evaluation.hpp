#pragma once
/// Evaluates figures of a run, a design, conditions or a state.

#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/figure.hpp"
#include "balance/interface/comparison/requirement.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/synthesis/design/design_study.hpp"
#include "balance/synthesis/formulas/equations_report.hpp"

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance {

/// A point fixed to a body.
struct FigurePoint {
  std::string name;
  BodyId body = 0;
  Vector3 position = Vector3::Zero();  ///< in the body's axes [m]
};

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
  const RunResult* run = nullptr;        ///< with samples, or a single state: one row
  const Mechanism* mechanism = nullptr;  ///< of the run
  std::vector<FigurePoint> points;       ///< of the mechanism
  const DesignReport* design = nullptr;
  std::string objective_unit;  ///< of the design; empty: none, or a sum
  const EquationsAtConfiguration* equations = nullptr;
  std::optional<ConditionsFigures> conditions;
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

  /// A sampled scalar or vector of the subject, or one component of a vector.
  struct Quantity {
    std::string name, unit;
    std::vector<std::string> components;  ///< their names; empty: a scalar without any
    std::function<Samples()> samples;     ///< one row per entry of `times`
    const VectorX* times = nullptr;
    std::vector<double> round_off;  ///< per component
  };
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
  void list_run_quantities();
  void list_motion_quantities();
  void list_equation_quantities();
  void add_moving_point(const std::string& position_name, const std::string& velocity_name,
                        const std::string& acceleration_name, BodyId body, const Vector3& position);
  void add_motion(std::string name, const char* unit, std::vector<std::string> components,
                  std::function<VectorX(const std::vector<BodyMotion>&)> value);
  void add_constant(std::string name, const std::string& unit, double value);
  const std::vector<std::vector<BodyMotion>>& motions();
  bool is_merged(Samples RunResult::*array) const;
  Samples merge(Samples RunResult::*array, int first, int count) const;
  const Quantity* find_quantity(const std::string& name, int& component, EvaluatedFigure& figure) const;

  FigureSubject subject_;
  std::vector<Quantity> quantities_;
  std::vector<std::pair<const RunResult*, Eigen::Index>> rows_;  ///< of the run and its intermediate samples, in order
  VectorX times_, recorded_times_;
  std::vector<std::vector<BodyMotion>> motions_;  ///< per entry of rows_; empty: not computed
  std::map<std::string, NamedCurve> curves_;
};

/// Adds what requirements ask of a run to its table, as far as the metrics do not answer it.
/// @param figures of the requirements, for this run
void evaluate_figures(const std::vector<FigureReference>& figures, FigureEvaluator& evaluator, MetricTable& table);

/// The mechanism of a stored run, for figures of its bodies, from the spec that the run is stored with.
/// @return null if the spec cannot be read, or if it is not the run's: a design stores the spec before it
std::shared_ptr<const Mechanism> read_mechanism_of(const RunResult& run, const std::string& spec_text,
                                                   const std::string& file_name,
                                                   const std::vector<std::pair<std::string, std::string>>& overrides);

/// Whether a table answers a figure by itself: energy and statistics of RunResult::metrics.
bool has_figure(const MetricTable& table, const FigureReference& figure);

}  // namespace balance
