// The only place that knows yaml-cpp. Its events, not its node tree, are read: so the limits hold while parsing, before
// nesting or aliases can grow, and duplicate keys (which the tree swallows) are seen.

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/spec/node.hpp"
#include "balance/spec/syntax.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <utility>

namespace balance::read {

namespace {

Place place_of(const YAML::Mark& mark) { return mark.is_null() ? Place{1, 1} : Place{mark.line + 1, mark.column + 1}; }

long size_of(const Node& node) {
  long size = 1;
  for (const Node& item : node.items) size += size_of(item);
  return size + static_cast<long>(node.keys.size());
}

int depth_of(const Node& node) {
  int deepest = 0;
  for (const Node& item : node.items) deepest = std::max(deepest, depth_of(item));
  return deepest + 1;
}

class Builder : public YAML::EventHandler {
 public:
  /// @param skipped bytes of the text before yaml-cpp's first: it does not count a byte order mark
  Builder(Problems& problems, const DocumentLimits& limits, const std::string& text, std::size_t skipped)
      : problems_(problems), limits_(limits), text_(text), skipped_(skipped) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnAnchor(const YAML::Mark&, const std::string&) override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    finish(opened(mark, Node::Kind::null), anchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Node node = opened(mark, Node::Kind::scalar);
    node.text = value;
    node.quoted = tag != "?";
    // yaml-cpp lets a text in single quotes end with the file.
    if (tag == "!" && !is_quote_closed(text_, node.begin))
      throw explain_syntax(text_, node.place, "a quote is not closed");
    finish(std::move(node), anchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value style) override {
    open(mark, Node::Kind::list, anchor, style);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value style) override {
    open(mark, Node::Kind::map, anchor, style);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = anchors_.find(anchor);
    if (known == anchors_.end())
      throw Problem(place_of(mark), path(), {.expected = "a value", .found = "an alias of a value that contains it"});
    count(mark, size_of(known->second));
    check_depth(mark, depth_of(known->second));
    Node copy = known->second;
    copy.begin = byte_of(mark);
    copy.place = place_of(mark);  // of the whole: what is wrong inside stands where it is written
    copy.anchor = 0;
    copy.alias = static_cast<int>(anchor);
    finish(std::move(copy), YAML::NullAnchor);
  }

  Node take() { return std::move(root_); }

 private:
  struct Open {
    Node node;
    YAML::anchor_t anchor = YAML::NullAnchor;
    std::optional<Node> key;
    std::set<std::string> seen;
  };

  Node opened(const YAML::Mark& mark, Node::Kind kind) {
    count(mark, 1);
    check_depth(mark, 1);
    Node node;
    node.kind = kind;
    node.place = place_of(mark);
    node.begin = byte_of(mark);
    return node;
  }

  void open(const YAML::Mark& mark, Node::Kind kind, YAML::anchor_t anchor, YAML::EmitterStyle::value style) {
    Node node = opened(mark, kind);
    node.flow = style == YAML::EmitterStyle::Flow;
    open_.push_back({std::move(node), anchor, {}, {}});
  }

  std::size_t byte_of(const YAML::Mark& mark) const {
    return mark.is_null() ? 0 : static_cast<std::size_t>(mark.pos) + skipped_;
  }

  void count(const YAML::Mark& mark, long nodes) {
    nodes_ += nodes;
    if (nodes_ > limits_.nodes)
      throw Problem(place_of(mark), "",
                    {.expected = fmt::format("at most {} values in a spec, aliases expanded", limits_.nodes)});
  }

  void check_depth(const YAML::Mark& mark, int more) const {
    if (static_cast<int>(open_.size()) + more > limits_.depth)
      throw Problem(place_of(mark), "", {.expected = fmt::format("at most {} levels of nesting", limits_.depth)});
  }

  void close() {
    Open done = std::move(open_.back());
    open_.pop_back();
    finish(std::move(done.node), done.anchor);
  }

  void finish(Node node, YAML::anchor_t anchor) {
    if (anchor != YAML::NullAnchor) {
      count_anchor(node);
      node.anchor = static_cast<int>(anchor);
      anchors_[anchor] = node;
    }
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& parent = open_.back();
    if (parent.node.kind == Node::Kind::list) {
      parent.node.items.push_back(std::move(node));
    } else if (!parent.key) {
      take_key(parent, std::move(node));
    } else {
      // Where nothing stands behind a key, yaml-cpp tells the place of whatever comes next.
      const bool nothing = node.kind == Node::Kind::null && node.alias == 0;
      if (nothing && node.place.line != parent.key->place.line) node.place = parent.key->place;
      parent.node.keys.push_back(*std::exchange(parent.key, std::nullopt));
      parent.node.items.push_back(std::move(node));
    }
  }

  /// Nested anchors store their contents once per level.
  void count_anchor(const Node& node) {
    nodes_ += size_of(node);
    if (nodes_ > limits_.nodes)
      throw Problem(node.place, "",
                    {.expected = fmt::format("at most {} values in a spec, aliases expanded", limits_.nodes)});
  }

  void take_key(Open& parent, Node key) {
    if (key.kind == Node::Kind::null) {
      key.kind = Node::Kind::scalar;
      key.text = "null";
    }
    if (key.kind != Node::Kind::scalar)
      throw Problem(key.place, path(), {.expected = "a name as a key", .found = "a list or a mapping"});
    if (key.text == "<<" && !key.quoted)
      throw Problem(key.place, path(),
                    {.expected = "a name as a key",
                     .found = "'<<'",
                     .hint = "merging is not part of the language, parameters are"});
    if (!parent.seen.insert(key.text).second) {
      Problem problem(key.place, path() + (path().empty() ? "" : ".") + key.text,
                      {.expected = "every key once", .found = in_quotes(key.text) + " again"});
      problem.odd_in = path();
      problems_.add(std::move(problem));
    }
    parent.key = std::move(key);
  }

  /// Key path of the innermost open collection.
  std::string path() const {
    std::string text;
    for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
      const Open& open = open_[i];
      if (open.node.kind == Node::Kind::list) text += fmt::format("[{}]", open.node.items.size());
      if (open.key) text += (text.empty() ? "" : ".") + open.key->text;
    }
    return text;
  }

