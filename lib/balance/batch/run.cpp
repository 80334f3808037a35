#include "balance/batch/run.hpp"

#include "balance/base/error.hpp"
#include "balance/batch/folder.hpp"
#include "balance/batch/run_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <thread>

namespace balance {
namespace {

class Crew {
 public:
  Crew(const Plan& plan, const BatchOptions& options, std::vector<std::size_t> cases)
      : plan_(plan), options_(options), cases_(std::move(cases)), records_(cases_.size()) {
    progress_.total = cases_.size();
  }

  BatchOutcome run() {
    const std::size_t count = std::clamp<std::size_t>(options_.jobs, 1, std::max<std::size_t>(cases_.size(), 1));
    {
      std::vector<std::jthread> threads;
      for (std::size_t i = 1; i < count; ++i) threads.emplace_back([this] { work(); });
      work();
    }
    return {std::move(records_), progress_};
  }

 private:
  void work() {
    for (std::size_t i = next_++; i < cases_.size(); i = next_++) {
      const std::size_t index = cases_[i];
      std::optional<CaseRecord> found = find_finished(index);
      records_[i] = found ? std::move(*found) : compute(index);
      count(records_[i], found.has_value());
    }
  }

  /// Mistakes are looked at again: the suite may say them elsewhere now.
  std::optional<CaseRecord> find_finished(std::size_t index) const {
    std::optional<CaseRecord> record =
        find_record(options_.folder, plan_.suite.cases[index].name, plan_.cases[index].key);
    return record && (record->has_result() || record->status == "mechanism") ? std::move(record) : std::nullopt;
  }

  CaseRecord compute(std::size_t index) const {
    CaseRecord record = run_case(plan_, index, options_.folder);
    if (record.status == "system") return record;  // next time it may go well
    try {
      store_record(options_.folder, record);
    } catch (const SystemError& error) {
      record.status = "system";
      record.message = error.what();
    }
    return record;
  }

  void count(const CaseRecord& record, bool reused) {
    const std::lock_guard lock(mutex_);
    ++progress_.finished;
    if (reused) ++progress_.reused;
    if (!record.has_result()) ++progress_.failed;
    if (options_.progress) options_.progress(progress_);
  }

  const Plan& plan_;
  const BatchOptions& options_;
  const std::vector<std::size_t> cases_;
  std::vector<CaseRecord> records_;  // each written by the thread that has its case
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  BatchProgress progress_;
};

}  // namespace

BatchOutcome run_batch(const Plan& plan, const BatchOptions& options) {
  std::vector<std::size_t> cases;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    const std::string& name = plan.suite.cases[i].name;
    if (options.shard && !belongs(name, *options.shard)) continue;
    cases.push_back(i);
    names.push_back(name);
  }
  const BatchFolder folder(options.folder, options.shard, names, options.force);
  BatchOutcome outcome = Crew(plan, options, std::move(cases)).run();
  folder.sync();
  return outcome;
}

BatchOutcome collect_batch(const Plan& plan, const std::string& folder) {
  if (!std::filesystem::is_directory(folder)) throw SystemError(folder + ": there is no such folder to merge in");
  BatchOutcome outcome;
  outcome.progress.total = plan.cases.size();
  const BatchFolder taken(folder, std::nullopt, {}, false);
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    const std::string& name = plan.suite.cases[i].name;
    std::optional<CaseRecord> record = find_record(folder, name, plan.cases[i].key);
    if (!record) {
      record.emplace();
      record->name = name;
      record->status = "missing";
      record->message = fmt::format("{} has no finished result of this case as the suite asks for it", folder);
    } else {
      ++outcome.progress.finished;
      ++outcome.progress.reused;
    }
    if (!record->has_result()) ++outcome.progress.failed;
    outcome.records.push_back(std::move(*record));
  }
  return outcome;
}

}  // namespace balance
