#pragma once
/// A node of the spec together with its key path: where every message gets its place from.

#include "balance/spec/node.hpp"
#include "balance/spec/problem.hpp"

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace balance::read {

class Cursor {
 public:
  Cursor(const Node& node, std::string path, Problems& problems)
      : node_(&node), path_(std::move(path)), problems_(&problems) {}

  const Node& node() const { return *node_; }
  const std::string& path() const { return path_; }
  Problems& problems() const { return *problems_; }
  Node::Kind kind() const { return node_->kind; }
  bool is_scalar() const { return kind() == Node::Kind::scalar; }
  bool is_list() const { return kind() == Node::Kind::list; }
  bool is_map() const { return kind() == Node::Kind::map; }

  /// Throws the Problem "expected <what>, found <this value>".
  [[noreturn]] void expected(const std::string& what) const;
  /// Throws a Problem.
  [[noreturn]] void fail(Complaint complaint) const;
  /// The same, but a Consequence if what is looked for at a path may be there after all.
  [[noreturn]] void fail_unless_doubtful(const std::string& path, Complaint complaint) const;
  /// Throws the Problem that this mapping lacks a key, one of those named.
  [[noreturn]] void missing(const std::vector<std::string>& keys) const;
  /// "a list of 3", "a mapping", "'abc'", "nothing".
  std::string found() const;

  /// The entries of a list, paths `path[0]`, `path[1]`, … Fails if it is none, naming `what` was expected.
  std::vector<Cursor> items(const std::string& what) const;
  /// The same for a list of one length.
  std::vector<Cursor> items(const std::string& what, std::size_t count) const;
  /// The text of a scalar; fails if it is none or empty.
  const std::string& word(const std::string& what) const;
  /// Index into `names` of this scalar's text; fails with the nearest of them.
  std::size_t choice(const std::string& what, const std::vector<std::string>& names) const;

 private:
  const Node* node_;
  std::string path_;
  Problems* problems_;
};

/// Reads every item of a list, so that each mistake in it is told. @throws Consequence if there is any
template <class Read>
void read_each(const std::vector<Cursor>& items, Read&& read) {
  bool right = true;
  for (const Cursor& item : items) right = item.problems().guard([&] { read(item); }) && right;
  if (!right) throw Consequence();
}

/// Fails with "expected <what> (a, b or c), found …; nearest is …".
[[noreturn]] void expected_one_of(const Cursor& found, const std::string& what, const std::vector<std::string>& names);

/// One entry of a mapping whose keys the user chose.
struct Member {
  Cursor key;  ///< the key itself, for complaints about the name
  std::string name;
  Cursor value;
};

/// The entries of a mapping in the document's order; fails if it is none. Never more than `most_members`.
std::vector<Member> members(const Cursor& map, const std::string& what);
inline constexpr std::size_t most_members = 2000;

enum class Names { single, joined };

/// The same, and every key must be a name (`is_name`), or several with points between them. One that is not is reported, and its entry read all the
/// same.
std::vector<Member> named_members(const Cursor& map, const std::string& what, Names names = Names::joined);

enum class Need { required, optional };

/// One key that a mapping may have, and what to do with its value.
struct Field {
  std::string name;
  Need need = Need::optional;
  std::function<void(const Cursor&)> read;
  std::string other = {};  ///< another spelling; not both may be given
};

/// Reads a mapping with a fixed set of keys in the document's order. Unknown and missing keys and whatever the fields' readers
/// throw are collected. @return whether nothing was wrong
bool read_fields(const Cursor& map, const std::string& what, const std::vector<Field>& fields);

}  // namespace balance::read
