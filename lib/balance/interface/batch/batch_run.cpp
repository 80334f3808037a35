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

namespace balance {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t mebibyte = std::uintmax_t{1} << 20;

/// A file that holds one number; where it says "max" or cannot be read, there is no limit.
std::uintmax_t limit_in(const fs::path& file, std::uintmax_t otherwise) {
  std::ifstream stream(file);
  std::uintmax_t bytes = 0;
  return stream >> bytes && bytes > 0 ? std::min(bytes, otherwise) : otherwise;
}

/// The least of this process's control group and all above it.
std::uintmax_t cgroup_memory_limit(std::uintmax_t otherwise) {
  const fs::path root = "/sys/fs/cgroup";
  std::uintmax_t least = limit_in(root / "memory/memory.limit_in_bytes", otherwise);
  std::ifstream stream("/proc/self/cgroup");
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with("0::/")) continue;
    fs::path group = root / fs::path(line.substr(4));
    for (; group != root && group.has_relative_path(); group = group.parent_path())
      least = limit_in(group / "memory.max", least);
  }
  return limit_in(root / "memory.max", least);
}

}  // namespace

std::uintmax_t available_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || size <= 0) return 0;
  return cgroup_memory_limit(static_cast<std::uintmax_t>(pages) * static_cast<std::uintmax_t>(size));
}

std::uintmax_t memory_per_case(const CaseLimits& limits, unsigned jobs) {
  if (limits.memory_bytes) return *limits.memory_bytes;
  const std::uintmax_t all = available_memory();
  return all == 0 ? 0 : std::max(all / std::max(jobs, 1U), 256 * mebibyte);
}

std::string format_seconds(double seconds) { return fmt::format("{} s", seconds); }

std::string format_bytes(std::uintmax_t bytes) {
  return bytes % mebibyte == 0 ? fmt::format("{} MiB", bytes / mebibyte)
                               : fmt::format("{:.1f} MiB", static_cast<double>(bytes) / static_cast<double>(mebibyte));
}