  Problems& problems_;
  DocumentLimits limits_;
  const std::string& text_;
  std::size_t skipped_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Node> anchors_;
  Node root_;
  long nodes_ = 0;
};

/// The first byte that is no text, if any.
std::optional<std::size_t> first_odd_byte(const std::string& text) {
  std::string_view rest = text;
  while (!rest.empty()) {
    const Utf8Character one = first_character(rest);
    const bool control = one.code < 0x20 && one.code != '\t' && one.code != '\n' && one.code != '\r';
    if (one.bytes == 0 || control || one.code == 0x7f) return text.size() - rest.size();
    rest.remove_prefix(one.bytes);
  }
  return std::nullopt;
}

/// The tab among the blanks at the start of a line that an error of syntax is likely to come from: the last one not behind it,
/// or else on the line below.
std::optional<Place> tab_before(const std::string& text, Place error) {
  std::optional<Place> found;
  int line = 1;
  for (std::size_t begin = 0; begin < text.size() && line <= error.line + 1; ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::size_t content = text.find_first_not_of(" \t\r", begin);
    const std::size_t tab = text.find('\t', begin);
    const bool here = content < end && text[content] != '#' && tab < content;
    if (here && (line <= error.line || !found)) found = Place{line, static_cast<int>(tab - begin) + 1};
    begin = end + 1;
  }
  return found;
}

void check_text(const std::string& text, const DocumentLimits& limits) {
  if (text.size() > limits.bytes)
    throw Problem(
        {1, 1}, "",
        {.expected = fmt::format("a document of at most {} MiB", limits.bytes >> 20), .found = "one that is larger"});
  if (const auto odd = first_odd_byte(text)) {
    Place place{1, 1};
    for (std::size_t i = 0; i < *odd; ++i)
      place = text[i] == '\n' ? Place{place.line + 1, 1} : Place{place.line, place.column + 1};
    throw Problem(place, "",
                  {.expected = "text (UTF-8)",
                   .found = fmt::format("the byte 0x{:02x}: this is a binary file or in another encoding",
                                        static_cast<unsigned>(static_cast<unsigned char>(text[*odd])))});
  }
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw Problem({1, 1}, "", {.expected = "a YAML document", .found = "an empty file"});
  if (const std::size_t odd = text.find('\r'); odd != std::string::npos && text.find('\n') == std::string::npos)
    throw Problem({1, static_cast<int>(odd) + 1}, "",
                  {.expected = "lines that end with a line feed", .found = "carriage returns alone"});
  // yaml-cpp takes all of a bracket's tokens into its memory before it tells of the first.
  const auto marks = std::count_if(text.begin(), text.end(), [](char c) { return std::strchr("[]{},", c) != nullptr; });
  if (marks > 3 * limits.nodes)
    throw Problem({1, 1}, "",
                  {.expected = fmt::format("a document of at most {} brackets, braces and commas", 3 * limits.nodes),
                   .found = std::to_string(marks)});
}

}  // namespace

Node parse_yaml(const std::string& text, Problems& problems, const DocumentLimits& limits) {
  check_text(text, limits);
  std::istringstream stream(text);
  const std::size_t skipped = text.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0;
  Builder builder(problems, limits, text, skipped);
  try {
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder))
      throw Problem({1, 1}, "", {.expected = "a YAML document", .found = "nothing but comments"});
    Node root = builder.take();
    Builder rest(problems, limits, text, skipped);
    if (parser.HandleNextDocument(rest))
      throw Problem(rest.take().place, "", {.expected = "one document", .found = "a second one"});
    return root;
  } catch (const YAML::Exception& wrong) {
    if (const auto tab = tab_before(text, place_of(wrong.mark)))
      throw Problem(*tab, "",
                    {.expected = "YAML", .found = "a tab where it wants blanks", .hint = "indent with blanks"});
    throw explain_syntax(text, place_of(wrong.mark), wrong.msg);
  }
}

}  // namespace balance::read
