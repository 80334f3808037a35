#include "background_task.hpp"
#include "bindings.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/batch/batch_folder.hpp"
#include "balance/interface/batch/batch_run.hpp"
#include "balance/interface/batch/batch_summary.hpp"
#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/figure_evaluation.hpp"
#include "balance/interface/comparison/requirement.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/reports/comparison_sections.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance::python {
namespace {

using NamedPythonRun = std::pair<std::string, std::shared_ptr<Run>>;

std::vector<comparison::RequirementVerdict> judge(const std::vector<std::string>& texts,
                                                  const std::vector<comparison::NamedRun>& runs) {
  try {
    return judge_requirements(texts, runs);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("require ") + error.what());
  }
}

struct Compared {
  comparison::ComparedRuns runs;
  std::vector<comparison::RequirementVerdict> verdicts;
};

py::dict compare(const std::vector<NamedPythonRun>& given, const std::vector<std::string>& require) {
  if (given.size() < 2) throw std::invalid_argument("expected at least two runs to compare, the base first");
  for (const auto& [name, run] : given)
    if (!run->description.pose.empty())
      throw std::invalid_argument(quote_for_message(name) +
                                  " is a single state, not a run: it has no figures to compare");
  const Compared compared = compute_in_background([given, require](BackgroundTask&) {
    std::vector<comparison::NamedRun> runs;
    for (const auto& [name, run] : given) {
      const files::Provenance& d = run->description;
      runs.push_back({escape_for_terminal(name), "", d.title, d.trajectory, d.law, d.drive, run->result,
                      require.empty()
                          ? nullptr
                          : comparison::read_mechanism_of(run->result, d.trajectory, d.spec_text, name, d.overrides)});
    }
    return Compared{compare_runs(runs), judge(require, runs)};
  });
  py::dict all;
  all["json"] = reports::comparison_json(compared.runs, compared.verdicts);
  all["text"] = comparison_text(compared.runs, compared.verdicts, reports::QuantitySelection::main);
  all["markdown"] = comparison_markdown(compared.runs, compared.verdicts, reports::QuantitySelection::main);
  all["csv"] = reports::comparison_csv(compared.runs);
  all["holds"] = do_all_hold(compared.verdicts);
  return all;
}

std::shared_ptr<Run> read_result(const std::string& name) {
  files::StoredRun file = compute_in_background([name](BackgroundTask&) { return read_result_file(name); });
  auto run = std::make_shared<Run>();
  run->source = file.path;
  run->result = std::move(file.result);
  run->description = {.title = file.title,
                      .version = file.version,
                      .spec_text = file.spec_text,
                      .command_line = file.command_line,
                      .overrides = file.overrides,
                      .trajectory = file.trajectory,
                      .law = file.law,
                      .drive = file.drive,
                      .formulation = file.formulation,
                      .controller = file.controller,
                      .controller_type = file.controller_type,
                      .pose = file.at};
  if (!file.ended_early.empty()) run->result.outcome.notes.push_back("ended early: " + file.ended_early);
  return run;
}

std::optional<batch::Shard> shard_of(const std::optional<std::pair<int, int>>& given) {
  if (!given) return std::nullopt;
  if (given->first < 1 || given->second < given->first)
    throw std::invalid_argument("shard: must be (index, count) with 1 <= index <= count");
  return batch::Shard{given->first, given->second};
}

struct BatchArguments {
  std::string suite, folder;
  unsigned jobs = 1;
  std::optional<batch::Shard> shard;
  bool force = false, metrics_only = false, retry_failed = false;
  double case_seconds = 0;
};

py::dict batch(const BatchArguments& arguments, const py::object& progress) {
  const batch::BatchSummary summary = compute_in_background(
      [arguments](BackgroundTask& task) {
        const batch::BatchPlan plan = make_batch_plan(batch::read_suite_file(arguments.suite));
        batch::BatchOptions options;
        options.folder = arguments.folder;
        options.jobs = arguments.jobs;
        options.shard = arguments.shard;
        options.force = arguments.force;
        options.stored_output =
            arguments.metrics_only ? batch::StoredOutput::metrics_only : batch::StoredOutput::series;
        options.retry_failed = arguments.retry_failed;
        options.limits.wall_seconds = arguments.case_seconds;
        options.cancelled = [&] { return task.is_cancelled(); };
        options.progress = [&](const batch::BatchProgress& now) {
          task.set_progress(static_cast<double>(now.finished) /
                            static_cast<double>(std::max<std::size_t>(now.total, 1)));
        };
        batch::BatchOutcome outcome = run_batch(plan, options);
        if (arguments.shard) {
          batch::BatchSummary shard_summary;
          shard_summary.name = plan.suite.name;
          shard_summary.cases = std::move(outcome.records);
          return shard_summary;
        }
        batch::BatchSummary all = summarise_batch(plan.suite, std::move(outcome.records));
        write_summary(arguments.folder, all);
        return all;
      },
      progress);
  py::dict all;
  all["json"] = arguments.shard ? std::string() : summary_json(summary);
  all["text"] = arguments.shard ? std::string() : format_batch_text(summary);
  all["exit_code"] = summary.exit_code();
  py::list cases;
  for (const batch::CaseRecord& one : summary.cases) cases.append(py::make_tuple(one.name, one.status, one.message));
  all["cases"] = cases;
  return all;
}

}  // namespace

void bind_comparing(py::module_& m) {
  m.def("compare", &compare, py::arg("runs"), py::arg("require"));
  m.def("read_result", &read_result, py::arg("name"));
  m.def(
      "batch",
      [](const std::string& suite, const std::string& folder, unsigned jobs,
         const std::optional<std::pair<int, int>>& shard, bool force, bool metrics_only, bool retry_failed,
         double case_seconds, const py::object& progress) {
        if (jobs < 1) throw std::invalid_argument("jobs: must be positive");
        if (!(case_seconds >= 0)) throw std::invalid_argument("case_timeout: must not be negative");
        return batch({suite, folder, jobs, shard_of(shard), force, metrics_only, retry_failed, case_seconds}, progress);
      },
      py::arg("suite"), py::arg("folder"), py::arg("jobs"), py::arg("shard"), py::arg("force"), py::arg("metrics_only"),
      py::arg("retry_failed"), py::arg("case_timeout"), py::arg("progress"));
}

}  // namespace balance::python
