#pragma once
/// A made-up design of two free numbers, three conditions on five parameters and two trajectories.

#include "../files/sample.hpp"
#include "balance/interface/reports/design_sections.hpp"

#include <limits>

namespace sample {

inline dynamics::Parameter parameter(const std::string& owner, const std::string& symbol,
                                     dynamics::ParameterOwner bearer = dynamics::ParameterOwner::body) {
  dynamics::Parameter p;
  p.owner = owner;
  p.symbol = symbol;
  p.name = owner + "." + symbol;
  p.owner_kind = bearer;
  return p;
}

inline Conditions sample_conditions() {
  Conditions c;
  c.status = ConditionsStatus::done;
  c.goals = {{GoalKind::statics}};
  c.parameters = {parameter("a", "m"), parameter("a", "mx"), parameter("b", "m"),
                  parameter("d", "mx", dynamics::ParameterOwner::disc), parameter("e", "J")};
  c.matrix.resize(3, 5);
  c.matrix << 0, 1, 0.5, 0, 0,  //
      -0.25, 0, 0, 0, 1,        //
      0, 0, 0, 1, 0;
  c.pivots = {1, 4, 3};
  c.row_scales = Eigen::Vector3d(2, 4, 1);
  c.rank = 3;
  c.min_kept_singular_value = 0.1;
  c.max_dropped_singular_value = 1e-15;
  c.singular_value_gap = 1e14;
  c.samples = 17;
  c.notes = {"a note"};
  return c;
}

inline reports::ConditionsReportData conditions_view() {
  reports::ConditionsReportData view;
  view.title = "made up";
  view.strategy = "complete";
  view.conditions = sample_conditions();
  view.names.symbols = {{"l1", "m", 0.5, {}}};
  view.names.formulas = {std::vector<std::optional<conditions::CoefficientFormula>>(5),
                         std::vector<std::optional<conditions::CoefficientFormula>>(5),
                         std::vector<std::optional<conditions::CoefficientFormula>>(5)};
  view.names.formulas[0][2] = conditions::CoefficientFormula{{1, 1, {{0, 1}}}, {}};
  view.names.formulas[1][0] = conditions::CoefficientFormula{{-1, 1, {{0, 2}}}, {}};
  view.residuals = Eigen::Vector3d(0.125, 1e-12, 0);
  view.holds_by_definition = {false, false, true};
  view.numbers.resize(2);
  view.numbers[0].key_path = "bodies.a.com[0]";
  view.numbers[0].lower = -1;
  view.numbers[0].upper = 1;
  view.numbers[1].key_path = "counterweights.b.mass";
  view.numbers[1].upper = 10;
  view.free_number_indices = {{0, 1}, {}, {}};
  return view;
}

inline reports::DesignReportData sample_design() {
  reports::DesignReportData view;
  view.conditions = conditions_view();
  view.conditions.residuals[0] = 0;
  view.residuals_before = Eigen::Vector3d(0.125, 0, 0);
  view.objective = "added mass";
  view.objective_unit = "kg";
  view.seconds = 60;
  view.warnings = {"odd"};
  DesignReport& r = view.report;
  r.outcome.status = DesignStatus::balanced;
  r.outcome.method = design::DesignMethod::affine;
  r.outcome.reason = "3 conditions are met";
  r.outcome.x = Eigen::Vector2d(-0.25, 10);
  r.outcome.conditions = sample_conditions();
  r.outcome.objective = 10;
  r.outcome.start_objective = 0;
  r.outcome.lower_bound = 10;
  r.outcome.optimality = design::Optimality::proved_global;
  r.outcome.solution_set = {1, 0, {}};
  r.added_mass = 10;
  r.added_inertia = 0.125;
  r.free_numbers = view.conditions.numbers;
  r.before = Eigen::Vector2d(0.5, 0);
  r.mass_before = 3;
  r.mass_after = 13;
  r.inertia_before = 0.5;
  r.inertia_after = 0.625;
  design::TrajectoryComparison moved{"cycloid", result(SpaceKind::planar), result(SpaceKind::planar)};
  moved.before.metrics = {{"torque[A]", "N m", 100, 0, 50, 40, 200},
                          {"shaking_force", "N", 800, 0, 400, 300, 800, 0, 800, 2e-12}};
  moved.after.metrics = {{"torque[A]", "N m", 25, 0, 10, 8, 50},
                         {"shaking_force", "N", 1e-12, 0, 1e-13, 0, 0, 0, 0, 1e-14}};
  design::TrajectoryComparison stuck{"a/b", result(SpaceKind::planar), {}};
  stuck.after.outcome = {MotionStatus::drive_singularity, 0.25, "it stands still", {}};
  r.comparisons = {moved, stuck};
  r.study_before.trajectories.resize(1);
  r.study_before.trajectories[0].name = "cycloid";
  r.study_after = r.study_before;
  return view;
}

}  // namespace sample