namespace {

/// Looks for what is finished in threads, then computes the others in processes, which are started when there are no threads any more.
class WorkerPool {
 public:
  WorkerPool(const BatchPlan& plan, const BatchOptions& options, const BatchFolder& folder,
             std::vector<std::size_t> cases)
      : plan_(plan), options_(options), folder_(folder), cases_(std::move(cases)), records_(cases_.size()) {
    progress_.total = cases_.size();
    const std::size_t most = std::max<std::size_t>(cases_.size(), 1);
    jobs_ = static_cast<unsigned>(std::clamp<std::size_t>(options_.jobs, 1, most));
    bytes_ = memory_per_case(options_.limits, jobs_);
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
  /// A process and the case that it has, an index into cases_.
  struct WorkerSlot {
    std::unique_ptr<SandboxedWorker> worker;
    std::size_t index = 0;
    std::chrono::steady_clock::time_point begin_time = {};
  };

  void load_finished(std::atomic<std::size_t>& next) {
    for (std::size_t i = next++; i < cases_.size(); i = next++) {
      std::optional<CaseRecord> record =
          load_valid_record(options_.folder, plan_.suite.cases[cases_[i]].name, plan_.cases[cases_[i]].key);
      if (!record || !is_final(*record)) continue;
      records_[i] = std::move(record);
      const std::lock_guard lock(mutex_);
      count(*records_[i], true);
    }
  }

  /// Mistakes are looked at again: the suite may say them elsewhere now. What went beyond a limit is tried again with a wider one.
  bool is_final(const CaseRecord& record) const {
    if (record.has_result()) return options_.stored_output == StoredOutput::metrics_only || record.has_samples();
    if (options_.retry_failed) return false;
    if (record.status == "mechanism") return true;
    if (record.status != "failed" || !record.failure) return false;
    const auto covers = [&](double limit) { return limit > 0 && limit <= record.failure->limit; };
    if (record.failure->cause == "timeout") return covers(options_.limits.wall_seconds);
    if (record.failure->cause == "memory") return covers(static_cast<double>(bytes_));
    return true;
  }

  void run_pending() {
    for (std::size_t i = 0; i < cases_.size(); ++i)
      if (!records_[i]) waiting_.push_back(i);
    std::vector<WorkerSlot> hands(jobs_);
    std::size_t busy = 0;
    for (WorkerSlot& hand : hands) busy += assign_next(hand, busy > 0) ? 1 : 0;
    while (busy > 0) {
      std::vector<const SandboxedWorker*> working;
      for (const WorkerSlot& hand : hands)
        if (hand.worker) working.push_back(hand.worker.get());
      wait_for_any(working, options_.cancelled ? std::chrono::milliseconds(100) : std::chrono::minutes(1));
      if (options_.cancelled && options_.cancelled())
        throw Cancelled("the batch was stopped; what is finished is kept");
      for (WorkerSlot& hand : hands)
        if (hand.worker && hand.worker->update_state() != WorkerState::busy && !collect_and_assign(hand, busy > 1))
          --busy;
    }
  }

  /// @param others whether other hands are at work
  /// @return whether the hand has another case; without one it rests and has no process
  bool assign_next(WorkerSlot& hand, bool others) {
    if (waiting_.empty()) {
      hand.worker.reset();
      return false;
    }
    hand.index = waiting_.front();
    // What one case left in the memory of its process ends with it before long.
    constexpr std::size_t max_cases_per_worker = 50;
    const bool tired = hand.worker && (hand.worker->update_state() != WorkerState::idle ||
                                       hand.worker->task_count() >= max_cases_per_worker || hand.index == retry_index_);
    if (tired) hand.worker.reset();
    try {
      if (!hand.worker)
        hand.worker = std::make_unique<SandboxedWorker>(work(), WorkerLimits{options_.limits.wall_seconds, bytes_});
    } catch (const SystemError&) {
      if (!others) throw;
      return false;  // fewer hands do the same
    }
    waiting_.pop_front();
    hand.begin_time = std::chrono::steady_clock::now();
    hand.worker->submit(hand.index);
    return true;
  }

  /// Takes what has become of the hand's case and begins the next one.
  bool collect_and_assign(WorkerSlot& hand, bool others) {
    const std::size_t index = hand.index;
    const WorkerState state = hand.worker->update_state();
    if (state == WorkerState::out_of_memory && hand.worker->task_count() > 1) {  // perhaps it was the others' memory
      retry_index_ = index;
      waiting_.push_front(index);
      return assign_next(hand, others);
    }
    std::optional<CaseRecord> record = state == WorkerState::idle ? decode_record(hand.worker->reply()) : std::nullopt;
    if (record)
      finish(index, std::move(*record), hand.worker->reply());
    else
      finish(index, make_failure_record(hand, state));
    return assign_next(hand, others);
  }

  SandboxedWorker::Work work() const {
    return [this, last = ParsedSpecCache{}](std::size_t index) mutable {
      return encode_record(run_case(plan_, cases_[index], options_.folder, options_.stored_output, last));
    };
  }

  /// @param text of the record, where it is at hand
  void finish(std::size_t index, CaseRecord record, const std::string& text = {}) {
    if (record.status == "failed") folder_.remove_unfinished(record.name);
    store(record, text);
    count(record, false);
    records_[index] = std::move(record);
  }

  /// Of a case that says nothing of itself.
  CaseRecord make_failure_record(const WorkerSlot& hand, WorkerState state) const {
    const SuiteCase& wanted = plan_.suite.cases[cases_[hand.index]];
    const SandboxedWorker& worker = *hand.worker;
    CaseRecord record;
    record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - hand.begin_time).count();
    record.name = wanted.name;
    record.cache_key = plan_.cases[cases_[hand.index]].key;
    record.trajectory = wanted.trajectory;
    record.status = "failed";
    if (state == WorkerState::timed_out) {
      record.failure = {"timeout", options_.limits.wall_seconds};
      record.message = "exceeded --case-timeout " + format_seconds(options_.limits.wall_seconds);
    } else if (state == WorkerState::out_of_memory) {
      record.failure = {"memory", static_cast<double>(bytes_)};
      record.message = bytes_ == 0 ? "the system had no memory left" : "exceeded --case-memory " + format_bytes(bytes_);
    } else {
      record.failure = {"crashed", 0};
      record.message = "crashed: " + (worker.reason().empty() ? "its record is not whole" : worker.reason());
    }
    return record;
  }

  void store(CaseRecord& record, const std::string& text) const {
    if (record.status == "system") return;  // next time it may go well
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
  std::uintmax_t bytes_ = 0;                        ///< that a case may have
  std::deque<std::size_t> waiting_;                 ///< indices into cases_
  std::size_t retry_index_ = SIZE_MAX;              ///< what needs a new process
  std::vector<std::optional<CaseRecord>> records_;  ///< of cases_
  std::mutex mutex_;                                ///< of the progress, while there are threads
  BatchProgress progress_;
};

}  // namespace

BatchOutcome run_batch(const BatchPlan& plan, const BatchOptions& options) {
  if (const std::string trouble = find_overwritten_input(plan, options.folder); !trouble.empty())
    throw std::invalid_argument(trouble);
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
  if (!std::filesystem::is_directory(folder)) throw SystemError(folder + ": there is no such folder to merge in");
  BatchOutcome outcome;
  outcome.progress.total = plan.cases.size();
  const BatchFolder taken(folder, std::nullopt, {}, false);
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    const std::string& name = plan.suite.cases[i].name;
    std::optional<CaseRecord> record = load_valid_record(folder, name, plan.cases[i].key);
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
