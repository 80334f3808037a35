#include "specs.hpp"

#include <ctime>

using namespace balance;

namespace {

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

}  // namespace

TEST_CASE("nesting is refused before it can exhaust the stack") {
  for (const char* open : {"[", "{a: ", "- ", "? "}) {
    INFO(open);
    const std::string complaint = specs::complaint(repeated(open, 100'000));
    CHECK_FALSE(complaint.empty());
  }
  CHECK(specs::complaint("a: " + repeated("[", 64) + repeated("]", 64)).find("expected at most 64 levels of nesting") !=
        std::string::npos);
}

TEST_CASE("aliases are values like others, but neither circles nor bombs") {
  const Study study =
      specs::read(specs::with(specs::with(specs::planar, "inertia: 0.02, points: {A", "inertia: &j 0.02, points: {A"),
                              "inertia: 0.01,", "inertia: *j,"));
  CHECK(study.mechanism.bodies[2].inertia(2, 2) == 0.02);
  CHECK(specs::complaint("a: &a [1, *a]")
            .find("s.yaml:1:11: a: expected a value, found an alias of a value that contains it") == 0);
  std::string bomb = "a: &a [" + repeated("x, ", 9) + "x]\n";
  for (char c = 'b'; c < 'k'; ++c) {
    const std::string before(1, static_cast<char>(c - 1)), name(1, c);
    bomb += name + ": &" + name + " [" + repeated("*" + before + ", ", 9) + "*" + before + "]\n";
  }
  CHECK(specs::complaint(bomb).find("expected at most 200000 values in a spec, aliases expanded") != std::string::npos);
}

TEST_CASE("brackets, expressions and free numbers by the ten thousand are read or refused within a second") {
  [[maybe_unused]] const auto begin = std::clock();
  CHECK(specs::complaint(repeated("[", 4'000'000)) ==
        "s.yaml:1:1: expected a document of at most 600000 brackets, braces and commas, found 4000000");
  const auto table = [](const std::string& row, int rows) {
    return specs::with(specs::planar, "[1, 3, 4]]", repeated(row, rows) + "[1, 3, 4]]");
  };
  CHECK(specs::complaint(table("[\"l + " + repeated("l+", 490) + "l\", 0, 0], ", 4000))
            .find("expected at most 500000 characters in all expressions together") != std::string::npos);
  std::string rows;  // on one line
  for (int i = 1; i <= 20'000; ++i) rows += "[" + std::to_string(i) + ", {free: [0, 1]}, 0], ";
  CHECK(specs::read(specs::with(specs::planar, "[1, 3, 4]]", rows + "[30000, 3, 4]]")).free_numbers.size() == 20'001);
#ifndef BALANCE_SANITIZED
  CHECK(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC < 4);
#endif
}

TEST_CASE("what is no spec is refused with the place where that shows") {
  CHECK(specs::complaint("") == "s.yaml:1:1: expected a YAML document, found an empty file");
  CHECK(specs::complaint(" \n\t\n") == "s.yaml:1:1: expected a YAML document, found an empty file");
  CHECK(specs::complaint("# only a comment\n").find("s.yaml:1:1: expected a YAML document") == 0);
  CHECK(specs::complaint("just words").find("s.yaml:1:1: expected a spec: a mapping") == 0);
  CHECK(specs::complaint(std::string("name: a\nx\0y", 11))
            .find("s.yaml:2:2: expected text (UTF-8), found the byte 0x00") == 0);
  CHECK(specs::complaint("name: \xFF").find("s.yaml:1:7: expected text (UTF-8), found the byte 0xff") == 0);
  CHECK(specs::complaint("name: a\n---\nname: b\n").find("expected one document, found a second one") !=
        std::string::npos);
  CHECK(specs::complaint("? [a, b]\n: c\n").find("expected a name as a key") != std::string::npos);
  CHECK(specs::complaint("a: &x {b: 1}\nc: {<<: *x}\n").find("found '<<'") != std::string::npos);
  CHECK(specs::complaint(std::string((std::size_t{4} << 20) + 1, ' '))
            .find("expected a document of at most 4 MiB, found one that is larger") != std::string::npos);
}

TEST_CASE("a spec may have a byte order mark, carriage returns and letters of any language") {
  std::string text = "\xEF\xBB\xBF" + specs::with(specs::planar, "name: test arm", "name: Prüfarm Δ");
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.replace(at, 1, "\r\n");
  CHECK(specs::read(text).mechanism.name == "Prüfarm Δ");
}

TEST_CASE("a file that cannot be read is a failure of the system, not of the spec") {
  CHECK_THROWS_AS(read_spec_file(BALANCE_TEST_DATA "/nowhere.yaml"), SystemError);
  CHECK_THROWS_WITH_AS(read_spec_file(BALANCE_TEST_DATA), BALANCE_TEST_DATA ": expected a spec file, found a directory",
                       SystemError);
  CHECK_THROWS_AS(read_spec_file(BALANCE_TEST_DATA "/joints.h5"), SpecError);
}

TEST_CASE("a spec cut off anywhere is refused or read, never a crash") {
  for (const std::string* text : {&specs::planar, &specs::spatial}) {
    for (std::size_t length = 0; length < text->size(); ++length) {
      const std::string complaint = specs::complaint(text->substr(0, length));
      const bool complete = text->find("\njoints:") + 8 < length;
      CHECK((complete || !complaint.empty()));
    }
  }
}
