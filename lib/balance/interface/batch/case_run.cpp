#include "balance/interface/batch/case_run.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/sha256.hpp"
#include "balance/interface/reports/designed_spec.hpp"
#include "balance/interface/reports/status_names.hpp"
#include "balance/interface/specification/diagnostics.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/control/closed_loop_run.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <type_traits>

namespace balance {
namespace {

/// The mechanism cannot do what the case asks.
struct CaseFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class CaseRun {
 public:
  CaseRun(const BatchPlan& plan, std::size_t index, const std::string& folder, StoredOutput stored_output,
          ParsedSpecCache& spec_cache, CaseRecord& record)
      : suite_case_(plan.suite.cases[index]),
        spec_(plan.specs[plan.cases[index].spec]),
        folder_(folder),
        stored_output_(stored_output),
        spec_cache_(spec_cache),
        record_(record) {
    const std::size_t spec = plan.cases[index].spec;
    if (!spec_cache.document || spec_cache.index != spec) spec_cache = {spec, SpecDocument(spec_.text)};
  }

  void run() {
    if (!spec_.failure_reason.empty())
      throw SystemError(suite_case_.location_of("spec").text() + ": " + spec_.failure_reason);
    const Study study = suite_case_.design ? run_design() : read([this](const ReadOptions& options) {
      return read_spec(*spec_cache_.document, spec_.path, options);
    });
    record_.title = study.mechanism.name;
    record_.warnings = study.warnings;
    // a design needs no motion: without one, its figures are the whole result
    if (!record_.design || !study.trajectories.empty() || !suite_case_.trajectory.empty() ||
        !suite_case_.controller.empty())
      run_trajectory(study);
    record_.status = "done";
    if (!record_.design || record_.design->status == "balanced" || record_.design->status == "not-asked") return;
    record_.status = "compromise";
    record_.message = "the design is not balanced: " + record_.design->reason;
  }

 private:
  void run_trajectory(const Study& study) {
    const Trajectory trajectory = choose_trajectory(study);
    record_.trajectory = trajectory.name;
    record_.samples = trajectory.samples;
    const RunResult result = run_or_throw(study, trajectory);
    record_.notes.insert(record_.notes.end(), result.outcome.notes.begin(), result.outcome.notes.end());
    MetricTable table = make_metric_table(suite_case_.name, result);
    record_.metrics = std::move(table.metrics);
    record_.energy = table.energy;
    if (stored_output_ == StoredOutput::series) write(result, describe(study, trajectory));
  }

  std::string path_of(const std::string& file) const { return (std::filesystem::path(folder_) / file).string(); }

  void record_file(const std::string& file) { record_.files.push_back({file, sha256_of_file(path_of(file))}); }

  void write(const RunResult& result, const Provenance& description) {
    const std::string file = result_file_name(suite_case_.name);
    write_result_hdf5(
        path_of(file), result, description,
        {.existing = OverwritePolicy::replace, .durability = Durability::deferred, .temporary_tag = temporary_tag});
    record_file(file);
  }

  /// Attributes a mistake in an override to the suite, not to the spec.
  template <class Reader>
  std::invoke_result_t<Reader, const ReadOptions&> read(const Reader& reader) const {
    try {
      return reader(ReadOptions{.set = suite_case_.overrides});
    } catch (const SpecError& error) {
      std::vector<Diagnostic> mistakes = error.diagnostics();
      for (const auto& [name, value] : suite_case_.overrides)
        for (Diagnostic& mistake : mistakes)
          if (mistake.place.file == "--set " + name) mistake.place = suite_case_.location_of("set." + name);
      throw SpecError(std::move(mistakes), error.unlisted_count());
    }
  }

  [[noreturn]] void fail_choice(const char* what, const Study& study, const UnknownNameError& error) const {
    const specification::ErrorMessage message{
        .expected = fmt::format("a {} of {} ({})", what, study.spec_file, join_alternatives(error.known())),
        .found = quote_for_message(error.name()),
        .hint = format_nearest_name(error.name(), error.known())};
    throw SpecError({suite_case_.location_of(what), message.text(), message.expected, message.found, message.hint});
  }

