#include "balance/interface/batch/case_run.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/bracketed_root.hpp"
#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/figure_evaluation.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/sha256.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/interface/reports/designed_spec.hpp"
#include "balance/interface/reports/modes_request.hpp"
#include "balance/interface/reports/report_data.hpp"
#include "balance/interface/specification/diagnostics.hpp"
#include "balance/interface/specification/display_units.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/spec_locations.hpp"
#include "balance/mechanics/dynamics/single_state.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/control/closed_loop_run.hpp"
#include "balance/motion/control/controller_error.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/prediction.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/synthesis/design/catalogue_search.hpp"
#include "balance/synthesis/design/design_study.hpp"
#include "balance/synthesis/design/status_names.hpp"
#include "balance/synthesis/formulas/equations_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <new>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

namespace balance::batch {
namespace {

/// The mechanism cannot do what the case asks.
struct CaseFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a case computed, as far as it came. Its parts refer to each other, so it stays where it is.
struct CaseSubject {
  std::optional<Study> study;
  std::optional<DesignReport> design;
  std::string objective_unit;
  std::optional<Trajectory> trajectory;
  std::optional<RunResult> run;
  std::optional<Mechanism> moving_mechanism;  ///< of the run, if it is not the study's
  std::optional<formulas::EquationsAtConfiguration> equations;
  std::optional<comparison::ConditionsFigures> conditions;
  std::optional<reports::VibrationReportData> vibration;
  std::vector<results::FigurePoint> points;
  std::vector<comparison::FigureNumber> numbers;

  CaseSubject() = default;
  CaseSubject(const CaseSubject&) = delete;
  CaseSubject& operator=(const CaseSubject&) = delete;

  comparison::FigureSubject view() const {
    return {.run = run ? &*run : nullptr,
            .mechanism = moving_mechanism ? &*moving_mechanism
                         : study          ? &study->mechanism
                                          : nullptr,
            .points = points,
            .design = design ? &*design : nullptr,
            .objective_unit = objective_unit,
            .equations = equations ? &*equations : nullptr,
            .conditions = conditions,
            .modes = vibration ? &vibration->modes : nullptr,
            .sweep = vibration && vibration->sweep ? &*vibration->sweep : nullptr,
            .numbers = numbers};
  }
};

class CaseRun {
 public:
  CaseRun(const BatchPlan& plan, std::size_t index, const std::string& folder, StoredOutput stored_output,
          ParsedSpecCache& spec_cache, CaseRecord& record)
      : suite_case_(plan.suite.cases[index]),
        asked_figures_(plan.cases[index].figures),
        spec_(plan.specs[plan.cases[index].spec]),
        folder_(folder),
        stored_output_(stored_output),
        spec_cache_(spec_cache),
        overrides_(suite_case_.overrides),
        record_(record) {
    const std::size_t spec = plan.cases[index].spec;
    if (!spec_cache.document || spec_cache.index != spec) spec_cache = {spec, specification::SpecDocument(spec_.text)};
  }

  void run() {
    if (!spec_.failure_reason.empty())
      throw SystemError(suite_case_.location_of("spec").text() + ": " + spec_.failure_reason);
    solve_parameters(0);
    is_final_ = true;
    CaseSubject subject;
    try {
      compute(subject);
    } catch (const CaseFailed&) {
      if (subject.design) add_figures(subject);  // the verdict of a design that failed is a figure
      throw;
    }
    add_figures(subject);
    if (subject.run && subject.trajectory && stored_output_ == StoredOutput::series)
      write(*subject.run, describe(*subject.study, *subject.trajectory));
    record_.status = "done";
    if (!record_.design || record_.design->status == "balanced" || record_.design->status == "not-asked") return;
    record_.status = "compromise";
    record_.message = "the design is not balanced: " + record_.design->reason;
  }

 private:
  /// Computes the case with the present overrides.
  void compute(CaseSubject& subject) {
    subject.numbers = solved_numbers_;
    if (suite_case_.kind == CaseKind::conditions) return derive_conditions(subject);
    if (suite_case_.kind == CaseKind::design || suite_case_.design)
      run_design(subject);
    else
      subject.study =
          read([this](const ReadOptions& options) { return read_spec(*spec_cache_.document, spec_.path, options); });
    const Study& study = *subject.study;
    set_title(study);
    if (suite_case_.kind == CaseKind::design) return;
    subject.points = resolve_points(study.mechanism);
    if (suite_case_.kind == CaseKind::equations) return evaluate_state(subject);
    if (suite_case_.kind == CaseKind::modes) return find_modes(subject);
    // a design needs no motion: without one, its figures are the whole result
    const bool has_motion =
        !study.trajectories.empty() || !suite_case_.trajectory.empty() || !suite_case_.controller.empty();
    if (has_motion || !subject.design) run_trajectory(subject);
  }

