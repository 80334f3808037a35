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

namespace balance::specification {

namespace {

NodeLocation place_of(const YAML::Mark& mark) {
  return mark.is_null() ? NodeLocation{1, 1} : NodeLocation{mark.line + 1, mark.column + 1};
}

long size_of(const YamlNode& node) {
  long size = 1;
  for (const YamlNode& item : node.items) size += size_of(item);
  return size + static_cast<long>(node.keys.size());
}

int depth_of(const YamlNode& node) {
  int deepest = 0;
  for (const YamlNode& item : node.items) deepest = std::max(deepest, depth_of(item));
  return deepest + 1;
}

class YamlNodeBuilder : public YAML::EventHandler {
 public:
  /// @param skipped bytes of the text before yaml-cpp's first: it does not count a byte order mark
  YamlNodeBuilder(SpecErrorCollector& problems, const DocumentLimits& limits, const std::string& text,
                  std::size_t skipped)
      : problems_(problems), limits_(limits), text_(text), skipped_(skipped) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnAnchor(const YAML::Mark&, const std::string&) override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    finish(opened(mark, YamlNode::Kind::null), anchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    YamlNode node = opened(mark, YamlNode::Kind::scalar);
    node.text = value;
    node.is_quoted = tag != "?";
    // yaml-cpp lets a text in single quotes end with the file.
    if (tag == "!" && !is_quote_closed(text_, node.begin))
      throw diagnose_syntax_error(text_, node.place, "a quote is not closed");
    finish(std::move(node), anchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value style) override {
    open(mark, YamlNode::Kind::list, anchor, style);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value style) override {
    open(mark, YamlNode::Kind::map, anchor, style);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = anchors_.find(anchor);
    if (known == anchors_.end())
      throw ReadError(place_of(mark), path(), {.expected = "a value", .found = "an alias of a value that contains it"});
    count(mark, size_of(known->second));
    check_depth(mark, depth_of(known->second));
    YamlNode copy = known->second;
    copy.begin = byte_of(mark);
    copy.place = place_of(mark);  // of the whole: what is wrong inside stands where it is written
    copy.anchor = 0;
    copy.alias = static_cast<int>(anchor);
    finish(std::move(copy), YAML::NullAnchor);
  }

  YamlNode take() { return std::move(root_); }

 private:
  struct OpenCollection {
    YamlNode node;
    YAML::anchor_t anchor = YAML::NullAnchor;
    std::optional<YamlNode> key;
    std::set<std::string> seen;
  };

  YamlNode opened(const YAML::Mark& mark, YamlNode::Kind kind) {
    count(mark, 1);
    check_depth(mark, 1);
    YamlNode node;
    node.kind = kind;
    node.place = place_of(mark);
    node.begin = byte_of(mark);
    return node;
  }

  void open(const YAML::Mark& mark, YamlNode::Kind kind, YAML::anchor_t anchor, YAML::EmitterStyle::value style) {
    YamlNode node = opened(mark, kind);
    node.is_flow = style == YAML::EmitterStyle::Flow;
    open_.push_back({std::move(node), anchor, {}, {}});
  }

  std::size_t byte_of(const YAML::Mark& mark) const {
    return mark.is_null() ? 0 : static_cast<std::size_t>(mark.pos) + skipped_;
  }

  void count(const YAML::Mark& mark, long nodes) {
    nodes_ += nodes;
    if (nodes_ > limits_.max_nodes)
      throw ReadError(place_of(mark), "",
                      {.expected = fmt::format("at most {} values in a spec, aliases expanded", limits_.max_nodes)});
  }

  void check_depth(const YAML::Mark& mark, int more) const {
    if (static_cast<int>(open_.size()) + more > limits_.max_depth)
      throw ReadError(place_of(mark), "", {.expected = fmt::format("at most {} levels of nesting", limits_.max_depth)});
  }

  void close() {
    OpenCollection done = std::move(open_.back());
    open_.pop_back();
    finish(std::move(done.node), done.anchor);
  }

  void finish(YamlNode node, YAML::anchor_t anchor) {
    if (anchor != YAML::NullAnchor) {
      count_anchor(node);
      node.anchor = static_cast<int>(anchor);
      anchors_[anchor] = node;
    }
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    OpenCollection& parent = open_.back();
    if (parent.node.kind == YamlNode::Kind::list) {
      parent.node.items.push_back(std::move(node));
    } else if (!parent.key) {
      take_key(parent, std::move(node));
    } else {
      // Where nothing stands behind a key, yaml-cpp tells the place of whatever comes next.
      const bool nothing = node.kind == YamlNode::Kind::null && node.alias == 0;
      if (nothing && node.place.line != parent.key->place.line) node.place = parent.key->place;
      parent.node.keys.push_back(*std::exchange(parent.key, std::nullopt));
      parent.node.items.push_back(std::move(node));
    }
  }

  /// Nested anchors store their contents once per level.
  void count_anchor(const YamlNode& node) {
    nodes_ += size_of(node);
    if (nodes_ > limits_.max_nodes)
      throw ReadError(node.place, "",
                      {.expected = fmt::format("at most {} values in a spec, aliases expanded", limits_.max_nodes)});
  }

  void take_key(OpenCollection& parent, YamlNode key) {
    if (key.kind == YamlNode::Kind::null) {
      key.kind = YamlNode::Kind::scalar;
      key.text = "null";
    }
    if (key.kind != YamlNode::Kind::scalar)
      throw ReadError(key.place, path(), {.expected = "a name as a key", .found = "a list or a mapping"});
    if (key.text == "<<" && !key.is_quoted)
      throw ReadError(key.place, path(),
                      {.expected = "a name as a key",
                       .found = "'<<'",
                       .hint = "merging is not part of the language, parameters are"});
    if (!parent.seen.insert(key.text).second) {
      ReadError problem(key.place, path() + (path().empty() ? "" : ".") + key.text,
                        {.expected = "every key once", .found = quote_for_message(key.text) + " again"});
      problem.unknown_key_in = path();
      problems_.add(std::move(problem));
    }
    parent.key = std::move(key);
  }

  /// Key path of the innermost open collection.
  std::string path() const {
    std::string text;
    for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
      const OpenCollection& open = open_[i];
      if (open.node.kind == YamlNode::Kind::list) text += fmt::format("[{}]", open.node.items.size());
      if (open.key) text += (text.empty() ? "" : ".") + open.key->text;
    }
    return text;
  }

