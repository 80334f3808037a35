#include "balance/interface/files/atomic_file.hpp"

#include "balance/foundation/base/file_error.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "sample.hpp"

#include <sys/stat.h>

#include <doctest/doctest.h>

#include <cerrno>

using namespace balance;
using namespace balance::files;
using sample::content;
using sample::Folder;

namespace {

void put(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

}  // namespace

TEST_CASE("a file has its name only after it is committed") {
  const Folder folder;
  const std::string path = folder / "out";
  AtomicFile file(path, OverwritePolicy::forbid);
  file.write("complete");
  CHECK_FALSE(std::filesystem::exists(path));
  CHECK(std::filesystem::path(file.temporary()).parent_path() == std::filesystem::path(path).parent_path());
  file.commit();
  CHECK(content(path) == "complete");
  CHECK(folder.entries() == 1);
}

TEST_CASE("a file that is given up leaves nothing and keeps the older one") {
  const Folder folder;
  const std::string path = folder / "out";
  put(path, "old");
  {
    AtomicFile file(path, OverwritePolicy::replace);
    file.write("half");
    CHECK(content(path) == "old");
  }
  CHECK(content(path) == "old");
  CHECK(folder.entries() == 1);
}

TEST_CASE("an older file is replaced only when that is asked for") {
  const Folder folder;
  const std::string path = folder / "out";
  put(path, "old");
  CHECK_THROWS_WITH_AS(AtomicFile(path, OverwritePolicy::forbid),
                       ("cannot write " + path + ": it exists already; --force replaces it").c_str(), SystemError);
  CHECK_THROWS_AS(check_writable(path, OverwritePolicy::forbid), SystemError);
  CHECK_NOTHROW(check_writable(path, OverwritePolicy::replace));
  AtomicFile file(path, OverwritePolicy::replace);
  file.write("new");
  file.commit();
  CHECK(content(path) == "new");
}

TEST_CASE("a file that appears while another of its name is being written is not lost") {
  const Folder folder;
  const std::string path = folder / "out";
  {
    AtomicFile file(path, OverwritePolicy::forbid);
    file.write("mine");
    put(path, "theirs");
    CHECK_THROWS_AS(file.commit(), SystemError);
  }
  CHECK(content(path) == "theirs");
  CHECK(folder.entries() == 1);
}

TEST_CASE("a symbolic link is not followed, wherever it leads (C6)") {
  const Folder folder;
  const std::string target = folder / "target", link = folder / "link", dangling = folder / "dangling";
  put(target, "old");
  std::filesystem::create_symlink(target, link);
  std::filesystem::create_symlink(folder / "nothing", dangling);
  for (const std::string& path : {link, dangling}) {
    for (const OverwritePolicy existing : {OverwritePolicy::forbid, OverwritePolicy::replace}) {
      CHECK_THROWS_AS(check_writable(path, existing), SystemError);
      CHECK_THROWS_WITH_AS(
          AtomicFile(path, existing),
          ("cannot write " + path + ": it is a symbolic link, which is not followed; name the file itself").c_str(),
          SystemError);
    }
    CHECK(std::filesystem::is_symlink(path));
  }
  CHECK(content(target) == "old");
  CHECK_FALSE(std::filesystem::exists(folder / "nothing"));
}

TEST_CASE("a link to a folder on the way to a file is the user's own") {
  const Folder folder;
  std::filesystem::create_directory(folder / "real");
  std::filesystem::create_directory_symlink(folder / "real", folder / "other");
  AtomicFile file(folder / "other/out", OverwritePolicy::forbid);
  file.write("x");
  file.commit();
  CHECK(content(folder / "real/out") == "x");
}

TEST_CASE("an unfinished file is known by its mark, and whether its writer lives by its lock (C7)") {
  const Folder folder;
  std::string living;
  {
    const AtomicFile file(folder / "a.h5", OverwritePolicy::forbid, "batch-"),
        plain(folder / "a.h5", OverwritePolicy::forbid);
    living = file.temporary();
    const auto target = [](const std::string& path, std::string_view mark) {
      return parse_temporary_name(std::filesystem::path(path).filename().string(), mark);
    };
    CHECK(target(living, "batch-") == "a.h5");
    CHECK(target(living, "") == "");
    CHECK(target(plain.temporary(), "") == "a.h5");
    CHECK(target(plain.temporary(), "batch-") == "");
    remove_stale_temporary(living);
    CHECK(std::filesystem::exists(living));
  }
  put(living, "left by a killed writer");
  remove_stale_temporary(living);
  CHECK_FALSE(std::filesystem::exists(living));
  for (const std::string name : {"", ".", ".tmp", ".batch-00000000.tmp", ".a.batch-0000000g.tmp",
                                 "a.batch-00000000.tmp", ".a.batch-000000000.tmp"})
    CHECK(parse_temporary_name(name, "batch-") == "");
}

TEST_CASE("what is no regular file is never replaced") {
  const Folder folder;
  CHECK_THROWS_WITH_AS(check_writable("/dev/null", OverwritePolicy::replace),
                       "cannot write /dev/null: it is not a regular file", SystemError);
  CHECK_THROWS_AS(AtomicFile("/dev/null", OverwritePolicy::replace), SystemError);
  CHECK_THROWS_AS(check_writable(folder / ".", OverwritePolicy::replace), SystemError);
  CHECK_THROWS_AS(check_writable("", OverwritePolicy::replace), SystemError);
}

TEST_CASE("a file that cannot be read or written says so with the system's number") {
  const Folder folder;
  put(folder / "file", "");
  const auto number_of = [](const auto& attempt) {
    try {
      attempt();
    } catch (const FileError& error) {
      return error.error_number();
    }
    return 0;
  };
  const std::string none = folder / "none", below = folder / "file/below", itself = folder / ".";
  for (const auto& [path, number] : {std::pair(none, ENOENT), std::pair(below, ENOTDIR), std::pair(itself, EISDIR)}) {
    CAPTURE(path);
    CHECK(number_of([&] { specification::read_text_file(path, "spec"); }) == number);
    if (number != ENOTDIR) CHECK(number_of([&] { read_result_file(path); }) == number);
    if (number != ENOENT) CHECK(number_of([&] { check_writable(path, OverwritePolicy::replace); }) == number);
  }
  CHECK(number_of([&] { check_writable(folder / "file", OverwritePolicy::forbid); }) == EEXIST);
}

TEST_CASE("a file where a folder should be is named") {
  const Folder folder;
  put(folder / "file", "");
  for (const std::string below : {"file/out", "file/deep/out", "new/../file/out"}) {
    const std::string path = folder / below;
    const std::string reason = "cannot write " + path + ": " + (folder / "file") + " is a file, not a folder";
    CHECK_THROWS_WITH_AS(AtomicFile(path, OverwritePolicy::forbid), reason.c_str(), SystemError);
    CHECK_THROWS_WITH_AS(check_writable(path, OverwritePolicy::forbid), reason.c_str(), SystemError);
  }
}

TEST_CASE("a folder that is missing is made for the file, not for the question whether it can be written") {
  const Folder folder;
  const std::string path = folder / "new/er/out";
  CHECK_NOTHROW(check_writable(path, OverwritePolicy::forbid));
  CHECK(folder.entries() == 0);
  AtomicFile file(path, OverwritePolicy::forbid);
  file.write("x");
  file.commit();
  CHECK(content(path) == "x");
}

TEST_CASE("behind a folder that is still to be made a path means what it will mean then") {
  const Folder folder;
  put(folder / "out", "old");
  std::filesystem::create_directory_symlink(folder / ".", folder / "link");
  for (const std::string name :
       {"out", "./out", "new/../out", "new/er/../../out", "link/out", "new/../link/new/../out"}) {
    CHECK(is_same_file(folder / name, folder / "out"));
    CHECK_THROWS_AS(check_writable(folder / name, OverwritePolicy::forbid), SystemError);
  }
  CHECK(is_same_file(folder / "new/../x", folder / "link/x"));
  CHECK_FALSE(is_same_file(folder / "new/x", folder / "x"));
  CHECK(
      find_replaced_input(folder / "new/../out", {{folder / "other", ""}, {folder / "link/out", "it"}})->description ==
      "it");
  CHECK(find_replaced_input(standard_output_path, {{"-", ""}}) == nullptr);
}

TEST_CASE("a file that is replaced leaves its permissions to the new one") {
  const Folder folder;
  const std::string path = folder / "out";
  for (const mode_t mode : {0600U, 0664U, 0755U}) {
    put(path, "old");
    ::chmod(path.c_str(), mode);
    AtomicFile file(path, OverwritePolicy::replace);
    file.commit();
    struct stat status {};
    REQUIRE(stat(path.c_str(), &status) == 0);
    CHECK((status.st_mode & 0777) == mode);
  }
}

TEST_CASE("a name of the longest length that file systems allow can be written") {
  const Folder folder;
  const std::string path = folder / std::string(255, 'n');
  AtomicFile file(path, OverwritePolicy::forbid);
  file.write("x");
  file.commit();
  CHECK(content(path) == "x");
}

TEST_CASE("a new file has the permissions that the user's mask allows") {
  const Folder folder;
  const mode_t mask = umask(027);
  AtomicFile file(folder / "out", OverwritePolicy::forbid);
  file.commit();
  umask(mask);
  struct stat status {};
  REQUIRE(stat((folder / "out").c_str(), &status) == 0);
  CHECK((status.st_mode & 0777) == 0640);
}