  void set_title(const Study& study) {
    if (!is_final_) return;
    record_.title = study.mechanism.name;
    record_.warnings = study.warnings;
  }

  void run_trajectory(CaseSubject& subject) {
    const Study& study = *subject.study;
    subject.trajectory = choose_trajectory(study);
    if (is_final_) {
      record_.trajectory = subject.trajectory->name;
      record_.samples = subject.trajectory->samples;
    }
    subject.run = run_or_throw(study, *subject.trajectory);
    if (!subject.trajectory->adaptations.empty())
      subject.moving_mechanism = mechanism_along(study, subject.trajectory->name);
    if (!is_final_) return;
    const std::vector<std::string>& notes = subject.run->outcome.notes;
    record_.notes.insert(record_.notes.end(), notes.begin(), notes.end());
  }

  /// The case's table of figures: its metrics, and what is asked of it.
  comparison::MetricTable make_table(const CaseSubject& subject,
                                     const std::vector<comparison::FigureReference>& asked) const {
    comparison::MetricTable table;
    table.name = suite_case_.name;
    if (subject.run && subject.trajectory) table = comparison::make_metric_table(suite_case_.name, *subject.run);
    comparison::FigureEvaluator evaluator(subject.view());
    evaluate_figures(asked, evaluator, table);
    return table;
  }

  void add_figures(const CaseSubject& subject) {
    comparison::MetricTable table = make_table(subject, asked_figures_);
    record_.metrics = std::move(table.metrics);
    record_.energy = table.energy;
    record_.figures = std::move(table.figures);
  }

  // Parameters that are solved for.

  /// Solves for the parameters from the i-th on, at the present values of those before it.
  void solve_parameters(std::size_t i) {
    if (i == suite_case_.solved.size()) return;
    const SolvedParameter& solved = suite_case_.solved[i];
    std::string unit;
    const auto evaluate_at = [&](double x) { return evaluate_solved_figure(i, x, unit) - solved.value; };
    const double at_lower = evaluate_at(solved.lower), at_upper = evaluate_at(solved.upper);
    const std::string unit_text = unit.empty() ? "" : " " + unit;
    if (at_lower * at_upper > 0)
      throw CaseFailed(
          fmt::format("solve {0}: {1} is {2:.6g}{6} at {0} = {3:.6g} and {4:.6g}{6} at {0} = {5:.6g}: it "
                      "does not pass {7:.6g} between them",
                      solved.parameter, solved.figure.text, at_lower + solved.value, solved.lower,
                      at_upper + solved.value, solved.upper, unit_text, solved.value));
    if (at_lower == 0 && at_upper == 0)
      throw CaseFailed(
          fmt::format("solve {0}: {1} is {2:.6g}{3} at {0} = {4:.6g} and at {0} = {5:.6g}: it does not "
                      "determine {0}, or the bracket has more than one root",
                      solved.parameter, solved.figure.text, solved.value, unit_text, solved.lower, solved.upper));
    constexpr double relative_tolerance = 1e-12;
    const double root =
        numerics::find_bracketed_root(evaluate_at, solved.lower, solved.upper, at_lower, at_upper, relative_tolerance);
    // at a jump or a pole the sign changes, too, but no value is near the one asked for
    constexpr double residual_tolerance = 1e-6;  // relative to the bracket's ends
    const double residual = evaluate_at(root);   // leaves this parameter and those after it solved
    if (std::abs(residual) > residual_tolerance * std::max(std::abs(at_lower), std::abs(at_upper)))
      throw CaseFailed(fmt::format("solve {0}: {1} jumps past {2:.6g}{3} at {0} = {4:.6g}, where it is {5:.6g}{3}",
                                   solved.parameter, solved.figure.text, solved.value, unit_text, root,
                                   residual + solved.value));
    record_.solved.clear();
    for (const comparison::FigureNumber& number : solved_numbers_)
      record_.solved.emplace_back(number.path, number.value);
  }

