#pragma once
/// A node of the spec with its key path, which gives every message its place.

#include "balance/interface/specification/diagnostics.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace balance::specification {

// A decimal comma splits one number into two entries, in brackets and in braces.

/// Hint if two consecutive entries of a list may be one number, `[0,25, 0]`; else empty.
std::string find_decimal_comma_in(const YamlNode& list);

/// Hint if a key of a mapping may be the decimals of the value before it, `{m: 1,5}`; else empty.
std::string find_decimal_comma_before(const YamlNode& map, const std::string& key);

class SpecCursor {
 public:
  SpecCursor(const YamlNode& node, std::string path, SpecErrorCollector& problems)
      : node_(&node), path_(std::move(path)), problems_(&problems) {}

  const YamlNode& node() const { return *node_; }
  const std::string& path() const { return path_; }
  SpecErrorCollector& problems() const { return *problems_; }
  YamlNode::Kind kind() const { return node_->kind; }
  bool is_scalar() const { return kind() == YamlNode::Kind::scalar; }
  bool is_list() const { return kind() == YamlNode::Kind::list; }
  bool is_map() const { return kind() == YamlNode::Kind::map; }
  /// Whether it is a map with this key.
  bool has_entry(const std::string& key) const;

  /// Throws the ReadError "expected <what>, found <this value>".
  [[noreturn]] void fail_expected(const std::string& what) const;
  /// Throws a ReadError.
  [[noreturn]] void fail(ErrorMessage error_message) const;
  /// The same, but throws a CascadingError if the value at the path may exist after all.
  [[noreturn]] void fail_unless_uncertain(const std::string& path, ErrorMessage error_message) const;
  /// Throws the ReadError that this mapping lacks one of the named keys.
  [[noreturn]] void fail_missing(const std::vector<std::string>& keys) const;
  /// "a list of 3", "a mapping", "'abc'", "nothing".
  std::string describe_found() const;

  /// The entries of a list, paths `path[0]`, `path[1]`, … Fails with `what` as expected if it is not a list.
  std::vector<SpecCursor> items(const std::string& what) const;
  /// The same for a list of given length.
  std::vector<SpecCursor> items(const std::string& what, std::size_t count) const;
  /// The text of a scalar; fails if it is not a scalar or is empty.
  const std::string& read_word(const std::string& what) const;
  /// Index into `names` of this scalar's text; else fails and suggests the nearest of them.
  std::size_t read_choice(const std::string& what, const std::vector<std::string>& names) const;

 private:
  const YamlNode* node_;
  std::string path_;
  SpecErrorCollector* problems_;
};

/// Reads every item of a list, so that each mistake in it is reported. @throws CascadingError if there is any
template <class Read>
void read_each(const std::vector<SpecCursor>& items, Read&& read) {
  bool is_valid = true;
  for (const SpecCursor& item : items) is_valid = item.problems().collect([&] { read(item); }) && is_valid;
  if (!is_valid) throw CascadingError();
}

/// Fails with "expected <what> (a, b or c), found …; nearest is …".
[[noreturn]] void fail_expected_one_of(const SpecCursor& cursor, const std::string& what,
                                       const std::vector<std::string>& names);

/// One entry of a mapping whose keys the user chose.
struct Member {
  SpecCursor key;  ///< the key itself, for messages about the name
  std::string name;
  SpecCursor value;
};

/// The entries of a mapping in document order; fails if it is not a mapping or has more than `max_members`.
std::vector<Member> list_members(const SpecCursor& map, const std::string& what);
inline constexpr std::size_t max_members = 2000;

enum class NameForm { simple, dotted };

/// The same for keys that must be names (`is_unicode_identifier`), or several names joined by dots. Reports a key that
/// is not, but returns its entry all the same.
std::vector<Member> list_named_members(const SpecCursor& map, const std::string& what,
                                       NameForm names = NameForm::dotted);

enum class Presence { required, optional };

/// One key that a mapping may have, and what to do with its value.
struct Field {
  std::string name;
  Presence need = Presence::optional;
  std::function<void(const SpecCursor&)> read;
  std::string alias = {};  ///< another spelling; the two exclude each other
};

/// Reads a mapping with a fixed set of keys in document order. Collects unknown and missing keys and what the fields'
/// readers throw. @return whether there was no mistake
bool read_fields(const SpecCursor& map, const std::string& what, const std::vector<Field>& fields);

/// Reads one entry for all of `names`, a list with one for each in their order, or a mapping by name.
/// @param need whether a mapping must contain all names
/// @param read_entry of the name with this index
/// @throws CascadingError after a mistake in a list or mapping
void read_entry_per_name(const SpecCursor& at, const std::vector<std::string>& names, Presence need,
                         const std::string& expected_list, const std::string& expected_mapping,
                         const std::function<void(const SpecCursor& at, std::size_t name)>& read_entry);

}  // namespace balance::specification
