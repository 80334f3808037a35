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
  CaseRun(const BatchPlan& plan, std::size_t index, const std::string& folder, StoredOutput keep, ParsedSpecCache& last,
          CaseRecord& record)
      : wanted_(plan.suite.cases[index]),
        spec_(plan.specs[plan.cases[index].spec]),
        folder_(folder),
        keep_(keep),
        last_(last),
        record_(record) {
    const std::size_t spec = plan.cases[index].spec;
    if (!last.document || last.index != spec) last = {spec, SpecDocument(spec_.text)};
  }

  void run() {
    if (!spec_.failure_reason.empty())
      throw SystemError(wanted_.location_of("spec").text() + ": " + spec_.failure_reason);
    const Study study = wanted_.design ? run_design() : read([this](const ReadOptions& options) {
      return read_spec(*last_.document, spec_.path, options);
    });
    record_.title = study.mechanism.name;
    record_.warnings = study.warnings;
    // a design needs no motion: its figures are all there is then
    if (!record_.design || !study.trajectories.empty() || !wanted_.trajectory.empty() || !wanted_.controller.empty())
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
    MetricTable table = make_metric_table(wanted_.name, result);
    record_.metrics = std::move(table.metrics);
    record_.energy = table.energy;
    if (keep_ == StoredOutput::series) write(result, describe(study, trajectory));
  }

  std::string path_of(const std::string& file) const { return (std::filesystem::path(folder_) / file).string(); }

  void note_file(const std::string& file) { record_.files.push_back({file, sha256_of_file(path_of(file))}); }

  void write(const RunResult& result, const Provenance& description) {
    const std::string file = result_file_name(wanted_.name);
    write_result_hdf5(
        path_of(file), result, description,
        {.existing = OverwritePolicy::replace, .durability = Durability::deferred, .temporary_tag = temporary_tag});
    note_file(file);
  }

  /// A mistake in an override is the suite's, not the spec's.
  template <class Reader>
  std::invoke_result_t<Reader, const ReadOptions&> read(const Reader& reader) const {
    try {
      return reader(ReadOptions{.set = wanted_.overrides});
    } catch (const SpecError& error) {
      std::vector<Diagnostic> mistakes = error.diagnostics();
      for (const auto& [name, value] : wanted_.overrides)
        for (Diagnostic& mistake : mistakes)
          if (mistake.place.file == "--set " + name) mistake.place = wanted_.location_of("set." + name);
      throw SpecError(std::move(mistakes), error.unlisted_count());
    }
  }

  [[noreturn]] void fail_choice(const char* what, const Study& study, const std::vector<std::string>& names,
                                const std::string& found) const {
    const specification::ErrorMessage complaint{
        .expected = fmt::format("a {} of {} ({})", what, study.spec_file, join_alternatives(names)),
        .found = quote_for_message(found),
        .hint = format_nearest_name(found, names)};
    throw SpecError({wanted_.location_of(what), complaint.text(), complaint.expected, complaint.found, complaint.hint});
  }

  Trajectory choose_trajectory(const Study& study) const {
    if (study.trajectories.empty())
      throw SpecError({.place = {.file = study.spec_file}, .message = "there is no motion to simulate"});
    std::vector<std::string> names;
    const Trajectory* chosen = wanted_.trajectory.empty() ? &study.trajectories.front() : nullptr;
    for (const Trajectory& trajectory : study.trajectories) {
      names.push_back(trajectory.name);
      if (trajectory.name == wanted_.trajectory) chosen = &trajectory;
    }
    if (chosen == nullptr) fail_choice("trajectory", study, names, wanted_.trajectory);
    Trajectory trajectory = *chosen;
    if (wanted_.samples) trajectory.samples = *wanted_.samples;
    return trajectory;
  }

  const Controller& choose_controller(const Study& study) const {
    std::vector<std::string> names;
    for (const Controller& controller : study.controllers) {
      names.push_back(controller.name);
      if (controller.name == wanted_.controller) return controller;
    }
    fail_choice("controller", study, names, wanted_.controller);
  }

  RunResult run_or_throw(const Study& study, const Trajectory& trajectory) const {
    try {
      RunResult result = wanted_.controller.empty()
                             ? simulate(study.mechanism, trajectory)
                             : simulate_closed_loop(study.mechanism, trajectory, choose_controller(study));
      if (result.outcome.status != MotionStatus::done)
        throw CaseFailed(fmt::format("{}: {}", name_of(result.outcome.status), result.outcome.reason));
      return result;
    } catch (const std::invalid_argument& error) {
      // The library was asked something that the spec should not have asked.
      throw SpecError(
          {.place = {.file = study.spec_file, .key = "trajectories." + trajectory.name}, .message = error.what()});
    }
  }

  /// What `balance simulate` would write; of a designed case, from its balanced spec.
  Provenance describe(const Study& study, const Trajectory& trajectory) const {
    return make_simulation_provenance(study, trajectory,
                                      {.spec_file = wanted_.design ? balanced_spec_file_name(wanted_.name) : spec_.path,
                                       .trajectory = trajectory.name,
                                       .samples = wanted_.samples,
                                       .controller = wanted_.controller});
  }

  DesignStudyOptions design_options(const Study& start) const {
    const SourceLocation place = wanted_.location_of("design");
    DesignStudyOptions options;
    options.is_modular = wanted_.design->modular;
    options.goals = wanted_.design->goals.empty() ? start.design.goals : wanted_.design->goals;
    options.search = start.design.search;
    if (wanted_.design->seed) options.search.seed = *wanted_.design->seed;
    options.compare_trajectories = false;
    if (start.free_numbers.empty())
      throw SpecError({place, fmt::format("there is nothing to design: no number of {} is free", start.spec_file)});
    if (start.design.front && wanted_.design->minimize.empty())
      throw SpecError(
          {place, fmt::format("{} asks for a front, which has many designs, and a case runs one: 'minimize' is "
                              "needed here",
                              start.spec_file)});
    if (options.goals.empty() && wanted_.design->minimize.empty() && start.design.minimize.empty())
      throw SpecError({place, fmt::format("{} has no design: goal, so 'goal' is needed here", start.spec_file)});
    if (wanted_.design->minimize.empty()) return options;
    try {
      options.minimize = read_objective(wanted_.design->minimize, start);
    } catch (const SpecError& error) {
      std::vector<Diagnostic> mistakes = error.diagnostics();
      for (Diagnostic& mistake : mistakes) {
        mistake.message = "minimize: " + (mistake.place.key.empty() ? "" : mistake.place.key + ": ") + mistake.message;
        mistake.place = place;
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
      throw SpecError({wanted_.location_of("design"), error.what()});
    }
    const DesignOutcome& outcome = report.outcome;
    if (outcome.status == DesignStatus::unsolved)
      throw CaseFailed(outcome.reason.empty() ? outcome.conditions.reason : outcome.reason);
    record_.design = {name_of(outcome.status), outcome.reason, report.mass_before, report.mass_after,
                      report.added_mass};
    record_.notes = report.notes;  // those of the designed motion come with its own run
    const auto [text, refusal] = format_designed_spec(space, report);
    if (refusal) throw CaseFailed(refusal.reason);
    AtomicFile file(path_of(balanced_spec_file_name(wanted_.name)), OverwritePolicy::replace, temporary_tag);
    file.write(text);
    file.commit(Durability::deferred);
    note_file(balanced_spec_file_name(wanted_.name));
    return read_spec(text, spec_.path);
  }

  const SuiteCase& wanted_;
  const SpecSource& spec_;
  const std::string& folder_;
  const StoredOutput keep_;
  const ParsedSpecCache& last_;
  CaseRecord& record_;
};

}  // namespace

CaseRecord run_case(const BatchPlan& plan, std::size_t index, const std::string& folder, StoredOutput keep,
                    ParsedSpecCache& last) {
  CaseRecord record;
  record.name = plan.suite.cases[index].name;
  record.cache_key = plan.cases[index].key;
  const auto begin = std::chrono::steady_clock::now();
  const auto failed = [&record](const char* status, const std::string& message) {
    record.status = status;
    record.message = message;
  };
  try {
    CaseRun(plan, index, folder, keep, last, record).run();
  } catch (const SpecError& error) {
    failed("spec", error.summary());
  } catch (const CaseFailed& error) {
    failed("mechanism", error.what());
  } catch (const DeadlineExceeded& error) {
    failed("mechanism", error.what());
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const SystemError& error) {
    failed("system", error.what());
  } catch (const std::exception& error) {
    failed("system", std::string("internal error: ") + error.what());
  }
  record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return record;
}

}  // namespace balance
