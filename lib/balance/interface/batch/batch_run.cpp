#include "balance/interface/batch/batch_run.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/batch/batch_folder.hpp"
#include "balance/interface/batch/sandboxed_worker.hpp"
#include "balance/interface/files/atomic_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace balance::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t mebibyte = std::uintmax_t{1} << 20;

/// The number in a file, at most `upper_limit`; `upper_limit` if the file says "max" or cannot be read.
std::uintmax_t read_memory_limit(const fs::path& file, std::uintmax_t upper_limit) {
  std::ifstream stream(file);
  std::uintmax_t bytes = 0;
  return stream >> bytes && bytes > 0 ? std::min(bytes, upper_limit) : upper_limit;
}

/// The smallest limit of this process's control group and its ancestors.
std::uintmax_t cgroup_memory_limit(std::uintmax_t upper_limit) {
  const fs::path root = "/sys/fs/cgroup";
  std::uintmax_t min_limit = read_memory_limit(root / "memory/memory.limit_in_bytes", upper_limit);
  std::ifstream stream("/proc/self/cgroup");
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with("0::/")) continue;
    fs::path group = root / fs::path(line.substr(4));
    for (; group != root && group.has_relative_path(); group = group.parent_path())
      min_limit = read_memory_limit(group / "memory.max", min_limit);
  }
  return read_memory_limit(root / "memory.max", min_limit);
}

}  // namespace

std::uintmax_t available_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || size <= 0) return 0;
  return cgroup_memory_limit(static_cast<std::uintmax_t>(pages) * static_cast<std::uintmax_t>(size));
}

std::uintmax_t memory_per_case(const CaseLimits& limits, unsigned jobs) {
  if (limits.memory_bytes) return *limits.memory_bytes;
  const std::uintmax_t total_memory = available_memory();
  return total_memory == 0 ? 0 : std::max(total_memory / std::max(jobs, 1U), 256 * mebibyte);
}

std::string format_seconds(double seconds) { return fmt::format("{} s", seconds); }

std::string format_bytes(std::uintmax_t bytes) {
  return bytes % mebibyte == 0 ? fmt::format("{} MiB", bytes / mebibyte)
                               : fmt::format("{:.1f} MiB", static_cast<double>(bytes) / static_cast<double>(mebibyte));
}

namespace {

CaseRecord settle_record(const BatchPlan& plan, std::size_t index, CaseRecord record) {
  if (!plan.cases[index].asks_for_verdict) return record;
  return accept_verdict(std::move(record), plan.suite.cases[index].kind == CaseKind::design);
}

/// Looks for finished cases in threads, then computes the others in processes, which are started only after the threads
/// have ended.
class WorkerPool {
 public:
  WorkerPool(const BatchPlan& plan, const BatchOptions& options, const BatchFolder& folder,
             std::vector<std::size_t> cases)
      : plan_(plan), options_(options), folder_(folder), cases_(std::move(cases)), records_(cases_.size()) {
    progress_.total = cases_.size();
    const std::size_t max_jobs = std::max<std::size_t>(cases_.size(), 1);
    jobs_ = static_cast<unsigned>(std::clamp<std::size_t>(options_.jobs, 1, max_jobs));
    memory_bytes_ = memory_per_case(options_.limits, jobs_);
  }

  BatchOutcome run() {
    {
      std::atomic<std::size_t> next{0};
      std::vector<std::jthread> threads;
      for (unsigned i = 1; i < jobs_; ++i) threads.emplace_back([&] { load_finished(next); });
      load_finished(next);
    }
    run_pending();
    BatchOutcome outcome{{}, progress_};
    for (std::optional<CaseRecord>& record : records_) outcome.records.push_back(std::move(*record));
    return outcome;
  }

 private:
  /// A process and its case, an index into cases_.
  struct WorkerSlot {
    std::unique_ptr<SandboxedWorker> worker;
    std::size_t index = 0;
    std::chrono::steady_clock::time_point begin_time = {};
  };

  void load_finished(std::atomic<std::size_t>& next) {
    for (std::size_t i = next++; i < cases_.size(); i = next++) {
      std::optional<CaseRecord> record =
          load_valid_record(options_.folder, plan_.suite.cases[cases_[i]].name, plan_.cases[cases_[i]].key);
      if (!record || !is_final(*record, plan_.cases[cases_[i]])) continue;
      records_[i] = settle_record(plan_, cases_[i], std::move(*record));
      const std::lock_guard lock(mutex_);
      count(*records_[i], true);
    }
  }

