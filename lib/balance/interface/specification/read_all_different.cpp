#include "balance/interface/specification/read_all_different.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/motion/study/different_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>

namespace balance::specification {

namespace {

class AllDifferentReader {
 public:
  explicit AllDifferentReader(const StudyBuilder& draft) : draft_(draft) {
    for (const auto* all : {&draft.parameters.free_numbers(), &draft.free_numbers})
      for (const FreeNumberEntry& one : *all) free_.push_back(one.number);
  }

  DifferentPaths read_group(const SpecCursor& list) {
    group_ = {};
    reference_.clear();
    read_each(list.items("names of numbers that must be different"), [&](const SpecCursor& item) { read_name(item); });
    if (group_.paths.size() + group_.taken.size() < 2)
      list.fail(
          {.expected = "at least two numbers", .found = group_.paths.empty() && group_.taken.empty() ? "none" : "one"});
    check_adapted(list);
    // elements that are left out do not count, and --set is not the spec's mistake
    if (draft_.study.design.cardinality.empty() && group_.taken.empty()) check_shortage(list);
    return std::move(group_);
  }

 private:
  static std::string without_section(const std::string& path) { return path.substr(path.find('.') + 1); }

  std::vector<const FreeNumber*> find_by(const std::function<bool(const std::string& path)>& is_match) const {
    std::vector<const FreeNumber*> found;
    for (const FreeNumber& number : free_)
      if (is_match(number.key_path) || is_match(without_section(number.key_path))) found.push_back(&number);
    return found;
  }

  void read_name(const SpecCursor& item) {
    const std::string& name = item.read_word("the name of a free number with sizes");
    if (has_wildcards(name)) {
      const auto matches = find_by([&](const std::string& path) { return is_glob_match(name, path); });
      if (matches.empty()) fail_unknown(item);
      for (const FreeNumber* number : matches) add(item, *number);
      return;
    }
    if (const auto exact = find_by([&](const std::string& path) { return path == name; }); !exact.empty()) {
      if (exact.size() > 1) fail_ambiguous(item, exact);
      return add(item, *exact.front());
    }
    auto parts = find_by([&](const std::string& path) {
      return path.starts_with(name) && (path[name.size()] == '.' || path[name.size()] == '[');
    });
    std::erase_if(parts, [](const FreeNumber* number) { return number->discrete_values.empty(); });
    if (parts.size() > 1) fail_ambiguous(item, parts);
    if (parts.size() == 1) return add(item, *parts.front());
    if (const std::optional<double> value = find_fixed_parameter(name)) {
      group_.taken.push_back(*value);
      require_kind(item, "parameters." + name);
      return;
    }
    fail_unknown(item);
  }

  /// Such as one whose value `--set` replaces.
  std::optional<double> find_fixed_parameter(const std::string& name) const {
    for (const study::NamedExpression& one : draft_.recording->parameters)
      if (one.is_plain && (one.name == name || "parameters." + one.name == name)) return one.value.value();
    return std::nullopt;
  }

  [[noreturn]] void fail_unknown(const SpecCursor& item) const {
    if (!draft_.is_mechanism_valid) throw CascadingError();
    std::vector<std::string> names;
    for (const FreeNumber& number : free_)
      if (!number.discrete_values.empty()) names.push_back(number.key_path);
    std::vector<std::string> spellings = names;
    for (const std::string& name : names) spellings.push_back(without_section(name));
    item.fail({.expected = fmt::format("a free number with sizes ({})",
                                       names.empty() ? "there are none" : join_alternatives(names)),
               .found = item.describe_found(),
               .hint = format_nearest_name(item.node().text, spellings)});
  }

  [[noreturn]] static void fail_ambiguous(const SpecCursor& item, const std::vector<const FreeNumber*>& numbers) {
    std::vector<std::string> names;
    for (const FreeNumber* number : numbers) names.push_back(number->key_path);
    item.fail({.expected = "one number",
               .found = fmt::format("{}, which may be {}", item.describe_found(), join_alternatives(names))});
  }

  void add(const SpecCursor& item, const FreeNumber& number) {
    if (number.discrete_values.empty())
      item.fail(
          {.expected = "a free number with sizes",
           .found = fmt::format("{}, which may have any value between its bounds", quote_for_message(number.key_path)),
           .hint = "give it sizes: {free: [lower, upper], step: …} or {free: {values: […]}}"});
    if (!named_.insert(number.key_path).second)
      item.fail({.expected = "each number only once", .found = quote_for_message(number.key_path) + " again"});
    require_kind(item, number.key_path);
    group_.paths.push_back(number.key_path);
  }

  /// Parameters are compared as they are written, all other numbers in SI.
  void require_kind(const SpecCursor& item, const std::string& path) {
    const auto dimension_of = [&](const std::string& one) -> std::optional<Dimension> {
      const auto known = draft_.number_dimensions.find(one);
      if (one.starts_with("parameters.") || known == draft_.number_dimensions.end()) return std::nullopt;
      return known->second;
    };
    if (reference_.empty()) reference_ = path;
    if (dimension_of(path) != dimension_of(reference_))
      item.fail({.expected = "numbers with the same unit, or parameters only",
                 .found = fmt::format("{} beside {}", quote_for_message(path), quote_for_message(reference_))});
  }

  void check_adapted(const SpecCursor& list) const {
    std::string adapted, other;
    for (const std::string& path : group_.paths) (draft_.adapted.contains(path) ? adapted : other) = path;
    if (!adapted.empty() && !other.empty())
      list.fail({.expected = "either all or none of these numbers under 'adapt'",
                 .found = fmt::format("{} there, and {} not", adapted, other)});
  }

  void check_shortage(const SpecCursor& list) const {
    const std::string shortage = study::find_size_shortage({find_free_numbers(group_.paths, free_), {}}, free_);
    if (!shortage.empty())
      list.fail({.expected = "at least as many sizes as numbers",
                 .found = shortage,
                 .hint = "add sizes, or take numbers out of the list"});
  }

  const StudyBuilder& draft_;
  std::vector<FreeNumber> free_;
  std::set<std::string> named_;  ///< by all lists
  DifferentPaths group_;
  std::string reference_;  ///< the first number of the group
};

}  // namespace

std::vector<DifferentPaths> read_all_different(const SpecCursor& at, const StudyBuilder& draft) {
  std::vector<DifferentPaths> groups;
  if (draft.free_numbers.empty() && draft.parameters.free_numbers().empty()) return groups;  // a designed spec
  const std::string form = "names of numbers that must be different [a, b, …], or lists of them";
  const std::vector<SpecCursor> items = at.items(form);
  AllDifferentReader reader(draft);
  const bool has_lists = std::any_of(items.begin(), items.end(), [](const SpecCursor& item) { return item.is_list(); });
  if (!has_lists) {
    groups.push_back(reader.read_group(at));
  } else {
    read_each(items, [&](const SpecCursor& item) { groups.push_back(reader.read_group(item)); });
  }
  std::erase_if(groups, [](const DifferentPaths& group) { return group.paths.empty(); });  // all values are fixed
  return groups;
}

}  // namespace balance::specification
