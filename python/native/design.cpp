#include "arrays.hpp"
#include "background_task.hpp"
#include "bindings.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/reports/conditions_sections.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/interface/reports/designed_spec.hpp"
#include "balance/interface/reports/front_sections.hpp"
#include "balance/interface/specification/read_options.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/conditions/infeasibility_certificate.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"
#include "balance/synthesis/design/status_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance::python {
namespace {

/// Conditions in all requested output formats, computed once.
struct DerivedConditions {
  reports::RequestFailure refusal;
  std::string json, text, latex, impossible;
  Samples matrix;
};

py::dict conditions(const std::shared_ptr<Spec>& spec, const std::vector<std::string>& goals,
                    const std::vector<std::string>& without, const std::string& strategy,
                    std::optional<std::uint64_t> seed, bool named, const std::string& speeds) {
  const Study& study = spec->study();
  reports::BalanceRequest request = question_of({goals, without, strategy, seed}, study);
  if (request.goals.empty()) request.goals = study.design.goals;
  if (request.goals.empty())
    throw std::invalid_argument(spec->file +
                                " has no design: goal, so a goal is needed: " + join_alternatives(study::goal_names()));
  if (!speeds.empty()) {
    if (request.is_modular) throw std::invalid_argument("speeds cannot be combined with strategy 'modular'");
    request.speeds = specification::read_speeds(speeds, "speeds", specification::SpeedUse::quasi_velocity, study);
  }
  DerivedConditions derived = compute_in_background([spec, request, named](BackgroundTask&) {
    const reports::ConditionsOutcome outcome = derive_conditions_data(request, *spec->space, named);
    DerivedConditions all;
    all.refusal = outcome.refusal;
    if (outcome.refusal) return all;
    all.json = files::format_json(conditions_json(outcome.view, spec->study().warnings));
    all.text = conditions_text(outcome.view, files::make_text_options(spec->study().spec_text));
    all.latex = conditions_latex(outcome.view.conditions, outcome.view.names);
    all.matrix = outcome.view.conditions.matrix;
    const Mechanism start =
        simulation::assembled_at(spec->study().mechanism, simulation::start_coordinates(spec->study()));
    if (const auto proof = certify_infeasible(outcome.view.conditions, start)) all.impossible = proof->statement;
    return all;
  });
  if (derived.refusal) refuse(derived.refusal);
  py::dict all;
  all["json"] = derived.json;
  all["text"] = derived.text;
  all["latex"] = derived.latex;
  all["impossible"] = derived.impossible.empty() ? py::object(py::none()) : py::str(derived.impossible);
  all["matrix"] = owned(std::move(derived.matrix));
  return all;
}

const std::vector<std::string> strategies{"complete", "modular"};

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

DesignStudyOptions design_options(const Spec& spec, const GoalArguments& arguments, const std::string& minimize,
                                  const std::string& algorithm, bool trajectories) {
  const Study& study = spec.study();
  const reports::BalanceRequest request = question_of(arguments, study);
  DesignStudyOptions options;
  options.is_modular = request.is_modular;
  options.excluded = request.excluded;
  options.goals = request.goals.empty() ? study.design.goals : request.goals;
  if (!minimize.empty()) options.minimize = specification::read_objective(minimize, study);
  options.search = study.design.search;
  if (arguments.seed) options.search.seed = *arguments.seed;
  options.compare_trajectories = trajectories;
  if (contains(study::global_methods(), algorithm)) {
    options.search.global = algorithm;
  } else if (!algorithm.empty()) {
    require_one_of(study::local_methods(), algorithm, "algorithm");
    options.search.local = algorithm;
  }
  if (options.goals.empty() && options.minimize.empty() && study.design.minimize.empty() &&
      study.design.subject_to.empty() && !study.design.front)
    throw std::invalid_argument(spec.file + " has neither design: goal nor design: minimize, so a goal (" +
                                join_alternatives(study::goal_names()) + ") or something to minimize is needed");
  if (study.free_numbers.empty())
    throw SpecError({.place = {.file = spec.file},
                     .message =
                         "there is nothing to design: no number is free; write {free: [lower, upper]} in place of a "
                         "number, for instance mass: {free: [0, 10]} of a counterweight"});
  return options;
}

struct MadeDesign {
  reports::RequestFailure refusal;
  std::shared_ptr<Design> design;
};

std::shared_ptr<Design> design(const std::shared_ptr<Spec>& spec, const std::vector<std::string>& goals,
                               const std::vector<std::string>& without, const std::string& strategy,
                               std::optional<std::uint64_t> seed, const std::string& minimize,
                               const std::string& algorithm, bool trajectories, const std::string& command) {
  const DesignStudyOptions options =
      design_options(*spec, {goals, without, strategy, seed}, minimize, algorithm, trajectories);
  MadeDesign result = compute_in_background([spec, options](BackgroundTask& task) {
    DesignStudyOptions watched = options;
    watched.on_progress = [&task](const design::SearchProgress& progress) {
      task.set_progress(progress.seconds / progress.max_time);
      return !task.is_cancelled();
    };
    MadeDesign all;
    DesignReport report = run_design_study(*spec->space, watched);
    all.refusal = reports::find_failure(report);
    if (all.refusal) return all;
    reports::DesignedSpec spec_of_design = reports::format_designed_spec(*spec->space, report);
    all.refusal = spec_of_design.refusal;
    if (all.refusal) return all;
    all.design = std::make_shared<Design>();
    all.design->spec_text = std::move(spec_of_design.text);
    all.design->view = reports::make_design_data(options, *spec->space, all.design->spec_text, std::move(report));
    return all;
  });
  if (result.refusal) refuse(result.refusal);
  result.design->description = files::make_provenance(spec->study(), command);
  result.design->text_options = files::make_design_text_options(spec->study());
  result.design->source = spec->file;
  return result.design;
}

/// A Pareto front; immutable.
struct FoundFront {
  std::shared_ptr<const Spec> spec;
  DesignStudyOptions options;
  reports::FrontReportData view;
  std::string command;
};

std::shared_ptr<FoundFront> front(const std::shared_ptr<Spec>& spec, const std::vector<std::string>& goals,
                                  const std::vector<std::string>& without, const std::string& strategy,
                                  std::optional<std::uint64_t> seed, const std::string& algorithm,
                                  const std::string& command) {
  auto result = std::make_shared<FoundFront>();
  result->spec = spec;
  result->options = design_options(*spec, {goals, without, strategy, seed}, "", algorithm, true);
  result->command = command;
  const reports::RequestFailure refusal = compute_in_background([result](BackgroundTask& task) {
    DesignStudyOptions watched = result->options;
    watched.on_progress = [&task](const design::SearchProgress& progress) {
      task.set_progress(progress.seconds / progress.max_time);
      return !task.is_cancelled();
    };
    design::ParetoFront front = compute_pareto_front(*result->spec->space, watched);
    const reports::RequestFailure none =
        front.points.empty() ? reports::find_failure(front.failure) : reports::RequestFailure{};
    result->view = reports::make_front_report_data(result->options, *result->spec->space, std::move(front));
    return none;
  });
  if (refusal) refuse(refusal);
  return result;
}

/// @param k zero-based
std::shared_ptr<Design> front_point(const FoundFront& front, std::size_t k) {
  const auto& points = front.view.front.points;
  if (k >= points.size()) throw std::invalid_argument(fmt::format("the front has {} points", points.size()));
  const design::ParetoPoint& point = points[k];
  auto result = std::make_shared<Design>();
  DesignReport report = make_pareto_design(*front.spec->space, point, true);
  reports::DesignedSpec spec_of_design = reports::format_designed_spec(*front.spec->space, report);
  if (spec_of_design.refusal) refuse(spec_of_design.refusal);
  result->spec_text = std::move(spec_of_design.text);
  result->view = reports::make_design_data(front.options, point.space, result->spec_text, std::move(report));
  result->description = files::make_provenance(front.spec->study(), fmt::format("{} --point {}", front.command, k + 1));
  result->text_options = files::make_design_text_options(front.spec->study());
  result->source = front.spec->file;
  return result;
}

py::list values_of(const Design& design) {
  const DesignReport& report = design.view.report;
  py::list all;
  for (std::size_t i = 0; i < report.free_numbers.size(); ++i)
    all.append(py::make_tuple(report.free_numbers[i].key_path, report.outcome.x[static_cast<Eigen::Index>(i)]));
  return all;
}

/// @param after true: runs of the designed mechanism
py::dict runs_of(const Design& design, bool after) {
  const DesignReport& report = design.view.report;
  Study study = after ? report.study_after : report.study_before;
  if (after) study.spec_text = design.spec_text, study.overrides.clear();  // the designed spec already contains them
  py::dict all;
  for (const design::TrajectoryComparison& one : report.comparisons) {
    auto run = std::make_shared<Run>();
    run->result = after ? one.after : one.before;
    for (const Trajectory& trajectory : study.trajectories)
      if (trajectory.name == one.trajectory)
        run->description = files::make_simulation_provenance(
            study, trajectory, {.spec_file = study.spec_file, .trajectory = one.trajectory});
    run->source = design.source;
    all[py::str(one.trajectory)] = run;
  }
  return all;
}

}  // namespace

