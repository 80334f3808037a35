#include "targets.hpp"

#include "balance/interface/specification/balanced_spec.hpp"
#include "balance/interface/specification/include_expansion.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/conditions/spec_symbols.hpp"

#include <cstdio>
#include <sstream>

namespace balance::fuzz {

namespace {

/// In the folder of the tables that specs may name.
constexpr const char* file_name = BALANCE_FUZZ_TABLES "/s.yaml";

ReadOptions overrides_in(const std::string& text) {
  ReadOptions options;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto equals = line.find('=');
    if (line.starts_with("#set ") && equals != std::string::npos)
      options.set.emplace_back(line.substr(5, equals - 5), line.substr(equals + 1));
  }
  return options;
}

/// Parts stand in comments behind a line `#part NAME`: no file is read for them.
std::string part_in(const std::string& text, const std::string& path) {
  const std::string head = "#part " + path.substr(path.rfind('/') + 1) + "\n";
  const auto begin = text.find(head);
  if (begin == std::string::npos) throw SystemError("none");
  std::istringstream lines(text.substr(begin + head.size()));
  std::string part;
  for (std::string line; std::getline(lines, line) && line.starts_with("#") && !line.starts_with("#part ");)
    part += line.substr(1) + "\n";
  return part;
}

/// The text with its parts in it. @throws SpecError
std::string whole(const std::string& text) {
  specification::SpecErrorCollector problems(file_name);
  std::string flat = text;
  const bool right = problems.collect([&] {
    const specification::YamlNode root = specification::parse_yaml(text, problems);
    if (specification::has_includes(root))
      flat = specification::expand_includes(root, file_name, problems, [&](const std::string& path) {
               return part_in(text, path);
             }).text;
  });
  if (!right) problems.throw_if_any();
  return flat;
}

void use(const DesignSpace& space) {
  const auto& numbers = space.start.free_numbers;
  VectorX start(static_cast<Eigen::Index>(numbers.size())), lower = start, upper = start;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    start[at] = numbers[i].start;
    lower[at] = numbers[i].lower;
    upper[at] = numbers[i].upper;
  }
  for (const VectorX& x : {start, lower, upper}) complains_well([&] { space.study_at(x); });
  const std::string balanced = specification::format_balanced_spec(space.start, start);
  const bool readable = complains_well([&] {
    try {
      demand(read_spec(balanced, file_name).free_numbers.empty(), "a balanced spec has free numbers");
    } catch (const SpecError& error) {
      std::fprintf(stderr, "%s\n", error.what());
      throw;
    }
  });
  demand(readable, "a balanced spec cannot be read:\n" + balanced);
}

}  // namespace

void spec(std::string_view bytes) {
  const std::string text(bytes);
  const ReadOptions options = overrides_in(text);
  complains_well([&] {
    const DesignSpace space = read_design_space(whole(text), file_name, options);
    use(space);
    if (text.size() < 4000) conditions::list_symbols(space);
  });
}

}  // namespace balance::fuzz
