#include "balance/interface/reports/design_sections.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/files/result_group.hpp"
#include "balance/interface/reports/catalogue_sections.hpp"
#include "balance/interface/reports/conditions_sections.hpp"
#include "balance/interface/reports/length_bound_sections.hpp"
#include "balance/interface/reports/load_case_sections.hpp"
#include "balance/interface/reports/order_condition_sections.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/status_names.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::reports {

using design::DesignOutcome;
using design::Optimality;
using design::TrajectoryComparison;
using files::Align;
using files::DisplayUnit;
using hdf5::Hdf5Writer;

namespace {

std::vector<std::string> paths_of(const DesignReport& report, const study::DifferentNumbers& different) {
  std::vector<std::string> paths;
  for (const int i : different.numbers) paths.push_back(report.free_numbers[static_cast<std::size_t>(i)].key_path);
  return paths;
}

std::vector<std::string> names_of(const DesignReport& report, std::size_t constraint, bool is_kept) {
  std::vector<std::string> names;
  const std::vector<bool>& kept_flags = report.outcome.selection->kept[constraint];
  for (std::size_t k = 0; k < kept_flags.size(); ++k)
    if (kept_flags[k] == is_kept) names.push_back(report.cardinality_constraints[constraint].elements[k].name);
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

std::string sentence(const std::vector<std::string>& names, const char* state) {
  if (names.empty()) return std::string("none is ") + state;
  return fmt::format("{} {} {}", joined(names), names.size() == 1 ? "is" : "are", state);
}

/// "counterweights: cw1 and cw3 are kept, cw2 is left out", and what is known of the minimum number; empty without
/// choices.
std::string format_optional_elements(const DesignReport& report) {
  if (!report.outcome.selection) return "";
  std::string text;
  for (std::size_t c = 0; c < report.cardinality_constraints.size(); ++c)
    text += fmt::format("{}: {}, {}\n", report.cardinality_constraints[c].kind,
                        sentence(names_of(report, c, true), "kept"), sentence(names_of(report, c, false), "left out"));
  if (report.outcome.selection->min_count >= 0)
    text += fmt::format("fewest: {} of them {} enough, {}\n", report.outcome.selection->min_count,
                        report.outcome.selection->min_count == 1 ? "is" : "are",
                        report.outcome.selection->is_min_count_proved ? "and fewer are proved not to be"
                                                                      : "but fewer are not ruled out");
  return text;
}

/// Null without choices.
Json optional_elements_json(const DesignReport& report) {
  if (!report.outcome.selection) return nullptr;
  const design::ElementSelection& selection = *report.outcome.selection;
  Json constraints = Json::array();
  for (std::size_t c = 0; c < report.cardinality_constraints.size(); ++c)
    constraints.push_back(
        {{"section", report.cardinality_constraints[c].kind},
         {"most", report.cardinality_constraints[c].max_count < 0 ? Json("least")
                                                                  : Json(report.cardinality_constraints[c].max_count)},
         {"kept", names_of(report, c, true)},
         {"left_out", names_of(report, c, false)}});
  return {{"choices", std::move(constraints)},
          {"least", selection.min_count < 0 ? Json(nullptr) : Json(selection.min_count)},
          {"least_proved", selection.min_count < 0 ? Json(nullptr) : Json(selection.is_min_count_proved)}};
}

}  // namespace

std::vector<study::OptionalElementText> list_omitted_elements(const DesignReport& report) {
  std::vector<study::OptionalElementText> elements;
  if (!report.outcome.selection) return elements;
  for (std::size_t c = 0; c < report.cardinality_constraints.size(); ++c)
    for (const std::string& name : names_of(report, c, false))
      for (const study::OptionalElementText& one : report.study_before.design.cardinality[c].elements)
        if (one.name == name) elements.push_back(one);
  return elements;
}

namespace {

using Group = Hdf5Writer::Group;

/// Whether the value of a free number is at a bound: −1 lower, 1 upper, 0 neither.
int active_bound(const FreeNumber& number, double value) {
  const double tolerance = 1e-9 * (number.upper - number.lower);
  return value <= number.lower + tolerance ? -1 : value >= number.upper - tolerance ? 1 : 0;
}

const char* name_of(FreeNumber::StartSource source) {
  switch (source) {
    case FreeNumber::StartSource::spec: return "start";
    case FreeNumber::StartSource::zero_of_added_element: return "none";
    case FreeNumber::StartSource::midpoint: return "middle";
  }
  return "";
}

/// A free number with its values.
struct DesignedNumber : FreeNumber {
  double before, value;
  Json edge;  ///< why a length or ratio cannot change further; null if it can
};

std::vector<DesignedNumber> list_designed_numbers(const DesignReport& report) {
  std::vector<DesignedNumber> numbers;
  for (std::size_t i = 0; i < report.free_numbers.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    numbers.push_back({report.free_numbers[i], report.before[k], report.outcome.x[k], nullptr});
  }
  for (const design::FeasibilityEdge& edge : report.outcome.edges) {
    Json& json = numbers[static_cast<std::size_t>(edge.variable)].edge;
    if (json.is_null()) json = {{"side", edge.is_upper ? "upper" : "lower"}, {"reason", edge.reason}};
  }
  return numbers;
}

ReportFields<DesignedNumber> designed_number_fields(const files::TextOptions& options = {}) {
  using Row = DesignedNumber;
  const auto bound_words = [](const Row& row, const char* lower, const char* upper) {
    const int bound = active_bound(row, row.value);
    return bound < 0 ? Json(lower) : bound > 0 ? Json(upper) : Json();
  };
  return {{&Row::key_path, JsonKey{"path"}, TextColumn{options.number_units ? "free number" : "free number [SI]"},
           Hdf5Dataset{"key path in the spec", "free_number"}},
          {nullptr, TextColumn{"unit"}, files::unit_name},
          {&Row::lower, JsonKey{"lower"}, TextColumn{"lower", "{:g}"},
           Hdf5Dataset{"lower bound, SI; free parameters as written"}},
          {&Row::upper, JsonKey{"upper"}, TextColumn{"upper", "{:g}"}, Hdf5Dataset{"upper bound"}},
          {&Row::before, JsonKey{"before"}, TextColumn{},
           Hdf5Dataset{"value before the design: the spec's start values", "start"}},
          {[](const Row& row) { return name_of(row.start_source); }, JsonKey{"before_from"}},
          {&Row::value, JsonKey{"value"}, TextColumn{},
           [](const Row& row, const DisplayUnit& unit) {
             // round-off of zero is meaningless
             const bool is_zero = std::abs(row.value) < 1e-12 * (row.upper - row.lower);
             return files::format_figure(is_zero ? 0 : unit.convert(row.value));
           },
           Hdf5Dataset{"value in the designed mechanism"}},
          {[](const Row& row) { return row.discrete_values.empty() ? Json() : Json(row.discrete_values); },
           JsonKey{"sizes"}},
          {[=](const Row& row) { return bound_words(row, "lower", "upper"); }, JsonKey{"at_bound"}},
          {&Row::edge, JsonKey{"at_edge"}},
          {[=](const Row& row) {
             const std::size_t sizes = row.discrete_values.size();
             return sizes > 0 ? Json(fmt::format("one of {} sizes", sizes)) : bound_words(row, "at lower", "at upper");
           },
           TextColumn{""}}};
}

const ReportFields<DesignReport>& size_fields() {
  static const ReportFields<DesignReport> fields{
      {&DesignReport::mass_before, JsonKey{"mass/before"}, SiUnit{"kg"},
       Hdf5Dataset{"mass of everything that moves, before", "mass_before"}},
      {&DesignReport::mass_after, JsonKey{"mass/after"}, SiUnit{"kg"},
       Hdf5Dataset{"mass of everything that moves, designed", "mass_after"}},
      {&DesignReport::added_mass, JsonKey{"mass/added"}, SiUnit{"kg"},
       Hdf5Dataset{"mass of counterweights and discs, designed", "added_mass"}},
      {&DesignReport::inertia_before, JsonKey{"inertia/before"}, SiUnit{"kg m^2"},
       Hdf5Dataset{"sum of the moments of inertia, before", "inertia_before"}},
      {&DesignReport::inertia_after, JsonKey{"inertia/after"}, SiUnit{"kg m^2"},
       Hdf5Dataset{"sum of the moments of inertia, designed", "inertia_after"}},
      {&DesignReport::added_inertia, JsonKey{"inertia/added"}, SiUnit{"kg m^2"},
       Hdf5Dataset{"moments of inertia of counterweights and discs, designed", "added_inertia"}}};
  return fields;
}

ReportFields<DesignReportData> objective_fields(const DesignReportData& view) {
  using Row = DesignReportData;
  const auto of_outcome = [](double DesignOutcome::*figure) {
    return [figure](const Row& row) { return row.report.outcome.*figure; };
  };
  const SiUnit unit{view.objective_unit.empty() ? "mixed" : view.objective_unit};
  return {
      {&Row::objective, JsonKey{"name"}},
      {&Row::objective_unit, JsonKey{"unit"}},
      {of_outcome(&DesignOutcome::objective), JsonKey{"value"}, unit,
       Hdf5Dataset{"objective of the design", "objective_value"}},
      {of_outcome(&DesignOutcome::start_objective), JsonKey{"start"}, unit,
       Hdf5Dataset{"objective at the start values", "objective_start"}},
      {of_outcome(&DesignOutcome::lower_bound), JsonKey{"lower_bound"}, unit,
       Hdf5Dataset{"lower bound of the objective, if known", "objective_bound"}},
      {[](const Row& row) { return row.report.outcome.gap(); }, JsonKey{"gap"}},
      {[](const Row& row) { return row.report.outcome.optimality == Optimality::proved_global; }, JsonKey{"global"}}};
}

/// Those of the conditions, and the residuals before.
ReportFields<int> condition_and_residual_fields(const DesignReportData& view) {
  ReportFields<int> fields = condition_fields(view.conditions);
  fields.push_back({[&](int row) { return view.residuals_before[row]; }, JsonKey{"residual_before"},
                    Hdf5Dataset{"scaled residual of the mechanism before"}, SiUnit{"1"}});
  return fields;
}

void describe_design(Hdf5Writer& file, const DesignReportData& view) {
  const DesignOutcome& outcome = view.report.outcome;
  file.set_attribute(hdf5::root_group, "formulation", "tree");
  file.set_attribute(hdf5::root_group, "goal", join_goal_names(outcome.conditions.goals));
  file.set_attribute(hdf5::root_group, "strategy", view.conditions.strategy);
  file.set_attribute(hdf5::root_group, "status", name_of(outcome.status));
  file.set_attribute(hdf5::root_group, "optimality", name_of(outcome.optimality));
  file.set_attribute(hdf5::root_group, "tried", outcome.search_summary);
  file.set_attribute(hdf5::root_group, "proved", outcome.is_proved_infeasible ? "yes" : "no");
  file.set_attribute(hdf5::root_group, "method", name_of(outcome.method));
  file.set_attribute(hdf5::root_group, "reason", outcome.reason);
  file.set_attribute(hdf5::root_group, "proof", outcome.certificate ? outcome.certificate->statement : "");
  file.set_attribute(hdf5::root_group, "objective", view.objective);
}

void add_conditions(Hdf5Writer& file, const DesignReportData& view) {
  const Conditions& c = view.conditions.conditions;
  if (c.matrix.rows() == 0) return;
  std::vector<std::string> names;
  for (const dynamics::Parameter& p : c.parameters) names.push_back(p.name);
  const Hdf5Writer::Dimension condition =
      write_rows(file, hdf5::root_group, files::list_indices(static_cast<int>(c.matrix.rows())),
                 condition_and_residual_fields(view));
  const Hdf5Writer::Dimension parameter =
      file.add_dimension(hdf5::root_group, {"parameter", "inertial parameter", "1", {}, {}}, names);
  file.add_variable(hdf5::root_group,
                    {"condition_matrix",
                     "coefficients of the conditions at the designed geometry",
                     "mixed",
                     {condition, parameter},
                     {{"smallest_kept", {c.min_kept_singular_value}},
                      {"largest_dropped", {c.max_dropped_singular_value}},
                      {"gap", {c.singular_value_gap}}}},
                    hdf5::entries_of(Samples(c.matrix)));
}

files::Provenance description_of(const Study& study, const std::string& name) {
  files::Provenance description;
  description.trajectory = name;
  const Trajectory* trajectory = study::find_by_name(study.trajectories, name);
  if (trajectory == nullptr) return description;
  description.law = law_name(*trajectory);
  description.drive = drive_name(*trajectory);
  return description;
}

/// A run that did not finish has only attributes.
void add_run(Hdf5Writer& file, Group parent, const RunResult& result, const files::Provenance& run,
             const files::WriteOptions& options) {
  // a slash would create another group
  std::string name = run.trajectory;
  std::replace(name.begin(), name.end(), '/', '_');
  const Group group = file.add_group(parent, name);
  write_run_attributes(file, group, run);
  file.set_attribute(group, "status", name_of(result.outcome.status));
  file.set_attribute(group, "reason", result.outcome.reason);
  if (result.outcome.status == MotionStatus::done) write_result_variables(file, group, result, options);
}

void add_runs(Hdf5Writer& file, const DesignReport& report, const files::WriteOptions& options) {
  if (report.comparisons.empty()) return;
  const Group before = file.add_group("before"), after = file.add_group("after");
  for (const TrajectoryComparison& c : report.comparisons) {
    add_run(file, before, c.before, description_of(report.study_before, c.trajectory), options);
    add_run(file, after, c.after, description_of(report.study_after, c.trajectory), options);
  }
}

}  // namespace

void write_design(const std::string& path, const DesignReportData& view, const files::Provenance& description,
                  const files::WriteOptions& options) {
  write_hdf5_file(path, description, options, [&](Hdf5Writer& file) {
    describe_design(file, view);
    if (!view.report.free_numbers.empty())
      write_rows(file, hdf5::root_group, list_designed_numbers(view.report), designed_number_fields());
    add_conditions(file, view);
    write_order_rows(file, view.conditions);
    write_fields(file, hdf5::root_group, view.report, size_fields());
    if (!view.objective.empty()) write_fields(file, hdf5::root_group, view, objective_fields(view));
    if (view.report.length_bound) add_length_bound(file, *view.report.length_bound);
    if (view.report.catalogue) add_parts(file, *view.report.catalogue);
    add_runs(file, view.report, options);
  });
}

namespace {

Json proof_json(const DesignReportData& view) {
  const auto& proof = view.report.outcome.certificate;
  if (!proof) return nullptr;
  const char* kind = proof->kind == conditions::InfeasibilityCertificate::Kind::sign     ? "sign"
                     : proof->kind == conditions::InfeasibilityCertificate::Kind::cone   ? "cone"
                     : proof->kind == conditions::InfeasibilityCertificate::Kind::bounds ? "bounds"
                                                                                         : "squares";
  return {{"kind", kind},
          {"sentence", proof->statement},
          {"combination", files::numbers_json(proof->combination)},
          {"coefficients", files::numbers_json(proof->coefficients)}};
}

Json run_json(const RunResult& result) {
  Json json = {{"outcome", files::outcome_json(result.outcome)},
               {"notes", result.outcome.notes},
               {"metrics", files::metrics_json(result.metrics)}};
  if (result.outcome.status == MotionStatus::done) json["energy"] = result.energy;
  return json;
}

Json change_json(const MetricChange& change) {
  const bool is_known = change.before != 0 && !std::isnan(change.before) && !std::isnan(change.after);
  return {{"quantity", change.quantity}, {"unit", change.unit},
          {"figure", change.figure},     {"before", change.before},
          {"after", change.after},       {"ratio", is_known ? Json(change.after / change.before) : Json(nullptr)}};
}

Json trajectory_comparison_json(const TrajectoryComparison& comparison) {
  return {{"trajectory", comparison.trajectory},
          {"changes", files::list_json(list_metric_changes(comparison), change_json)},
          {"before", run_json(comparison.before)},
          {"after", run_json(comparison.after)}};
}

Json freedom_json(const DesignReport& report) {
  const design::SolutionSet& freedom = report.outcome.solution_set;
  const auto count_json = [](int count) { return count < 0 ? Json(nullptr) : Json(count); };
  Json numbers = Json::array();
  for (const int i : freedom.free_variables)
    numbers.push_back(report.free_numbers[static_cast<std::size_t>(i)].key_path);
  return {{"of_conditions", count_json(freedom.dimension)},
          {"left", count_json(freedom.optimal_dimension)},
          {"numbers", std::move(numbers)}};
}

/// @param best value of the design
Json effort_json(const design::SearchEffort& effort, double best, bool interrupted) {
  const design::StartAgreement agreement = design::compare_starts(effort.ends, best);
  const bool has_ends = agreement.starts > 0, has_others = agreement.farthest_other > 0;
  static constexpr const char* termination_names[] = {
      "nothing-searched", "goal-met", "all-starts-used", "proof", "time", "starts-agree"};
  const bool is_interrupted = interrupted && effort.termination == design::SearchEffort::Termination::time_limit;
  return {{"starts", effort.starts},
          {"local_searches", effort.local_searches},
          {"same_end", has_ends ? Json(agreement.agreeing) : Json(nullptr)},
          {"ended", has_ends ? Json(agreement.starts) : Json(nullptr)},
          {"without_design", has_ends ? Json(agreement.failed) : Json(nullptr)},
          {"nearest_other", has_others ? Json(agreement.nearest_other) : Json(nullptr)},
          {"farthest_other", has_others ? Json(agreement.farthest_other) : Json(nullptr)},
          {"sets_of_lengths", effort.geometries},
          {"evaluations", effort.evaluations},
          {"ended_by", is_interrupted ? "interrupt" : termination_names[static_cast<int>(effort.termination)]}};
}

Json limits_json(const DesignReportData& view) {
  const auto& limits = view.report.study_before.design.subject_to;
  const auto& outcomes = view.report.outcome.limits;
  Json list = Json::array();
  for (std::size_t k = 0; k < outcomes.size(); ++k)
    list.push_back({{"text", limits[k].text},
                    {"value", outcomes[k].value},
                    {"relation", limits[k].is_lower ? ">=" : "<="},
                    {"limit", limits[k].bound},
                    {"unit", limits[k].unit},
                    {"kept", outcomes[k].violation <= design::limit_tolerance},
                    {"active", outcomes[k].is_active},
                    {"violation", outcomes[k].violation}});
  return list;
}

Json robust_json(const tolerance::RobustTerm& one) {
  return {{"name", objective_text({one.term})}, {"deviations", *one.term.deviation_multiple},
          {"value", one.figure.value},          {"mean", one.figure.mean},
          {"deviation", one.figure.deviation},  {"nominal", one.figure.nominal}};
}

void add_outcome(Json& json, const DesignReportData& view) {
  const DesignOutcome& outcome = view.report.outcome;
  json["status"] = name_of(outcome.status);
  json["optimality"] = name_of(outcome.optimality);
  json["tried"] = outcome.search_summary;
  json["search"] = effort_json(outcome.effort, outcome.objective, view.interrupted.has_value());
  json["seconds"] = view.seconds;
  json["proved"] = outcome.status == DesignStatus::infeasible ? Json(outcome.is_proved_infeasible) : Json(nullptr);
  json["method"] = name_of(outcome.method);
  json["reason"] = outcome.reason;
  json["proof"] = proof_json(view);
  // indices into the conditions listed below; those without a parameter are reported as `staying`
  const auto parameter_rows = [&](const std::vector<int>& rows) {
    std::vector<int> result;
    for (const int row : rows)
      if (row < view.conditions.parameter_rows()) result.push_back(row);
    return result;
  };
  json["unmet_fixed"] = parameter_rows(outcome.unmet_fixed_conditions);
  json["open"] = parameter_rows(outcome.unmet_conditions);
  json["objective"] = fields_json(view, objective_fields(view));
  if (!view.report.robust.empty()) json["objective"]["robust"] = files::list_json(view.report.robust, robust_json);
  json["freedom"] = freedom_json(view.report);
  json["chosen"] = optional_elements_json(view.report);
  json["constraints"] = limits_json(view);
  json["least_violation"] = outcome.min_violation_bound;
  json["length_bound"] = length_bound_json(view.report.length_bound);
  json["parts"] = parts_json(view.report.catalogue);
}

void add_notes(Json& json, const DesignReportData& view) {
  for (const auto* notes : {&view.report.outcome.notes, &view.report.notes})
    for (const std::string& note : *notes) json["notes"].push_back(note);
}

}  // namespace

Json design_json(const DesignReportData& view, const std::vector<std::string>& files) {
  const DesignReport& report = view.report;
  Json json = {{"mechanism", view.conditions.title}, {"goal", goals_json(view.conditions.conditions.goals)}};
  json["strategy"] = view.conditions.strategy;
  add_outcome(json, view);
  json["free_numbers"] = rows_json(list_designed_numbers(report), designed_number_fields());
  json["all_different"] =
      files::list_json(report.study_before.design.all_different,
                       [&](const study::DifferentNumbers& different) { return paths_of(report, different); });
  // the conditions are those of the designed mechanism
  add_conditions(json, view.conditions, condition_and_residual_fields(view));
  add_fields(json, report, size_fields());
  json["trajectories"] = files::list_json(report.comparisons, trajectory_comparison_json);
  add_load_cases(json, report);
  add_notes(json, view);
  json["warnings"] = view.warnings;
  json["files"] = files;
  return json;
}

namespace {

std::string ratio_text(double before, double after) {
  if (!(before != 0) || std::isnan(before) || std::isnan(after)) return "-";
  return after == 0 ? "0" : fmt::format("{:.4g}", after / before);
}

bool is_proved_best(const DesignReportData& view) {
  return view.report.outcome.optimality == Optimality::proved_global && !view.objective.empty();
}

/// Headline of a design that violates its limits.
std::string headline_beyond_limits(const DesignOutcome& outcome, const std::string& goals) {
  const bool is_infeasible = outcome.status == DesignStatus::infeasible;
  if (goals.empty())
    return is_infeasible ? "impossible: no choice of the free numbers keeps all limits"
                         : "a compromise: not all limits are kept";
  if (!outcome.unmet_conditions.empty())
    return fmt::format("{}: not balanced for {}, and not all limits are kept",
                       is_infeasible ? "impossible" : "a compromise", goals);
  return is_infeasible
             ? fmt::format("impossible: no choice of the free numbers that balances it for {} keeps all limits", goals)
             : fmt::format("a compromise: balanced for {}, but not all limits are kept", goals);
}

std::string headline(const DesignReportData& view) {
  const DesignOutcome& outcome = view.report.outcome;
  const std::string goals = join_goal_names(outcome.conditions.goals);
  if (!outcome.within_limits && outcome.status != DesignStatus::unsolved) return headline_beyond_limits(outcome, goals);
  switch (outcome.status) {
    case DesignStatus::unsolved: return "no design for " + goals;
    case DesignStatus::balanced:
      if (is_proved_best(view))
        return fmt::format("balanced exactly for {}, with the least possible {}", goals, view.objective);
      return "balanced exactly for " + goals;
    case DesignStatus::compromise: return fmt::format("a compromise: not balanced for {}", goals);
    case DesignStatus::infeasible:
      return fmt::format("impossible: no choice of the free numbers balances it for {}", goals);
    case DesignStatus::no_feasible_start:
      return goals.empty() ? "no design was found" : fmt::format("no design for {} was found", goals);
    case DesignStatus::no_goal:
      if (view.objective.empty()) return "all limits are kept";
      if (is_proved_best(view)) return "the least possible " + view.objective;
      return fmt::format("the smallest {} that was found", view.objective);
  }
  return "";
}

std::string objective_line(const DesignReportData& view, const specification::SpecUnits& units) {
  const DesignOutcome& outcome = view.report.outcome;
  if (view.objective.empty() || std::isnan(outcome.objective)) return "";
  const DisplayUnit unit = files::find_display_unit(view.objective_unit, units);
  std::string text =
      fmt::format("{}: {}{}", view.objective, files::format_figure(unit.convert(outcome.objective)), append_unit(unit));
  if (!std::isnan(outcome.lower_bound) && outcome.optimality != Optimality::proved_global)
    text += fmt::format("; at least {}{} is needed", files::format_figure(unit.convert(outcome.lower_bound)),
                        append_unit(unit));
  if (view.objective_unit.empty() && files::has_other_units(units)) text += " (a sum, in SI)";
  text += "\n";
  for (const tolerance::RobustTerm& one : view.report.robust) {
    const DisplayUnit own =
        files::find_display_unit(simulation::unit_of_term(view.report.study_before.mechanism, one.term), units);
    text += fmt::format("  {} of {} along {}: mean {} ({} without deviations), deviation {}{}\n",
                        design::objective_term_name(one.term.figure), one.term.quantity, one.term.trajectory,
                        files::format_figure(own.convert(one.figure.mean)),
                        files::format_figure(own.convert(one.figure.nominal)),
                        files::format_figure(own.convert(one.figure.deviation)), append_unit(own));
  }
  return text;
}

std::string limits_text(const DesignReportData& view, const specification::SpecUnits& units) {
  const auto& limits = view.report.study_before.design.subject_to;
  const auto& outcomes = view.report.outcome.limits;
  std::string text;
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    const DisplayUnit unit = files::find_display_unit(limits[k].unit, units);
    const char* state = !(outcomes[k].violation <= design::limit_tolerance) ? "missed"
                        : outcomes[k].is_active                             ? "active"
                                                                            : "kept";
    text += fmt::format("limit {}: {}{}, {}", limits[k].text, files::format_figure(unit.convert(outcomes[k].value)),
                        append_unit(unit), state);
    if (!(outcomes[k].violation <= design::limit_tolerance) && limits[k].bound != 0)
      text += fmt::format(" by {:.3g} %", 100 * outcomes[k].violation);
    text += "\n";
  }
  return text;
}

/// "5 of 9 starts ended within 1e-6 of it, the others 3 % to 12 % above"; empty if there was a single start.
std::string agreement_text(const design::StartAgreement& agreement) {
  if (agreement.starts < 2) return "";
  std::string text = fmt::format("{} of {} starts ended within {:g} of it", agreement.agreeing, agreement.starts,
                                 design::start_agreement_tolerance);
  const int others = agreement.starts - agreement.agreeing - agreement.failed;
  const auto percent = [](double fraction) { return fmt::format("{:.2g} %", 100 * fraction); };
  if (others == 1)
    text += fmt::format(", another one {} above", percent(agreement.nearest_other));
  else if (others > 1)
    text +=
        fmt::format(", the others {} to {} above", percent(agreement.nearest_other), percent(agreement.farthest_other));
  if (agreement.failed > 0) text += fmt::format(", {} without a design", agreement.failed);
  return text;
}

/// What to do if the starts do not agree.
std::string disagreement_advice(const DesignReportData& view, const design::StartAgreement& agreement) {
  if (agreement.is_reached() || agreement.starts == 0) return "";
  return fmt::format(
      "the starts do not agree, so that a better one may exist: --starts {}, --seconds {:g} and other seeds "
      "(search: {{seed: 2}}) may find it\n",
      4 * agreement.starts, 4 * view.seconds);
}

/// "proved within 0.8 % of the best" if a bound is that near, else "not shown to be the best".
std::string proof_state(const DesignOutcome& outcome, const char* optimum) {
  constexpr double max_reported_gap = 0.5;
  const double gap = outcome.gap() / std::abs(outcome.objective);
  return outcome.within_limits && gap <= max_reported_gap
             ? fmt::format("proved to be within {:.2g} % of {}", 100 * gap, optimum)
             : fmt::format("not shown to be {}", optimum);
}

/// For which lengths the proof holds, or why there is none.
std::string length_bound_line(const DesignReport& report) {
  const auto& bound = report.length_bound;
  if (!bound || report.outcome.optimality == Optimality::not_optimised) return "";
  if (bound->reason.empty()) return length_coverage_text(*bound) + "\n";
  return report.outcome.optimality == Optimality::proved_global
             ? ""
             : fmt::format("no proof for all lengths: {}\n", bound->reason);
}

/// Of a search over rows of catalogues; other proofs leave no gap.
std::string proved_gap_text(const DesignReportData& view) {
  const DesignOutcome& outcome = view.report.outcome;
  const double gap = (outcome.objective - outcome.lower_bound) / std::abs(outcome.objective);
  const bool has_gap = view.report.catalogue && view.report.catalogue->is_searched && gap > 1e-12;
  return has_gap ? fmt::format("{:.2g} %", 100 * gap) : "0";
}

/// What is known of its optimality.
std::string optimality_line(const DesignReportData& view, const specification::SpecUnits& units) {
  const DesignOutcome& outcome = view.report.outcome;
  const design::StartAgreement agreement = design::compare_starts(outcome.effort.ends, outcome.objective);
  const std::string tried = outcome.effort.ends.size() > 1 ? agreement_text(agreement) : outcome.search_summary;
  const std::string search_summary = tried.empty() ? "" : " (" + tried + ")";
  const DisplayUnit unit = files::find_display_unit(view.objective_unit, units);
  const char* optimum = !outcome.within_limits ? "the smallest violation of the limits"
                        : view.objective.empty() || std::isnan(outcome.objective)
                            ? "the smallest residual of the conditions"
                            : "the best";
  const std::string exhaustion =
      outcome.effort.tried_all_combinations ? fmt::format("; {} were tried", outcome.search_summary) : "";
  switch (outcome.optimality) {
    case Optimality::not_optimised: return "optimality: not-asked: there was nothing to minimize\n";
    case Optimality::proved_global:
      if (!outcome.within_limits)
        return fmt::format("optimality: proved-best: no other choice has a smaller worst limit violation{}\n",
                           exhaustion);
      if (std::isnan(outcome.lower_bound))
        return fmt::format("optimality: proved-best: no other choice has a smaller residual of the conditions{}\n",
                           exhaustion);
      return fmt::format("optimality: proved-best: nothing is below {}, a gap of {}{}\n",
                         files::format_figure(unit.convert(outcome.lower_bound)), proved_gap_text(view), exhaustion);
    case Optimality::local_optimum:
      return fmt::format("optimality: local-best: the best of what was tried{}, {}\n", search_summary,
                         proof_state(outcome, optimum)) +
             disagreement_advice(view, agreement);
    case Optimality::budget_exhausted:
      if (view.interrupted)
        return fmt::format("optimality: stopped: interrupted after {:.2g} s{}, {}\n", *view.interrupted, search_summary,
                           proof_state(outcome, optimum));
      return fmt::format("optimality: stopped: after the time limit of {:g} s{}, {}; --seconds {:g} allows more\n",
                         view.seconds, search_summary, proof_state(outcome, optimum), 4 * view.seconds);
  }
  return "";
}

/// How much of the design could be chosen differently.
std::string freedom_line(const DesignReportData& view) {
  const design::SolutionSet& freedom = view.report.outcome.solution_set;
  const int count = freedom.optimal_dimension >= 0 ? freedom.optimal_dimension : freedom.dimension;
  if (count < 0) return "";
  if (count == 0)
    return fmt::format("freedom: none: no other solution {}is near\n", view.objective.empty() ? "" : "as good ");
  std::string numbers;
  for (const int i : freedom.free_variables)
    numbers += (numbers.empty() ? "" : ", ") + view.report.free_numbers[static_cast<std::size_t>(i)].key_path;
  if (freedom.optimal_dimension < 0)
    return fmt::format("freedom: the conditions leave {}, used for a small {}: {}\n", count, view.objective, numbers);
  const bool has_objective = !view.objective.empty();
  return fmt::format("freedom: {} {} left{}: one of many solutions; what may still change: {}\n", count,
                     count == 1 ? "is" : "are", has_objective ? fmt::format(", with the same {}", view.objective) : "",
                     numbers);
}

/// Keeps each sentence once, although several parts of the report may have it.
class UniqueSentences {
 public:
  void add(const std::string& sentence) {
    if (!sentence.empty() && text_.find(sentence) == std::string::npos) text_ += sentence + "\n";
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// The statement of a proof with its coefficients and its bound in other units.
std::string statement_text(const conditions::InfeasibilityCertificate& proof,
                           const std::vector<dynamics::Parameter>& parameters, const specification::SpecUnits& units) {
  const bool is_of_conditions =
      proof.coefficients.size() > 0 && proof.coefficients.size() == static_cast<Eigen::Index>(parameters.size());
  if (!is_of_conditions) return proof.statement;
  const std::string combination = conditions::linear_combination_text(parameters, proof.coefficients);
  if (!proof.statement.starts_with(combination)) return proof.statement;
  // the sum has the unit of the parameter whose coefficient is 1
  const Eigen::Index reference = numerics::min_index((proof.coefficients.cwiseAbs().array() - 1).abs());
  const DisplayUnit unit = files::find_display_unit(unit_of(parameters[static_cast<std::size_t>(reference)]), units);
  VectorX coefficients = proof.coefficients;
  for (Eigen::Index p = 0; p < coefficients.size(); ++p)
    coefficients[p] *=
        files::find_display_unit(unit_of(parameters[static_cast<std::size_t>(p)]), units).factor / unit.factor;
  std::string text = conditions::linear_combination_text(parameters, coefficients);
  if (proof.minimum == 0) return text + proof.statement.substr(combination.size());
  return text + fmt::format(" = 0 cannot hold within the bounds: the left-hand side is at least {:.3g} {}",
                            unit.convert(proof.minimum), unit.name);
}

std::string reasons(const DesignReportData& view, const specification::SpecUnits& units) {
  UniqueSentences sentences;
  const DesignOutcome& outcome = view.report.outcome;
  const auto& proof = outcome.certificate;
  const std::string proved = proof ? statement_text(*proof, outcome.conditions.parameters, units) : "";
  sentences.add(proof && outcome.reason == proof->statement ? proved : outcome.reason);
  sentences.add(proved);
  if (outcome.status == DesignStatus::infeasible)
    sentences.add(outcome.is_proved_infeasible ? "impossibility: proved" : "impossibility: not proved");
  return sentences.text() + objective_line(view, units) + limits_text(view, units) +
         format_optional_elements(view.report) + optimality_line(view, units) + length_bound_line(view.report) +
         freedom_line(view);
}

/// Which numbers were asked to have different sizes.
std::string different_numbers_text(const DesignReport& report) {
  std::string text;
  for (const study::DifferentNumbers& different : report.study_before.design.all_different)
    if (different.numbers.size() > 1) text += fmt::format("all different: {}\n", joined(paths_of(report, different)));
  return text;
}

/// Explains "before" for numbers without a start value.
std::string format_start_note(const std::vector<FreeNumber>& numbers) {
  constexpr std::size_t max_listed_paths = 3;
  std::vector<std::string> paths;
  for (const FreeNumber& number : numbers)
    if (number.start_source == FreeNumber::StartSource::midpoint) paths.push_back(number.key_path);
  if (paths.empty()) return "";
  if (paths.size() > max_listed_paths)
    return fmt::format("before: in the middle of the bounds where the spec has no 'start' ({} numbers)\n",
                       paths.size());
  return fmt::format("before: in the middle of the bounds, without a 'start': {}\n", fmt::join(paths, ", "));
}

std::string numbers_text(const DesignReportData& view, const files::TextOptions& options) {
  const DesignReport& report = view.report;
  if (report.free_numbers.empty()) return "";
  files::TextTable table = files::rows_table<DesignedNumber>(
      list_designed_numbers(report), designed_number_fields(options), options.units,
      [&](const DesignedNumber& one) { return find_number_unit(one.key_path, options); });
  table.key_columns = 2;
  remove_empty_units(table);
  return format_table(table, options.width) + different_numbers_text(report) + format_start_note(report.free_numbers) +
         "\n";
}

std::string residual_text(double residual) {
  if (std::isnan(residual)) return "-";
  return std::abs(residual) <= design::condition_tolerance ? "met" : fmt::format("{:.2g}", std::abs(residual));
}

constexpr std::size_t residual_columns = 24;  ///< of the number and the residuals beside a condition

std::string conditions_table(const DesignReportData& view, const files::TextOptions& options) {
  const ConditionsReportData c = convert_coefficients(view.conditions, options.units);
  files::TextTable table{
      {"no", "condition", "before", "after"}, {Align::right, Align::left, Align::right, Align::right}, {}};
  std::vector<int> symmetric_rows;
  for (int row = 0; row < c.parameter_rows(); ++row) {
    if (c.holds_by_definition[static_cast<std::size_t>(row)]) {
      symmetric_rows.push_back(row + 1);
      continue;
    }
    const auto lines = wrap_condition(c, row, options.width - std::min(options.width / 2, residual_columns));
    for (std::size_t i = 0; i < lines.size(); ++i)
      table.rows.push_back({i == 0 ? std::to_string(row + 1) : "", lines[i],
                            i == 0 ? residual_text(view.residuals_before[row]) : "",
                            i == 0 ? residual_text(c.residuals[row]) : ""});
  }
  std::string text = table.rows.empty() ? "" : format_table(table, options.width);
  const std::string symbols = symbols_text(c, options.units);
  if (!symbols.empty()) text += "where " + symbols + "\n";
  if (!symmetric_rows.empty())
    text += fmt::format("{} {} for every disc that is symmetrical about its axis\n", format_ranges(symmetric_rows),
                        symmetric_rows.size() == 1 ? "holds" : "hold");
  text += orders_text(view.conditions, options) + format_remainder(c, options.units);
  return text.empty() ? "" : text + "\n";
}

bool has_balancing_elements(const Mechanism& mechanism) {
  return !mechanism.discs.empty() ||
         std::any_of(mechanism.attachments.begin(), mechanism.attachments.end(),
                     [](const Attachment& one) { return one.kind == AttachmentKind::counterweight; });
}

std::string cost_text(const DesignReport& report, const specification::SpecUnits& units) {
  const DisplayUnit mass = files::find_display_unit("kg", units), inertia = files::find_display_unit("kg m^2", units);
  const auto describe_total = [](double before, double after, const DisplayUnit& unit) {
    return fmt::format("{:.6g} {} before, {:.6g} {} after", unit.convert(before), unit.name, unit.convert(after),
                       unit.name);
  };
  const std::string total_mass = describe_total(report.mass_before, report.mass_after, mass),
                    total_inertia = describe_total(report.inertia_before, report.inertia_after, inertia);
  if (!has_balancing_elements(report.study_after.mechanism) && report.added_mass == 0 && report.added_inertia == 0)
    return fmt::format("moving mass     {}\nmoving inertia  {}\n", total_mass, total_inertia);
  const auto format_amount = [](double value, double scale, const DisplayUnit& unit) {
    return (std::abs(value) <= 1e-12 * scale ? "0" : fmt::format("{:.6g}", unit.convert(value))) + " " + unit.name;
  };
  return fmt::format(
      "added mass     {} of counterweights and discs (everything that moves: {})\n"
      "added inertia  {} of them (everything that moves: {})\n",
      format_amount(report.added_mass, report.mass_after, mass), total_mass,
      format_amount(report.added_inertia, report.inertia_after, inertia), total_inertia);
}

/// Notes on the motion, once if before and after have the same.
std::string rerun_notes(const TrajectoryComparison& comparison) {
  const auto &before = comparison.before.outcome.notes, &after = comparison.after.outcome.notes;
  const auto contains = [](const std::vector<std::string>& notes, const std::string& note) {
    return std::find(notes.begin(), notes.end(), note) != notes.end();
  };
  std::string text;
  for (const std::string& note : before)
    text += fmt::format("note{}: {}\n", contains(after, note) ? "" : ", before", note);
  for (const std::string& note : after)
    if (!contains(before, note)) text += fmt::format("note, after: {}\n", note);
  return text;
}

std::string comparison_text(const TrajectoryComparison& comparison, const files::TextOptions& options) {
  std::string text = fmt::format("\ntrajectory {}\n", comparison.trajectory);
  const bool are_both_done =
      comparison.before.outcome.status == MotionStatus::done && comparison.after.outcome.status == MotionStatus::done;
  for (const auto& [when, result] : {std::pair("before", &comparison.before), std::pair("after", &comparison.after)})
    if (result->outcome.status != MotionStatus::done)
      text += fmt::format("cannot be followed {}: {}\n", when, result->outcome.reason);
  if (!are_both_done) return text + rerun_notes(comparison);
  files::TextTable table{
      {"quantity", "unit", "peak before", "after", "ratio", "rms before", "after", "ratio"}, {}, {}, 2, {2, 5}};
  table.align.assign(table.heading.size(), Align::right);
  table.align[0] = table.align[1] = Align::left;
  const std::vector<MetricChange> changes = list_metric_changes(comparison);
  const std::size_t actuators = comparison.before.actuator_names.size();
  for (std::size_t i = 0; i + 1 < changes.size(); i += 2) {
    const bool is_worst = changes[i].quantity == "torque";
    if (is_worst && actuators == 1) continue;  // it has a row of its own
    const DisplayUnit unit = files::find_display_unit(changes[i].unit, options.units);
    std::vector<std::string> row = {is_worst ? "worst torque" : changes[i].quantity, unit.name};
    for (const MetricChange& change : {changes[i], changes[i + 1]}) {
      row.push_back(files::format_figure(unit.convert(change.before)));
      row.push_back(files::format_figure(unit.convert(change.after)));
      row.push_back(ratio_text(change.before, change.after));
    }
    table.rows.push_back(std::move(row));
  }
  return (table.rows.empty() ? text : text + format_table(table, options.width)) + rerun_notes(comparison);
}

bool is_named(const DesignReportData& view, const std::string& trajectory) {
  return view.trajectories.empty() ||
         std::find(view.trajectories.begin(), view.trajectories.end(), trajectory) != view.trajectories.end();
}

/// "peak +23 %" or "rms x 7.3".
std::string increase_text(const MetricChange& change) {
  const double ratio = change.after / change.before;
  if (change.before == 0) return change.figure + " from 0";
  return ratio < 2 ? fmt::format("{} +{:.2g} %", change.figure, 100 * (ratio - 1))
                   : fmt::format("{} x {:.3g}", change.figure, ratio);
}

/// Figures along a trajectory that are larger than before, as a sentence; empty if there are none. Of several torques
/// only the worst counts, and the moment about the centre of mass is a part of another.
std::string losses_text(const TrajectoryComparison& comparison) {
  constexpr double min_relative_increase = 1e-3;
  std::vector<std::pair<std::string, std::string>> losses;  // quantity, its figures
  const bool has_one_actuator = comparison.before.actuator_names.size() == 1;
  for (const MetricChange& change : list_metric_changes(comparison)) {
    if (!(change.after > (1 + min_relative_increase) * change.before) || change.quantity == "shaking_moment_com")
      continue;
    const bool is_worst = change.quantity == "torque";
    if (is_worst ? has_one_actuator : !has_one_actuator && !change.quantity.starts_with("shaking_")) continue;
    const std::string quantity = is_worst ? "worst torque" : change.quantity;
    if (losses.empty() || losses.back().first != quantity) losses.emplace_back(quantity, "");
    losses.back().second += (losses.back().second.empty() ? "" : ", ") + increase_text(change);
  }
  if (losses.empty()) return "";
  std::string text = fmt::format("worse than before along {}: ", comparison.trajectory);
  for (std::size_t i = 0; i < losses.size(); ++i)
    text += fmt::format("{}{} ({})", i == 0 ? "" : ", ", losses[i].first, losses[i].second);
  return text + "\n";
}

/// "parameters.b: no larger value is possible ('go' cannot be followed: …)"
std::string edges_text(const DesignReport& report) {
  std::string text;
  for (const design::FeasibilityEdge& edge : report.outcome.edges)
    text += fmt::format("note: {} is at the end of what can be assembled and moved; with a slightly {} value: {}\n",
                        report.free_numbers[static_cast<std::size_t>(edge.variable)].key_path,
                        edge.is_upper ? "larger" : "smaller", edge.reason);
  return text;
}

std::string notes_text(const DesignReportData& view) {
  std::string text = edges_text(view.report);
  for (const auto* notes : {&view.report.outcome.notes, &view.report.notes, &view.conditions.conditions.notes,
                            &view.conditions.names.notes})
    for (const std::string& note : *notes)
      if (text.find(note) == std::string::npos) text += "note: " + note + "\n";
  return text.empty() ? "" : "\n" + text;
}

}  // namespace

std::string design_text(const DesignReportData& view, const files::TextOptions& options) {
  std::string losses, comparisons;
  std::vector<std::string> hidden;
  for (const TrajectoryComparison& comparison : view.report.comparisons) {
    if (!options.verbose && !is_named(view, comparison.trajectory)) {
      hidden.push_back(comparison.trajectory);
      continue;
    }
    losses += losses_text(comparison);
    comparisons += comparison_text(comparison, options);
  }
  if (!hidden.empty()) comparisons += fmt::format("\nalong {}: see --verbose\n", joined(hidden));
  const std::string text =
      fmt::format("{}: {}\n{}{}\n", view.conditions.title, headline(view), reasons(view, options.units), losses) +
      parts_text(view.report.catalogue, view.objective_unit, options) + numbers_text(view, options) +
      conditions_table(view, options) + cost_text(view.report, options.units) +
      load_cases_text(view.report, options, hidden) + comparisons + notes_text(view);
  return files::wrap_lines(text, options.width);
}

namespace {

std::string term_text(const ObjectiveTerm& term) {
  if (term.size != ObjectiveTerm::Size::none || term.run != ObjectiveTerm::RunMeasure::figure)
    return design::objective_term_name(term);
  const std::string figure =
      fmt::format("{} of {} along {}", design::objective_term_name(term.figure), term.quantity, term.trajectory);
  return term.deviation_multiple ? fmt::format("mean plus {:g} deviation{} of the {}", *term.deviation_multiple,
                                               *term.deviation_multiple == 1 ? "" : "s", figure)
                                 : figure;
}

bool is_shown(const std::string& quantity) {
  return results::effort_array_name(quantity).starts_with("torque") || quantity.starts_with("shaking_");
}

const Metric* find(const RunResult& result, const std::string& quantity) {
  for (const Metric& metric : result.metrics)
    if (metric.quantity == quantity) return &metric;
  return nullptr;
}

}  // namespace

std::string objective_text(const std::vector<ObjectiveTerm>& terms) {
  std::string text;
  for (const ObjectiveTerm& term : terms) {
    if (!text.empty()) text += " + ";
    if (term.weight != 1) text += fmt::format("{:g} ", term.weight);
    text += term_text(term);
  }
  return text;
}

std::vector<MetricChange> list_metric_changes(const TrajectoryComparison& comparison) {
  constexpr double unknown_value = std::numeric_limits<double>::quiet_NaN();
  const RunResult &before = comparison.before, &after = comparison.after;
  std::vector<MetricChange> changes;
  for (const Metric& metric : (before.metrics.empty() ? after : before).metrics) {
    if (!is_shown(metric.quantity)) continue;
    const Metric *before_metric = find(before, metric.quantity), *after_metric = find(after, metric.quantity);
    // round-off of the terms of either mechanism
    const double round_off = std::max(before_metric != nullptr ? before_metric->round_off : 0,
                                      after_metric != nullptr ? after_metric->round_off : 0);
    const auto add = [&](const char* figure, double Metric::*value) {
      const double before_value = before_metric != nullptr ? before_metric->*value : unknown_value,
                   after_value = after_metric != nullptr ? after_metric->*value : unknown_value;
      changes.push_back({metric.quantity, metric.unit, figure, results::suppress_round_off(round_off, before_value),
                         results::suppress_round_off(round_off, after_value)});
    };
    add("peak", &Metric::peak);
    add("rms", &Metric::rms);
  }
  return changes;
}

}  // namespace balance::reports