void require_one_of(const std::vector<std::string>& names, const std::string& name, const char* what) {
  if (!contains(names, name))
    throw std::invalid_argument(fmt::format("{} {}: expected {}{}", what, quote_for_message(name),
                                            join_alternatives(names), append_nearest_name(name, names)));
}

reports::BalanceRequest question_of(const GoalArguments& arguments, const Study& study) {
  reports::BalanceRequest request;
  for (const std::string& name : arguments.goals) {
    if (const auto mistake = study::find_goal_mistake(name, study.mechanism, study.trajectories))
      throw std::invalid_argument(fmt::format("goal {}: {}", quote_for_message(name), mistake->sentence()));
    const Goal goal = study::find_goal(name).value();
    if (std::find(request.goals.begin(), request.goals.end(), goal) == request.goals.end())
      request.goals.push_back(goal);
  }
  require_one_of(strategies, arguments.strategy, "strategy");
  for (const std::string& name : arguments.without)
    require_one_of(conditions::list_excludable_names(study.mechanism), name, "without");
  request.is_modular = arguments.strategy == "modular";
  request.excluded = arguments.without;
  request.seed = arguments.seed;
  return request;
}

void bind_balancing(py::module_& m) {
  m.def("conditions", &conditions, py::arg("spec"), py::arg("goals"), py::arg("without"), py::arg("strategy"),
        py::arg("seed"), py::arg("named"), py::arg("speeds"));
  m.def("design", &design, py::arg("spec"), py::arg("goals"), py::arg("without"), py::arg("strategy"), py::arg("seed"),
        py::arg("minimize"), py::arg("algorithm"), py::arg("trajectories"), py::arg("command"));
  m.def("front", &front, py::arg("spec"), py::arg("goals"), py::arg("without"), py::arg("strategy"), py::arg("seed"),
        py::arg("algorithm"), py::arg("command"));
  py::class_<FoundFront, std::shared_ptr<FoundFront>>(m, "Front")
      .def("json", [](const FoundFront& one) { return files::format_json(reports::front_json(one.view, {})); })
      .def("text",
           [](const FoundFront& one) {
             return front_text(one.view, files::make_design_text_options(one.spec->study()));
           })
      .def("csv", [](const FoundFront& one) { return front_csv(one.view); })
      .def("design", &front_point, py::arg("k"));
  m.attr("goal_names") = study::goal_names();
  py::class_<Design, std::shared_ptr<Design>>(m, "Design")
      .def_readonly("spec_text", &Design::spec_text)
      .def_property_readonly("status", [](const Design& one) { return name_of(one.view.report.outcome.status); })
      .def_property_readonly("optimality",
                             [](const Design& one) { return name_of(one.view.report.outcome.optimality); })
      .def_property_readonly("reason", [](const Design& one) { return one.view.report.outcome.reason; })
      .def_property_readonly("values", &values_of)
      .def("runs", &runs_of, py::arg("after"))
      .def("json", [](const Design& one) { return files::format_json(reports::design_json(one.view, {})); })
      .def("text", [](const Design& one) { return design_text(one.view, one.text_options); })
      .def(
          "write",
          [](const Design& one, const std::string& path, bool force) {
            files::WriteOptions options;
            options.existing = force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
            options.is_cancelled = [] { return PyErr_CheckSignals() != 0; };
            check_overwrites_no_source(path, one.description.spec_text, one.source);
            write_design(path, one.view, one.description, options);
          },
          py::arg("path"), py::arg("force"));
}

}  // namespace balance::python