  /// Gives the i-th solved parameter a value and forgets those after it.
  void set_solved(std::size_t i, double value) {
    overrides_.resize(suite_case_.overrides.size() + i);
    overrides_.emplace_back(suite_case_.solved[i].parameter, fmt::format("{}", value));
    solved_numbers_.resize(i);
    solved_numbers_.push_back({suite_case_.solved[i].parameter, value});
  }

  /// The figure of the i-th solved parameter at one of its values, with those after it solved for.
  double evaluate_solved_figure(std::size_t i, double x, std::string& unit) {
    const SolvedParameter& solved = suite_case_.solved[i];
    set_solved(i, x);
    solve_parameters(i + 1);
    CaseSubject subject;
    try {
      compute(subject);
      const comparison::MetricTable table = make_table(subject, solved.figure.figures);
      const comparison::ExpressionAnswer answer = comparison::evaluate_expression(solved.figure, {table}, 0);
      if (!answer.missing.empty()) throw CaseFailed(answer.missing.front());
      if (!std::isfinite(answer.value)) throw CaseFailed(solved.figure.text + " has no value");
      unit = answer.unit;
      return answer.value;
    } catch (const CaseFailed& error) {
      throw CaseFailed(fmt::format("solve {0}: at {0} = {1:.6g}: {2}", solved.parameter, x, error.what()));
    } catch (const comparison::RequirementError& error) {
      const std::string key = "solve." + solved.parameter;
      throw SpecError({suite_case_.location_of(key), fmt::format("figure: {}", error.what())});
    }
  }

  // Cases without a motion.

  /// A name that is none of the known ones. @param expected "a body of arm.yaml"
  [[noreturn]] static void fail_unknown(const SourceLocation& location, const std::string& expected,
                                        const std::string& name, const std::vector<std::string>& known) {
    fail(location, {.expected = fmt::format("{} ({})", expected, join_alternatives(known)),
                    .found = quote_for_message(name),
                    .hint = format_nearest_name(name, known)});
  }

  [[noreturn]] static void fail(const SourceLocation& location, const specification::ErrorMessage& message) {
    throw SpecError({location, message.text(), message.expected, message.found, message.hint});
  }

  std::vector<results::FigurePoint> resolve_points(const Mechanism& mechanism) const {
    std::vector<results::FigurePoint> points;
    for (const CasePoint& point : suite_case_.points) {
      const SourceLocation location = suite_case_.location_of("points." + point.name);
      std::vector<std::string> names;
      for (const Body& body : mechanism.bodies) names.push_back(body.name);
      const auto body = std::find(names.begin(), names.end(), point.body);
      if (body == names.end()) fail_unknown(location, "a body of " + spec_.path, point.body, names);
      const std::size_t size = mechanism.space == SpaceKind::planar ? 2 : 3;
      if (!point.position.empty() && point.position.size() != size)
        fail(location, {.expected = fmt::format("{} coordinates of a point of {}", size, spec_.path),
                        .found = fmt::format("a list of {}", point.position.size())});
      results::FigurePoint resolved{point.name, static_cast<int>(body - names.begin()), Vector3::Zero()};
      const Body& carrier = mechanism.bodies[static_cast<std::size_t>(body - names.begin())];
      for (std::size_t k = 0; k < point.position.size(); ++k)
        resolved.position[static_cast<Eigen::Index>(k)] = point.position[k] * mechanism.units.length;
      if (point.body_point == "com") resolved.position = carrier.com;
      if (const model::NamedPoint* known = study::find_by_name(carrier.points, point.body_point)) {
        resolved.position = known->position;
      } else if (!point.body_point.empty() && point.body_point != "origin" && point.body_point != "com") {
        std::vector<std::string> known_points{"origin", "com"};
        for (const model::NamedPoint& one : carrier.points) known_points.push_back(one.name);
        fail_unknown(location, "a point of " + carrier.name, point.body_point, known_points);
      }
      points.push_back(std::move(resolved));
    }
    return points;
  }

  /// Calls a reader of an option's text and attributes its mistakes to the suite.
  template <class Reader>
  std::invoke_result_t<Reader> read_option(const std::string& key, const Reader& reader) const {
    const auto relocate = [&](const std::string& message) { return fmt::format("{}: {}", key, message); };
    try {
      return reader();
    } catch (const SpecError& error) {
      std::vector<Diagnostic> mistakes = error.diagnostics();
      for (Diagnostic& mistake : mistakes) {
        mistake.message = relocate(mistake.message);
        mistake.place = suite_case_.location_of(key);
      }
      throw SpecError(std::move(mistakes), error.unlisted_count());
    } catch (const kinematics::UnsolvableMechanism& error) {
      throw CaseFailed(error.what());
    } catch (const std::invalid_argument& error) {
      throw SpecError({suite_case_.location_of(key), relocate(error.what())});
    }
  }

