// The table of mistakes: what each of them is told.

#include "specs.hpp"

#include "balance/interface/batch/suite.hpp"

#include <fstream>
#include <iterator>

namespace {

using namespace balance;
using namespace balance::specification;

/// `\n` and `\t` as they stand in the table.
std::string plain(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '\\' && i + 1 < text.size();
    out += !escape ? text[i] : text[i + 1] == 'n' ? '\n' : text[i + 1] == 't' ? '\t' : text[i + 1];
    i += escape ? 1 : 0;
  }
  return out;
}

std::string file_text(const std::string& name) {
  std::ifstream file(BALANCE_TEST_DATA "/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

const std::string& base_of(const std::string& name) {
  static const std::string suite = file_text("suite.yaml");
  return name == "suite" ? suite : name == "spatial" ? specs::spatial : specs::planar;
}

std::string suite_complaint(const std::string& text) {
  try {
    batch::parse_suite(text, "suite.yaml");
  } catch (const SpecError& error) {
    return error.what();
  }
  return "";
}

/// The entry's value if the line begins with `mark`.
bool takes(const std::string& line, const char* mark, std::string& value) {
  if (!line.starts_with(mark)) return false;
  value = plain(line.substr(2));
  return true;
}

}  // namespace

TEST_CASE("every mistake in the table of bad specs is reported with its place, its key and what was expected (D7)") {
  std::ifstream table(BALANCE_TEST_DATA "/bad_specs.txt");
  std::string base, find, replace, expected, one;
  ReadOptions options;
  int count = 0, several = 0;
  const auto judge = [&] {
    if (expected.empty()) return;
    ++count;
    if (expected.find('\n') != std::string::npos) ++several;
    CAPTURE(find);
    CAPTURE(replace);
    const std::string text = find == "*" ? replace : specs::with(base_of(base), find, replace);
    CHECK((base == "suite" ? suite_complaint(text) : specs::complaint(text, options)) == expected);
    expected.clear();
  };
  for (std::string line; std::getline(table, line);) {
    if (line.empty()) judge();
    if (takes(line, "@ ", base)) options = {};
    if (line.starts_with("s ")) options.set = {{line.substr(2, line.find('=') - 2), line.substr(line.find('=') + 1)}};
    if (takes(line, "- ", find)) continue;
    if (takes(line, "+ ", replace)) continue;
    if (takes(line, "= ", one)) expected += (expected.empty() ? "" : "\n") + one;
  }
  judge();
  CHECK(count >= 337);
  CHECK(several >= 12);
}