  /// Mistakes are examined again, because their location in the suite may have changed. A case that exceeded a limit is
  /// tried again with a higher one.
  bool is_final(const CaseRecord& record, const PlannedCase& planned) const {
    const bool needs_samples = options_.stored_output == StoredOutput::series && !record.trajectory.empty();
    if (record.has_result()) return (!needs_samples || record.has_samples()) && record.answers(planned.figures);
    if (options_.retry_failed) return false;
    if (record.status == "mechanism") return !record.design || record.answers(planned.figures);
    if (record.status != "failed" || !record.failure) return false;
    const auto covers = [&](double limit) { return limit > 0 && limit <= record.failure->limit; };
    if (record.failure->cause == "timeout") return covers(options_.limits.wall_seconds);
    if (record.failure->cause == "memory") return covers(static_cast<double>(memory_bytes_));
    return true;
  }

  void run_pending() {
    for (std::size_t i = 0; i < cases_.size(); ++i)
      if (!records_[i]) pending_.push_back(i);
    std::vector<WorkerSlot> slots(jobs_);
    std::size_t busy_count = 0;
    for (WorkerSlot& slot : slots) busy_count += assign_next(slot, busy_count > 0) ? 1 : 0;
    while (busy_count > 0) {
      std::vector<const SandboxedWorker*> working;
      for (const WorkerSlot& slot : slots)
        if (slot.worker) working.push_back(slot.worker.get());
      wait_for_any(working, options_.cancelled ? std::chrono::milliseconds(100) : std::chrono::minutes(1));
      if (options_.cancelled && options_.cancelled())
        throw files::Cancelled("the batch was stopped; what is finished is kept");
      for (WorkerSlot& slot : slots)
        if (slot.worker && slot.worker->update_state() != WorkerState::busy &&
            !collect_and_assign(slot, busy_count > 1))
          --busy_count;
    }
  }

  /// @param others_busy whether other workers are busy
  /// @return whether the slot has another case; otherwise it has no process
  bool assign_next(WorkerSlot& slot, bool others_busy) {
    if (pending_.empty()) {
      slot.worker.reset();
      return false;
    }
    slot.index = pending_.front();
    // Bounds the effect of memory that a case leaves allocated in its process.
    constexpr std::size_t max_cases_per_worker = 50;
    const bool needs_restart =
        slot.worker && (slot.worker->update_state() != WorkerState::idle ||
                        slot.worker->task_count() >= max_cases_per_worker || slot.index == retry_index_);
    if (needs_restart) slot.worker.reset();
    try {
      if (!slot.worker)
        slot.worker =
            std::make_unique<SandboxedWorker>(work(), WorkerLimits{options_.limits.wall_seconds, memory_bytes_});
    } catch (const SystemError&) {
      if (!others_busy) throw;
      return false;  // fewer workers can finish the batch, too
    }
    pending_.pop_front();
    slot.begin_time = std::chrono::steady_clock::now();
    slot.worker->submit(slot.index);
    return true;
  }

  /// Collects the outcome of the slot's case and begins the next one.
  bool collect_and_assign(WorkerSlot& slot, bool others_busy) {
    const std::size_t index = slot.index;
    const WorkerState state = slot.worker->update_state();
    if (state == WorkerState::out_of_memory && slot.worker->task_count() > 1) {  // earlier cases may hold the memory
      retry_index_ = index;
      pending_.push_front(index);
      return assign_next(slot, others_busy);
    }
    std::optional<CaseRecord> record = state == WorkerState::idle ? decode_record(slot.worker->reply()) : std::nullopt;
    if (record)
      finish(index, std::move(*record), slot.worker->reply());
    else
      finish(index, make_failure_record(slot, state));
    return assign_next(slot, others_busy);
  }

  SandboxedWorker::Work work() const {
    return [this, spec_cache = ParsedSpecCache{}](std::size_t index) mutable {
      return encode_record(run_case(plan_, cases_[index], options_.folder, options_.stored_output, spec_cache));
    };
  }