  std::vector<CoordinateValue> find_configuration(const Study& study) const {
    const std::string& at = suite_case_.state.at;
    kinematics::ConfigurationResult result = read_option("at", [&] {
      if (at == "start") return simulation::find_start_configuration(study.mechanism, choose_trajectory(study));
      if (at == "end") return simulation::find_end_configuration(study.mechanism, choose_trajectory(study));
      return kinematics::solve_configuration(study.mechanism, specification::read_pose(at, study));
    });
    require_done(result.outcome);
    return std::move(result.coordinates);
  }

  /// What `balance equations --at` and `balance simulate --at` compute.
  void evaluate_state(CaseSubject& subject) {
    const Study& study = *subject.study;
    const CaseState& text = suite_case_.state;
    dynamics::SingleState state;
    if (!text.rates.empty())
      state.rates =
          read_option("rates", [&] { return specification::read_coordinate_rates(text.rates, "--rates", study); });
    if (!text.accelerations.empty())
      state.accelerations = read_option("accelerations", [&] {
        return specification::read_coordinate_rates(text.accelerations, "--accelerations", study);
      });
    state.configuration = find_configuration(study);
    formulas::EquationsQuery query;
    query.configuration = state.configuration;
    query.rates = state.rates;
    query.accelerations = state.accelerations;
    query.sections = {formulas::EquationSection::inertia, formulas::EquationSection::velocity,
                      formulas::EquationSection::gravity, formulas::EquationSection::torques};
    const std::string key = text.rates.empty() ? "at" : "rates";
    formulas::EquationsReport report =
        read_option(key, [&] { return formulas::compute_equations_at(study.mechanism, query, {}); });
    require_done(report.outcome);
    subject.equations = std::move(report.at);
    const Trajectory* trajectory = study.trajectories.empty() ? nullptr : &study.trajectories.front();
    subject.run = read_option(
        key, [&] { return evaluate_single_state(study.mechanism, state, dynamics::make_state_options(trajectory)); });
    require_done(subject.run->outcome);
    if (is_final_) record_.notes = subject.run->outcome.notes;
  }

  static void require_done(const MotionOutcome& outcome) {
    if (outcome.status != MotionStatus::done)
      throw CaseFailed(fmt::format("{}: {}", name_of(outcome.status), outcome.reason));
  }

  /// What `balance modes` finds.
  void find_modes(CaseSubject& subject) {
    const Study& study = *subject.study;
    const files::DisplayUnit speed_unit =
        files::find_display_unit("rad/s", specification::read_display_units(study.spec_text));
    try {
      subject.vibration = read_option("sweep", [&] {
        return reports::analyse_modes(
            study, {.trajectory = suite_case_.trajectory, .sweep = suite_case_.sweep, .exact = 0}, speed_unit);
      });
    } catch (const study::UnknownNameError& error) {
      fail_choice("trajectory", study, error);
    }
    const vibration::LinearMotion& motion = subject.vibration->modes.motion;
    require_done(motion.outcome);
    if (is_final_ && !motion.note.empty()) record_.notes.push_back(motion.note);
  }

  /// What `balance conditions` derives.
  void derive_conditions(CaseSubject& subject) {
    const DesignSpace space =
        read([this](const ReadOptions& options) { return read_design_space(spec_.text, spec_.path, options); });
    subject.study = space.start;
    set_title(space.start);
    reports::BalanceRequest request{.goals = suite_case_.goals.empty() ? space.start.design.goals : suite_case_.goals,
                                    .is_modular = suite_case_.design && suite_case_.design->modular};
    if (request.goals.empty())
      throw SpecError({suite_case_.location_of("run"),
                       fmt::format("{} has no design: goal, so 'goal' is needed here", space.start.spec_file)});
    const reports::ConditionsOutcome outcome =
        read_option("goal", [&] { return derive_conditions_data(request, space, false); });
    if (outcome.refusal) throw CaseFailed(fmt::format("{}: {}", outcome.refusal.status, outcome.refusal.reason));
    const reports::ConditionsReportData& view = outcome.view;
    comparison::ConditionsFigures figures{.rank = view.conditions.rank,
                                          .count = view.parameter_rows(),
                                          .is_impossible = !view.unbalanced_remainder.empty(),
                                          .holds = view.unbalanced_remainder.empty()};
    for (int row = 0; row < view.parameter_rows(); ++row) figures.holds = figures.holds && view.is_met(row);
    subject.conditions = figures;
    if (is_final_) record_.notes = view.conditions.notes;
  }

