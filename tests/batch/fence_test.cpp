// Work that crashes, hangs or eats memory harms nobody else.

#include "balance/interface/batch/sandboxed_worker.hpp"

#include <doctest/doctest.h>

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using namespace balance;
using namespace balance::batch;

WorkerState finish(SandboxedWorker& worker) {
  while (worker.update_state() == WorkerState::busy) wait_for_any({&worker});
  return worker.update_state();
}

WorkerState run(SandboxedWorker& worker, std::size_t task) {
  worker.submit(task);
  return finish(worker);
}

}  // namespace

TEST_CASE("a process does task after task and gives back their texts (C1)") {
  const std::string long_text(3'000'000, 'x');  // more than a socket holds
  SandboxedWorker worker([&](std::size_t task) { return task == 7 ? long_text : std::to_string(task); }, {});
  for (const std::size_t task : {0U, 1U, 7U, 2U}) {
    REQUIRE(run(worker, task) == WorkerState::idle);
    CHECK(worker.reply() == (task == 7 ? long_text : std::to_string(task)));
  }
  CHECK(worker.task_count() == 4);
}

TEST_CASE("what ends a process is reported and the others go on (C1)") {
  const auto work = [](std::size_t task) -> std::string {
    if (task == 1) ::raise(SIGSEGV);
    if (task == 2) std::abort();
    if (task == 3) ::_exit(9);
    if (task == 4) ::raise(SIGKILL);
    return "fine";
  };
  SandboxedWorker other(work, {});
  const std::vector<std::string> reasons{"SIGSEGV", "SIGABRT", "exit code 9 without a result", "SIGKILL"};
  for (std::size_t task = 1; task <= reasons.size(); ++task) {
    SandboxedWorker worker(work, {});
    CHECK(run(worker, 0) == WorkerState::idle);
    CHECK(run(worker, task) == WorkerState::crashed);
    CHECK(worker.reason() == reasons[task - 1]);
    CHECK(worker.update_state() == WorkerState::crashed);
    CHECK(run(other, 0) == WorkerState::idle);
  }
}

TEST_CASE("a task that takes too long is ended, with what it has started (C1)") {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const auto work = [&](std::size_t task) -> std::string {
    if (task == 0) return "quick";
    ::fork();
    for (;;) ::pause();
  };
  SandboxedWorker worker(work, {.wall_seconds = 0.2});
  ::close(ends[1]);
  REQUIRE(run(worker, 0) == WorkerState::idle);
  const auto begin = std::chrono::steady_clock::now();
  CHECK(run(worker, 1) == WorkerState::timed_out);
  CHECK(std::chrono::steady_clock::now() - begin >= std::chrono::milliseconds(200));
  char byte = 0;
  CHECK(::read(ends[0], &byte, 1) == 0);  // when the last process that can write has ended
  ::close(ends[0]);
}

#ifndef BALANCE_SANITIZED  // sanitizers keep a shadow of the memory, so that it cannot be limited
TEST_CASE("a task that asks for more memory than allowed is told from one that crashes (C1)") {
  const auto work = [](std::size_t task) {
    std::vector<char> memory(task << 20, 'x');
    return std::to_string(memory.size());
  };
  SandboxedWorker worker(work, {.memory_bytes = std::uintmax_t{64} << 20});
  CHECK(run(worker, 20) == WorkerState::idle);
  CHECK(run(worker, 300) == WorkerState::out_of_memory);
  SandboxedWorker free(work, {});
  CHECK(run(free, 300) == WorkerState::idle);
}
#endif

TEST_CASE("a process ends with its owner, be it idle or busy (C1)") {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  {
    const auto work = [](std::size_t task) -> std::string {
      while (task == 1) ::pause();
      return "";
    };
    SandboxedWorker idle(work, {}), busy(work, {});
    busy.submit(1);
    ::close(ends[1]);
  }
  char byte = 0;
  CHECK(::read(ends[0], &byte, 1) == 0);
  ::close(ends[0]);
}