  /// @param text of the record, if available
  void finish(std::size_t index, CaseRecord record, const std::string& text = {}) {
    if (record.status == "failed") folder_.remove_unfinished(record.name);
    store(record, text);
    record = settle_record(plan_, cases_[index], std::move(record));
    count(record, false);
    records_[index] = std::move(record);
  }

  /// The record of a case that returned none.
  CaseRecord make_failure_record(const WorkerSlot& slot, WorkerState state) const {
    const SuiteCase& suite_case = plan_.suite.cases[cases_[slot.index]];
    const SandboxedWorker& worker = *slot.worker;
    CaseRecord record;
    record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - slot.begin_time).count();
    record.name = suite_case.name;
    record.cache_key = plan_.cases[cases_[slot.index]].key;
    record.trajectory = suite_case.trajectory;
    record.status = "failed";
    if (state == WorkerState::timed_out) {
      record.failure = {"timeout", options_.limits.wall_seconds};
      record.message = "exceeded --case-timeout " + format_seconds(options_.limits.wall_seconds);
    } else if (state == WorkerState::out_of_memory) {
      record.failure = {"memory", static_cast<double>(memory_bytes_)};
      record.message =
          memory_bytes_ == 0 ? "the system ran out of memory" : "exceeded --case-memory " + format_bytes(memory_bytes_);
    } else {
      record.failure = {"crashed", 0};
      record.message = "crashed: " + (worker.reason().empty() ? "its record is incomplete" : worker.reason());
    }
    return record;
  }

  void store(CaseRecord& record, const std::string& text) const {
    if (record.status == "system") return;  // it may succeed next time
    try {
      store_record(options_.folder, record, text.empty() ? encode_record(record) : text);
    } catch (const SystemError& error) {
      record.status = "system";
      record.message = error.what();
    }
  }

  void count(const CaseRecord& record, bool reused) {
    ++progress_.finished;
    if (reused) ++progress_.reused;
    if (reused && !record.has_result()) ++progress_.reused_failed;
    if (!record.has_result()) ++progress_.failed;
    if (options_.progress) options_.progress(progress_);
  }

  const BatchPlan& plan_;
  const BatchOptions& options_;
  const BatchFolder& folder_;
  const std::vector<std::size_t> cases_;
  unsigned jobs_ = 1;
  std::uintmax_t memory_bytes_ = 0;                 ///< available to a case
  std::deque<std::size_t> pending_;                 ///< indices into cases_
  std::size_t retry_index_ = SIZE_MAX;              ///< case that needs a new process
  std::vector<std::optional<CaseRecord>> records_;  ///< one per entry of cases_
  std::mutex mutex_;                                ///< guards the progress while threads run
  BatchProgress progress_;
};

}  // namespace

BatchOutcome run_batch(const BatchPlan& plan, const BatchOptions& options) {
  if (const std::string conflict = find_overwritten_input(plan, options.folder); !conflict.empty())
    throw std::invalid_argument(conflict);
  std::vector<std::size_t> cases;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    const std::string& name = plan.suite.cases[i].name;
    if (options.shard && !is_in_shard(name, *options.shard)) continue;
    cases.push_back(i);
    names.push_back(name);
  }
  const BatchFolder folder(options.folder, options.shard, names, options.force);
  BatchOutcome outcome = WorkerPool(plan, options, folder, std::move(cases)).run();
  folder.sync();
  return outcome;
}

BatchOutcome collect_batch(const BatchPlan& plan, const std::string& folder) {
  if (!std::filesystem::is_directory(folder)) throw SystemError(folder + ": no such folder to merge");
  BatchOutcome outcome;
  outcome.progress.total = plan.cases.size();
  const BatchFolder locked_folder(folder, std::nullopt, {}, false);
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    const std::string& name = plan.suite.cases[i].name;
    std::optional<CaseRecord> record = load_valid_record(folder, name, plan.cases[i].key);
    if (record && record->has_result() && !record->answers(plan.cases[i].figures)) record.reset();
    if (!record) {
      record.emplace();
      record->name = name;
      record->status = "missing";
      record->message = fmt::format("{} has no finished result of this case as defined by the suite", folder);
    } else {
      record = settle_record(plan, i, std::move(*record));
      ++outcome.progress.finished;
      ++outcome.progress.reused;
    }
    if (!record->has_result()) ++outcome.progress.failed;
    outcome.records.push_back(std::move(*record));
  }
  return outcome;
}

}  // namespace balance::batch
