#include "balance/foundation/base/error.hpp"
#include "balance/interface/files/result_file.hpp"
#include "sample.hpp"

#include <sys/resource.h>

#include <doctest/doctest.h>

#include <csignal>
#include <stdexcept>

using namespace balance;
using namespace balance::files;
using sample::Folder;

TEST_CASE("a result that is not done, or whose sizes contradict each other, is misuse and leaves no file") {
  const Folder folder;
  RunResult unsolved = sample::result(SpaceKind::planar);
  unsolved.outcome.status = MotionStatus::unsolved;
  CHECK_THROWS_AS(write_result_hdf5(folder / "out.h5", unsolved, sample::description()), std::invalid_argument);
  RunResult short_rows = sample::result(SpaceKind::planar);
  short_rows.torque.resize(2, 2);
  CHECK_THROWS_AS(write_result_hdf5(folder / "out.h5", short_rows, sample::description()), std::invalid_argument);
  CHECK(folder.entries() == 0);
}

TEST_CASE("a user who stops the writing finds the older file and nothing else") {
  const Folder folder;
  std::ofstream(folder / "out.h5") << "old";
  WriteOptions options;
  options.existing = OverwritePolicy::replace;
  int questions = 0;
  options.is_cancelled = [&] { return ++questions == 5; };
  CHECK_THROWS_AS(
      write_result_hdf5(folder / "out.h5", sample::result(SpaceKind::planar), sample::description(), options),
      Cancelled);
  CHECK(questions == 5);
  CHECK(sample::content(folder / "out.h5") == "old");
  CHECK(folder.entries() == 1);
}

TEST_CASE("a file that outgrows its room at any byte is refused with the system's reason and leaves nothing") {
  const Folder folder;
  std::ofstream(folder / "out.h5") << "old";
  const RunResult r = sample::result(SpaceKind::spatial, 50);
  WriteOptions options;
  options.existing = OverwritePolicy::replace;
  write_result_hdf5(folder / "whole", r, sample::description());
  const auto whole = static_cast<rlim_t>(std::filesystem::file_size(folder / "whole"));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  for (rlim_t room = 0; room < whole; room += whole / 40 + 1) {
    const rlimit limit{room, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::string message;
    try {
      write_result_hdf5(folder / "out.h5", r, sample::description(), options);
    } catch (const SystemError& error) {
      message = error.what();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    CHECK(message == "cannot write " + (folder / "out.h5") + ": File too large");
    CHECK(sample::content(folder / "out.h5") == "old");
    CHECK(folder.entries() == 2);
  }
  std::signal(SIGXFSZ, handler);
  write_result_hdf5(folder / "out.h5", r, sample::description(), options);  // the failures have not harmed what follows
  CHECK(sample::content(folder / "out.h5") == sample::content(folder / "whole"));
}