  SpecErrorCollector& problems_;
  DocumentLimits limits_;
  const std::string& text_;
  std::size_t skipped_;
  std::vector<OpenCollection> open_;
  std::map<YAML::anchor_t, YamlNode> anchors_;
  YamlNode root_;
  long nodes_ = 0;
};

/// The first byte that is no text, if any.
std::optional<std::size_t> find_invalid_byte(const std::string& text) {
  std::string_view rest = text;
  while (!rest.empty()) {
    const Utf8CodePoint one = decode_utf8(rest);
    const bool control = one.code < 0x20 && one.code != '\t' && one.code != '\n' && one.code != '\r';
    if (one.bytes == 0 || control || one.code == 0x7f) return text.size() - rest.size();
    rest.remove_prefix(one.bytes);
  }
  return std::nullopt;
}

/// The tab among the blanks at the start of a line that an error of syntax is likely to come from: the last one not behind it,
/// or else on the line below.
std::optional<NodeLocation> find_indentation_tab(const std::string& text, NodeLocation error) {
  std::optional<NodeLocation> found;
  int line = 1;
  for (std::size_t begin = 0; begin < text.size() && line <= error.line + 1; ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::size_t content = text.find_first_not_of(" \t\r", begin);
    const std::size_t tab = text.find('\t', begin);
    const bool here = content < end && text[content] != '#' && tab < content;
    if (here && (line <= error.line || !found)) found = NodeLocation{line, static_cast<int>(tab - begin) + 1};
    begin = end + 1;
  }
  return found;
}

void check_text(const std::string& text, const DocumentLimits& limits) {
  if (text.size() > limits.max_bytes)
    throw ReadError({1, 1}, "",
                    {.expected = fmt::format("a document of at most {} MiB", limits.max_bytes >> 20),
                     .found = "one that is larger"});
  if (const auto odd = find_invalid_byte(text)) {
    NodeLocation place{1, 1};
    for (std::size_t i = 0; i < *odd; ++i)
      place = text[i] == '\n' ? NodeLocation{place.line + 1, 1} : NodeLocation{place.line, place.column + 1};
    throw ReadError(place, "",
                    {.expected = "text (UTF-8)",
                     .found = fmt::format("the byte 0x{:02x}: this is a binary file or in another encoding",
                                          static_cast<unsigned>(static_cast<unsigned char>(text[*odd])))});
  }
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw ReadError({1, 1}, "", {.expected = "a YAML document", .found = "an empty file"});
  if (const std::size_t odd = text.find('\r'); odd != std::string::npos && text.find('\n') == std::string::npos)
    throw ReadError({1, static_cast<int>(odd) + 1}, "",
                    {.expected = "lines that end with a line feed", .found = "carriage returns alone"});
  // yaml-cpp takes all of a bracket's tokens into its memory before it tells of the first.
  const auto marks = std::count_if(text.begin(), text.end(), [](char c) { return std::strchr("[]{},", c) != nullptr; });
  if (marks > 3 * limits.max_nodes)
    throw ReadError(
        {1, 1}, "",
        {.expected = fmt::format("a document of at most {} brackets, braces and commas", 3 * limits.max_nodes),
         .found = std::to_string(marks)});
}

}  // namespace

YamlNode parse_yaml(const std::string& text, SpecErrorCollector& problems, const DocumentLimits& limits) {
  check_text(text, limits);
  std::istringstream stream(text);
  const std::size_t skipped = text.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0;
  YamlNodeBuilder builder(problems, limits, text, skipped);
  try {
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder))
      throw ReadError({1, 1}, "", {.expected = "a YAML document", .found = "nothing but comments"});
    YamlNode root = builder.take();
    YamlNodeBuilder rest(problems, limits, text, skipped);
    if (parser.HandleNextDocument(rest))
      throw ReadError(rest.take().place, "", {.expected = "one document", .found = "a second one"});
    return root;
  } catch (const YAML::Exception& wrong) {
    if (const auto tab = find_indentation_tab(text, place_of(wrong.mark)))
      throw ReadError(*tab, "",
                      {.expected = "YAML", .found = "a tab where it wants blanks", .hint = "indent with blanks"});
    throw diagnose_syntax_error(text, place_of(wrong.mark), wrong.msg);
  }
}

}  // namespace balance::specification