  std::string path_of(const std::string& file) const { return (std::filesystem::path(folder_) / file).string(); }

  void record_file(const std::string& file) { record_.files.push_back({file, files::sha256_of_file(path_of(file))}); }

  void write(const RunResult& result, const files::Provenance& description) {
    const std::string file = result_file_name(suite_case_.name);
    write_result_hdf5(path_of(file), result, description,
                      {.existing = files::OverwritePolicy::replace,
                       .durability = files::Durability::deferred,
                       .temporary_tag = temporary_tag});
    record_file(file);
  }

  /// Attributes a mistake in an override to the suite, not to the spec.
  template <class Reader>
  std::invoke_result_t<Reader, const ReadOptions&> read(const Reader& reader) const {
    try {
      return reader(ReadOptions{.set = overrides_});
    } catch (const SpecError& error) {
      std::vector<Diagnostic> mistakes = error.diagnostics();
      for (const auto& [name, value] : suite_case_.overrides)
        for (Diagnostic& mistake : mistakes)
          if (mistake.place.file == "--set " + name) mistake.place = suite_case_.location_of("set." + name);
      for (const SolvedParameter& solved : suite_case_.solved)
        for (Diagnostic& mistake : mistakes)
          if (mistake.place.file == "--set " + solved.parameter)
            mistake.place = suite_case_.location_of("solve." + solved.parameter);
      throw SpecError(std::move(mistakes), error.unlisted_count());
    }
  }

  [[noreturn]] void fail_choice(const char* what, const Study& study, const study::UnknownNameError& error) const {
    fail_unknown(suite_case_.location_of(what), fmt::format("a {} of {}", what, study.spec_file), error.name(),
                 error.known());
  }

  Trajectory choose_trajectory(const Study& study) const {
    try {
      Trajectory trajectory = study::choose_trajectory(study, suite_case_.trajectory);
      if (suite_case_.samples) trajectory.samples = *suite_case_.samples;
      return trajectory;
    } catch (const study::UnknownNameError& error) {
      fail_choice("trajectory", study, error);
    }
  }

  const Controller& choose_controller(const Study& study) const {
    try {
      return study::choose_controller(study, suite_case_.controller);
    } catch (const study::UnknownNameError& error) {
      fail_choice("controller", study, error);
    }
  }

  RunResult run_or_throw(const Study& study, const Trajectory& trajectory) const {
    try {
      RunResult result = suite_case_.controller.empty()
                             ? simulate(study, trajectory)
                             : simulate_closed_loop(study.mechanism, trajectory, choose_controller(study));
      require_done(result.outcome);
      return result;
    } catch (const control::ControllerError& error) {
      const std::string key = "controllers." + suite_case_.controller + (error.key().empty() ? "" : "." + error.key());
      throw SpecError({.place = specification::locate_key(study, key), .message = error.what()});
    } catch (const std::invalid_argument& error) {
      // The spec requests something that the library rejects.
      throw SpecError({.place = specification::locate_trajectory(study, trajectory), .message = error.what()});
    }
  }

  /// What `balance simulate` would write; for a designed case, from its balanced spec.
  files::Provenance describe(const Study& study, const Trajectory& trajectory) const {
    return files::make_simulation_provenance(
        study, trajectory,
        {.spec_file = suite_case_.design ? balanced_spec_file_name(suite_case_.name) : spec_.path,
         .trajectory = trajectory.name,
         .samples = suite_case_.samples,
         .controller = suite_case_.controller});
  }