  Trajectory choose_trajectory(const Study& study) const {
    try {
      Trajectory trajectory = balance::choose_trajectory(study, suite_case_.trajectory);
      if (suite_case_.samples) trajectory.samples = *suite_case_.samples;
      return trajectory;
    } catch (const UnknownNameError& error) {
      fail_choice("trajectory", study, error);
    }
  }

  const Controller& choose_controller(const Study& study) const {
    try {
      return balance::choose_controller(study, suite_case_.controller);
    } catch (const UnknownNameError& error) {
      fail_choice("controller", study, error);
    }
  }

  RunResult run_or_throw(const Study& study, const Trajectory& trajectory) const {
    try {
      RunResult result = suite_case_.controller.empty()
                             ? simulate(study.mechanism, trajectory)
                             : simulate_closed_loop(study.mechanism, trajectory, choose_controller(study));
      if (result.outcome.status != MotionStatus::done)
        throw CaseFailed(fmt::format("{}: {}", name_of(result.outcome.status), result.outcome.reason));
      return result;
    } catch (const std::invalid_argument& error) {
      // The spec requests something that the library rejects.
      throw SpecError(
          {.place = {.file = study.spec_file, .key = "trajectories." + trajectory.name}, .message = error.what()});
    }
  }

  /// What `balance simulate` would write; for a designed case, from its balanced spec.
  Provenance describe(const Study& study, const Trajectory& trajectory) const {
    return make_simulation_provenance(
        study, trajectory,
        {.spec_file = suite_case_.design ? balanced_spec_file_name(suite_case_.name) : spec_.path,
         .trajectory = trajectory.name,
         .samples = suite_case_.samples,
         .controller = suite_case_.controller});
  }

  DesignStudyOptions design_options(const Study& start) const {
    const SourceLocation location = suite_case_.location_of("design");
    DesignStudyOptions options;
    options.is_modular = suite_case_.design->modular;
    options.goals = suite_case_.design->goals.empty() ? start.design.goals : suite_case_.design->goals;
    options.search = start.design.search;
    if (suite_case_.design->seed) options.search.seed = *suite_case_.design->seed;
    options.compare_trajectories = false;
    if (start.free_numbers.empty())
      throw SpecError({location, fmt::format("there is nothing to design: no number of {} is free", start.spec_file)});
    if (start.design.front && suite_case_.design->minimize.empty())
      throw SpecError(
          {location, fmt::format("{} asks for a front, which has many designs, and a case runs one: 'minimize' is "
                                 "needed here",
                                 start.spec_file)});
    if (options.goals.empty() && suite_case_.design->minimize.empty() && start.design.minimize.empty())
      throw SpecError({location, fmt::format("{} has no design: goal, so 'goal' is needed here", start.spec_file)});
    if (suite_case_.design->minimize.empty()) return options;
    try {
      options.minimize = read_objective(suite_case_.design->minimize, start);
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

  Study run_design() {
    const DesignSpace space =
        read([this](const ReadOptions& options) { return read_design_space(spec_.text, spec_.path, options); });
    const DesignStudyOptions options = design_options(space.start);
    DesignReport report;
    try {
      report = run_design_study(space, options);
    } catch (const std::invalid_argument& error) {
      throw SpecError({suite_case_.location_of("design"), error.what()});
    }
    const DesignOutcome& outcome = report.outcome;
    if (outcome.status == DesignStatus::unsolved)
      throw CaseFailed(outcome.reason.empty() ? outcome.conditions.reason : outcome.reason);
    record_.design = {name_of(outcome.status), outcome.reason, report.mass_before, report.mass_after,
                      report.added_mass};
    record_.notes = report.notes;  // the notes of the designed motion come with its own run
    const auto [text, refusal] = format_designed_spec(space, report);
    if (refusal) throw CaseFailed(refusal.reason);
    AtomicFile file(path_of(balanced_spec_file_name(suite_case_.name)), OverwritePolicy::replace, temporary_tag);
    file.write(text);
    file.commit(Durability::deferred);
    record_file(balanced_spec_file_name(suite_case_.name));
    return read_spec(text, spec_.path);
  }

  const SuiteCase& suite_case_;
  const SpecSource& spec_;
  const std::string& folder_;
  const StoredOutput stored_output_;
  const ParsedSpecCache& spec_cache_;
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

}  // namespace balance
