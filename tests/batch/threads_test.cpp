// Several threads at once write and read what one would.

#include "balance/interface/batch/batch_run.hpp"
#include "balance/interface/files/result_file.hpp"

#include <doctest/doctest.h>

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace threads_test {

namespace {

using namespace balance;
using namespace balance::batch;
namespace fs = std::filesystem;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("balance-threads-" + std::to_string(::getpid()));
  ~Folder() { fs::remove_all(path); }
};

BatchPlan plan() {
  return make_batch_plan(
      parse_suite("matrix: {spec: 3rrr.yaml, trajectory: [cycloid, tool-bang], samples: 21, "
                  "set: {xg: {from: -0.09, to: 0.09, count: 30}}}",
                  BALANCE_CONFIGS "/suite.yaml"));
}

/// A record without how long it took.
std::string untimed(CaseRecord record) {
  record.seconds = 0;
  return encode_record(record);
}

}  // namespace

TEST_CASE("cases are computed in several threads of one process") {
  const Folder folder;
  fs::create_directory(folder.path);
  const BatchPlan all = plan();
  std::vector<CaseRecord> records(all.cases.size());
  std::atomic<std::size_t> next{0};
  {
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < 4; ++thread)
      threads.emplace_back([&] {
        ParsedSpecCache last;
        for (std::size_t i = next++; i < records.size(); i = next++)
          records[i] = run_case(all, i, folder.path.string(), StoredOutput::series, last);
      });
  }
  const Folder other{fs::temp_directory_path() / ("balance-threads-p-" + std::to_string(::getpid()))};
  const BatchOutcome batch = run_batch(all, {.folder = other.path.string(), .jobs = 2});
  for (std::size_t i = 0; i < records.size(); ++i) CHECK(untimed(records[i]) == untimed(batch.records[i]));
}

TEST_CASE("eight jobs find what one finds") {
  const Folder one, eight{fs::temp_directory_path() / ("balance-threads-8-" + std::to_string(::getpid()))};
  const BatchPlan all = plan();
  const BatchOutcome alone = run_batch(all, {.folder = one.path.string(), .jobs = 1});
  const BatchOutcome together = run_batch(all, {.folder = eight.path.string(), .jobs = 8});
  REQUIRE(alone.records.size() == 60);
  REQUIRE(together.records.size() == 60);
  for (std::size_t i = 0; i < alone.records.size(); ++i) {
    CHECK(alone.records[i].status == "done");
    CHECK(untimed(alone.records[i]) == untimed(together.records[i]));  // with the SHA-256 of the files
  }
  CHECK(run_batch(all, {.folder = eight.path.string(), .jobs = 3}).progress.reused == 60);
}

#ifndef __SANITIZE_ADDRESS__  // its allocator may leave locks held for ever in a process forked from one of several threads
TEST_CASE("results are read while others are written") {
  const Folder folder;
  const BatchPlan all = plan();
  run_batch(all, {.folder = folder.path.string(), .jobs = 2});
  const Folder other{fs::temp_directory_path() / ("balance-threads-w-" + std::to_string(::getpid()))};
  std::atomic<int> wrong{0};
  {
    const std::jthread writer([&] { run_batch(all, {.folder = other.path.string(), .jobs = 2}); });
    std::vector<std::jthread> readers;
    for (int reader = 0; reader < 3; ++reader)
      readers.emplace_back([&] {
        for (const SuiteCase& one : all.suite.cases)
          if (balance::read_result_file((folder.path / (one.name + ".h5")).string()).result.time.size() != 21) ++wrong;
      });
  }
  CHECK(wrong == 0);
}
#endif

}  // namespace threads_test