  DesignStudyOptions design_options(const Study& start) const {
    const CaseDesignOptions asked = suite_case_.design.value_or(CaseDesignOptions{});
    const SourceLocation location = suite_case_.location_of(suite_case_.design ? "design" : "run");
    DesignStudyOptions options;
    options.is_modular = asked.modular;
    options.goals = asked.goals.empty() ? start.design.goals : asked.goals;
    options.search = start.design.search;
    if (asked.seed) options.search.seed = *asked.seed;
    options.compare_trajectories = false;
    if (start.free_numbers.empty() && !design::has_free_rows(start))
      throw SpecError({location, fmt::format("there is nothing to design: no number of {} is free", start.spec_file)});
    if (start.design.front && asked.minimize.empty())
      throw SpecError(
          {location, fmt::format("{} asks for a front, which has many designs, and a case runs one: 'minimize' is "
                                 "needed here",
                                 start.spec_file)});
    if (options.goals.empty() && asked.minimize.empty() && start.design.minimize.empty())
      throw SpecError({location, fmt::format("{} has no design: goal, so 'goal' is needed here", start.spec_file)});
    if (asked.minimize.empty()) return options;
    try {
      options.minimize = specification::read_objective(asked.minimize, start);
    } catch (const SpecError& error) {
      std::vector<Diagnostic> mistakes = error.diagnostics();
      for (Diagnostic& mistake : mistakes) {
        mistake.message = "minimize: " + (mistake.place.key.empty() ? "" : mistake.place.key + ": ") + mistake.message;
        mistake.place = location;
      }
      throw SpecError(std::move(mistakes), error.unlisted_count());
    }
    return options;
  }

  /// Balances the spec; the subject's study is then the balanced one.
  void run_design(CaseSubject& subject) {
    const DesignSpace space =
        read([this](const ReadOptions& options) { return read_design_space(spec_.text, spec_.path, options); });
    const DesignStudyOptions options = design_options(space.start);
    try {
      subject.design = run_design_study(space, options);
    } catch (const std::invalid_argument& error) {
      throw SpecError({suite_case_.location_of(suite_case_.design ? "design" : "run"), error.what()});
    }
    const DesignReport& report = *subject.design;
    const design::DesignOutcome& outcome = report.outcome;
    const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
    if (!terms.empty()) subject.objective_unit = simulation::objective_unit(terms, space.start.mechanism);
    const bool is_solved = outcome.status != DesignStatus::unsolved;
    for (std::size_t i = 0; is_solved && i < report.free_numbers.size(); ++i)
      subject.numbers.push_back({report.free_numbers[i].key_path, outcome.x[static_cast<Eigen::Index>(i)]});
    if (is_final_)
      record_.design = {name_of(outcome.status), outcome.reason, report.mass_before, report.mass_after,
                        report.added_mass};
    if (!is_solved) throw CaseFailed(outcome.reason.empty() ? outcome.conditions.reason : outcome.reason);
    if (is_final_) record_.notes = report.notes;  // the notes of the designed motion come with its own run
    const auto [text, refusal] = reports::format_designed_spec(space, report);
    if (refusal) throw CaseFailed(refusal.reason);
    if (is_final_) {
      files::AtomicFile file(path_of(balanced_spec_file_name(suite_case_.name)), files::OverwritePolicy::replace,
                             temporary_tag);
      file.write(text);
      file.commit(files::Durability::deferred);
      record_file(balanced_spec_file_name(suite_case_.name));
    }
    subject.study = read_spec(text, spec_.path);
  }

  const SuiteCase& suite_case_;
  const std::vector<comparison::FigureReference>& asked_figures_;
  const SpecSource& spec_;
  const std::string& folder_;
  const StoredOutput stored_output_;
  const ParsedSpecCache& spec_cache_;
  std::vector<std::pair<std::string, std::string>> overrides_;  ///< of the case, then the solved parameters
  std::vector<comparison::FigureNumber> solved_numbers_;
  bool is_final_ = false;  ///< all parameters are solved for: the record is filled and files are written
  CaseRecord& record_;
};

}  // namespace

CaseRecord run_case(const BatchPlan& plan, std::size_t index, const std::string& folder, StoredOutput stored_output,
                    ParsedSpecCache& spec_cache) {
  CaseRecord record;
  record.name = plan.suite.cases[index].name;
  record.cache_key = plan.cases[index].key;
  const auto begin = std::chrono::steady_clock::now();
  const auto set_failure = [&record](const char* status, const std::string& message) {
    record.status = status;
    record.message = message;
  };
  try {
    CaseRun(plan, index, folder, stored_output, spec_cache, record).run();
  } catch (const SpecError& error) {
    set_failure("spec", error.summary());
  } catch (const CaseFailed& error) {
    set_failure("mechanism", error.what());
  } catch (const DeadlineExceeded& error) {
    set_failure("mechanism", error.what());
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const SystemError& error) {
    set_failure("system", error.what());
  } catch (const std::exception& error) {
    set_failure("system", std::string("internal error: ") + error.what());
  }
  record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return record;
}

}  // namespace balance::batch
