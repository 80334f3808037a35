// The only file that depends on yaml-cpp. It reads events rather than the node tree: the limits then apply while
// parsing, before nesting or aliases can grow, and duplicate keys, which the tree drops, are detected.

#include "balance/interface/specification/yaml_document.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/specification/diagnostics.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace balance::specification {

// Likely origin of a syntax error in YAML. A parser reports where it could not continue, which may be lines below.

/// Diagnoses a text that the parser rejected.
/// @param stop_location where the parser stopped
/// @param reason its message
ReadError diagnose_syntax_error(const std::string& text, NodeLocation stop_location, const std::string& reason);

/// Whether a quoted text that begins at a byte, behind its anchor and tag, is closed; also true of text without quotes.
bool is_quote_closed(const std::string& text, std::size_t begin);

namespace {

bool is_word(char c) { return c == '_' || c == '.' || std::isalnum(static_cast<unsigned char>(c)) != 0; }

/// Whether it can be written without quotes, also in a list in brackets.
bool is_plain(const std::string& text) {
  if (text.empty() || text == "null" || text == "Null" || text == "NULL") return false;
  const bool sign = text[0] == '-' || text[0] == '+';
  const char first = sign && text.size() > 1 ? text[1] : text[0];
  if (!is_word(first) && first != '(') return false;
  if (text.rfind("...", 0) == 0) return false;
  return std::all_of(text.begin(), text.end(), [](char c) {
    return is_word(c) || std::string_view(" +-*/^()<>=").find(c) != std::string_view::npos;
  });
}

}  // namespace

std::string quote_yaml(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += std::string("\\") + c;
    else if (byte < 0x20 || byte == 0x7f)
      quoted += fmt::format("\\x{:02x}", byte);
    else
      quoted += c;
  }
  return quoted + "\"";
}

std::string format_scalar(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return "\"\"";
  const std::string trimmed = text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
  return is_plain(trimmed) ? trimmed : quote_yaml(trimmed);
}

std::string format_flow(const YamlNode& node) {
  if (node.kind == YamlNode::Kind::null) return "~";
  if (node.kind == YamlNode::Kind::scalar) return node.is_quoted ? quote_yaml(node.text) : format_scalar(node.text);
  const bool map = node.kind == YamlNode::Kind::map;
  std::string text = map ? "{" : "[";
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (i > 0) text += ", ";
    if (map) text += format_scalar(node.keys[i].text) + ": ";
    text += format_flow(node.items[i]);
  }
  return text + (map ? "}" : "]");
}

namespace {

ReadError make_syntax_error(NodeLocation place, const std::string& what, const std::string& hint = "") {
  return {place, "", {.expected = "YAML", .found = "a syntax error: " + what, .hint = hint}};
}

/// Byte behind the quote that closes the one at `begin`; npos if there is none.
std::size_t end_of_quoted(const std::string& text, std::size_t begin) {
  const char quote = text[begin];
  for (std::size_t i = begin + 1; i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\') {
      ++i;
    } else if (text[i] == quote) {
      if (quote == '"' || i + 1 >= text.size() || text[i + 1] != quote) return i + 1;
      ++i;  // a doubled quote stands for one
    }
  }
  return std::string::npos;
}

/// Finds unmatched brackets and quotes. Knows just enough of YAML to distinguish them from text.
class SyntaxScanner {
 public:
  explicit SyntaxScanner(const std::string& text) : text_(text) {}

  std::optional<ReadError> diagnose() {
    while (at_ < text_.size() && !error_) step();
    if (!error_ && !open_.empty())
      error_ = make_syntax_error(place(open_.back()), fmt::format("'{}' is not closed", text_[open_.back()]));
    return error_;
  }

 private:
  NodeLocation place(std::size_t byte) const {
    const auto before = std::string_view(text_).substr(0, byte);
    const auto line = std::count(before.begin(), before.end(), '\n');
    const std::size_t end = before.rfind('\n');
    return {static_cast<int>(line) + 1, static_cast<int>(byte - (end == std::string_view::npos ? 0 : end + 1)) + 1};
  }

  char next() const { return at_ + 1 < text_.size() ? text_[at_ + 1] : '\n'; }
  static bool is_blank(char c) { return std::strchr(" \t\r\n", c) != nullptr; }

  void skip_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }

  void step() {
    const char c = text_[at_];
    if (c == '\n') {
      value_may_begin_ = value_may_begin_ || open_.empty();
      closed_ = false;
      ++at_;
    } else if (is_blank(c)) {
      ++at_;
    } else if (c == '#' && (at_ == 0 || is_blank(text_[at_ - 1]))) {
      skip_line();
    } else if (value_may_begin_ && (c == '"' || c == '\'')) {
      scan_quoted();
    } else if ((c == '[' || c == '{') && (value_may_begin_ || !open_.empty())) {
      open_.push_back(at_++);
      value_may_begin_ = true;
    } else if ((c == ']' || c == '}') && (value_may_begin_ || closed_ || !open_.empty())) {
      close_bracket(c);
    } else if (value_may_begin_ && open_.empty() && (c == '|' || c == '>')) {
      skip_block();
    } else {
      const bool key = c == ':' && (is_blank(next()) || (!open_.empty() && std::strchr(",[]{}", next()) != nullptr));
      const bool mark = value_may_begin_ && ((std::strchr("-?", c) != nullptr && is_blank(next())));
      const bool tag = value_may_begin_ && (c == '&' || c == '!');
      if (tag) at_ = std::min(text_.find_first_of(" \t\r\n", at_), text_.size()) - 1;
      value_may_begin_ = key || mark || tag || (c == ',' && !open_.empty());
      closed_ = false;
      ++at_;
    }
  }

  void scan_quoted() {
    const std::size_t begin = at_, end = end_of_quoted(text_, at_);
    if (end == std::string::npos) {
      error_ = make_syntax_error(place(begin), fmt::format("the quote {} is not closed", text_[begin]));
      return;
    }
    const std::size_t next_character = text_.find_first_not_of(" \t\r", end);
    if (next_character != std::string::npos && std::strchr(":,]}#\n", text_[next_character]) == nullptr) {
      const NodeLocation from = place(begin), to = place(end - 1);
      const bool spans_lines = from.line != to.line;
      error_ = spans_lines ? make_syntax_error(
                                 from, fmt::format("the quote {} is not closed before line {}", text_[begin], to.line))
                           : make_syntax_error(place(next_character), "text after a closing quote");
      return;
    }
    at_ = end;
    value_may_begin_ = false;
    closed_ = true;
  }

  void close_bracket(char c) {
    if (open_.empty()) {
      error_ = make_syntax_error(place(at_), fmt::format("'{}' without an opening bracket", c));
      return;
    }
    const char opening_bracket = text_[open_.back()];
    if ((opening_bracket == '[') != (c == ']')) {
      const NodeLocation from = place(open_.back());
      error_ = make_syntax_error(
          place(at_), fmt::format("'{}' where the '{}' of line {}, column {} needs a '{}'", c, opening_bracket,
                                  from.line, from.column, opening_bracket == '[' ? ']' : '}'));
      return;
    }
    open_.pop_back();
    ++at_;
    value_may_begin_ = false;
    closed_ = true;
  }

  /// Text on lines of its own that are indented further.
  void skip_block() {
    const std::size_t end = at_ == 0 ? std::string::npos : text_.rfind('\n', at_ - 1);
    const std::size_t line = end == std::string::npos ? 0 : end + 1;
    const std::size_t indent = text_.find_first_not_of(' ', line) - line;
    skip_line();
    while (at_ + 1 < text_.size()) {
      const std::size_t content = text_.find_first_not_of(" \r", at_ + 1);
      if (content == std::string::npos) break;
      if (text_[content] != '\n' && content - (at_ + 1) <= indent) break;
      at_ = std::min(text_.find('\n', at_ + 1), text_.size());
    }
    value_may_begin_ = true;
  }

  const std::string& text_;
  std::size_t at_ = 0;
  bool value_may_begin_ = true;  ///< a value may begin here
  bool closed_ = false;          ///< behind a bracket or a quote
  std::vector<std::size_t> open_;
  std::optional<ReadError> error_;
};

std::vector<std::string_view> lines_until(const std::string& text, int last) {
  std::vector<std::string_view> lines;
  for (std::size_t begin = 0; begin < text.size() && static_cast<int>(lines.size()) < last;) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(std::string_view(text).substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

/// Two keys merge into one text if the first lacks its colon, or the blank behind it.
std::optional<ReadError> find_missing_colon(const std::string& text, NodeLocation stop_location) {
  const auto lines = lines_until(text, stop_location.line);
  if (static_cast<int>(lines.size()) < stop_location.line) return std::nullopt;
  const auto indent = [](std::string_view line) { return line.find_first_not_of(' '); };
  const std::size_t indentation = indent(lines.back());
  for (std::size_t i = lines.size() - 1; i-- > 0;) {
    const std::string_view line = lines[i];
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos || line[begin] == '#') continue;
    const std::string_view content = line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin);
    const bool is_word = std::isalpha(static_cast<unsigned char>(content[0])) != 0;
    const bool has_colon = content.ends_with(':') || content.find(": ") != std::string_view::npos;
    if (!is_word || has_colon || begin > indentation || content.find_first_of("[]{}\"'#,") != std::string_view::npos)
      return std::nullopt;
    const bool lacks_blank = content.find(':') != std::string_view::npos;
    return make_syntax_error({static_cast<int>(i) + 1, static_cast<int>(begin) + 1}, "a line that is not 'key: value'",
                             lacks_blank ? "put a space after the colon" : "put a colon after the key");
  }
  return std::nullopt;
}

/// Meaning of the parser's message for the author of the text.
std::string find_syntax_hint(const std::string& text, NodeLocation stop_location, const std::string& reason) {
  const auto lines = lines_until(text, stop_location.line);
  const bool is_in_text = static_cast<int>(lines.size()) == stop_location.line && stop_location.column >= 1;
  const std::string_view line = is_in_text ? lines.back() : std::string_view();
  const auto column = static_cast<std::size_t>(std::max(stop_location.column, 1)) - 1;
  if (reason == "illegal map value" && line.substr(0, column).find(": ") != std::string_view::npos)
    return "put text that contains ': ' in quotes";
  if (reason == "illegal map value" || reason == "end of map not found" || reason == "end of sequence not found")
    return "this line or the one above is not indented like its neighbours";
  if (reason == "end of map flow not found" || reason == "end of sequence flow not found")
    return "a ',' is missing before this";
  if (reason == "unknown token" && column < line.size())
    return fmt::format("put text that begins with '{}' in quotes", line[column]);
  return "";
}

}  // namespace

bool is_quote_closed(const std::string& text, std::size_t begin) {
  while (begin < text.size() && (text[begin] == '&' || text[begin] == '!'))
    begin = text.find_first_not_of(" \t\r\n", std::min(text.find_first_of(" \t\r\n", begin), text.size()));
  const bool quoted = begin < text.size() && (text[begin] == '"' || text[begin] == '\'');
  return !quoted || end_of_quoted(text, begin) != std::string::npos;
}

ReadError diagnose_syntax_error(const std::string& text, NodeLocation stop_location, const std::string& reason) {
  if (auto error = SyntaxScanner(text).diagnose()) return *error;
  if (reason == "illegal map value")
    if (auto error = find_missing_colon(text, stop_location)) return *error;
  return make_syntax_error(stop_location, reason, find_syntax_hint(text, stop_location, reason));
}

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
    finish(make_node(mark, YamlNode::Kind::null), anchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    YamlNode node = make_node(mark, YamlNode::Kind::scalar);
    node.text = value;
    node.is_quoted = tag != "?";
    // yaml-cpp accepts a text in single quotes that is not closed before the end of the file
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
    const auto match = anchors_.find(anchor);
    if (match == anchors_.end())
      throw ReadError(place_of(mark), path(), {.expected = "a value", .found = "an alias of a value that contains it"});
    count(mark, size_of(match->second));
    check_depth(mark, depth_of(match->second));
    YamlNode copy = match->second;
    copy.begin = byte_of(mark);
    copy.place = place_of(mark);  // of the whole; mistakes inside are located where they are written
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
    std::set<std::string> key_names;
  };

  YamlNode make_node(const YAML::Mark& mark, YamlNode::Kind kind) {
    count(mark, 1);
    check_depth(mark, 1);
    YamlNode node;
    node.kind = kind;
    node.place = place_of(mark);
    node.begin = byte_of(mark);
    return node;
  }

  void open(const YAML::Mark& mark, YamlNode::Kind kind, YAML::anchor_t anchor, YAML::EmitterStyle::value style) {
    YamlNode node = make_node(mark, kind);
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
    OpenCollection collection = std::move(open_.back());
    open_.pop_back();
    finish(std::move(collection.node), collection.anchor);
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
      add_key(parent, std::move(node));
    } else {
      // if a key has no value, yaml-cpp gives the place of whatever comes next
      const bool is_missing = node.kind == YamlNode::Kind::null && node.alias == 0;
      if (is_missing && node.place.line != parent.key->place.line) node.place = parent.key->place;
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

  void add_key(OpenCollection& parent, YamlNode key) {
    if (key.kind == YamlNode::Kind::null) {
      key.kind = YamlNode::Kind::scalar;
      key.text = "null";
    }
    if (key.kind != YamlNode::Kind::scalar)
      throw ReadError(key.place, path(), {.expected = "a name as a key", .found = "a list or a mapping"});
    if (key.text == "<<" && !key.is_quoted)
      throw ReadError(
          key.place, path(),
          {.expected = "a name as a key", .found = "'<<'", .hint = "merging is not supported; use parameters"});
    if (!parent.key_names.insert(key.text).second) {
      ReadError error(key.place, path() + (path().empty() ? "" : ".") + key.text,
                      {.expected = "each key only once", .found = quote_for_message(key.text) + " again"});
      error.unknown_key_in = path();
      problems_.add(std::move(error));
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

/// The first byte that is not text, if any.
std::optional<std::size_t> find_invalid_byte(const std::string& text) {
  std::string_view remaining_text = text;
  while (!remaining_text.empty()) {
    const Utf8CodePoint code_point = decode_utf8(remaining_text);
    const bool control =
        code_point.code < 0x20 && code_point.code != '\t' && code_point.code != '\n' && code_point.code != '\r';
    if (code_point.bytes == 0 || control || code_point.code == 0x7f) return text.size() - remaining_text.size();
    remaining_text.remove_prefix(code_point.bytes);
  }
  return std::nullopt;
}

/// Tab in a line's indentation that is the likely cause of a syntax error: the last one not behind the error,
/// else one on the line below.
std::optional<NodeLocation> find_indentation_tab(const std::string& text, NodeLocation error) {
  std::optional<NodeLocation> tab_location;
  int line = 1;
  for (std::size_t begin = 0; begin < text.size() && line <= error.line + 1; ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::size_t content = text.find_first_not_of(" \t\r", begin);
    const std::size_t tab = text.find('\t', begin);
    const bool in_indentation = content < end && text[content] != '#' && tab < content;
    if (in_indentation && (line <= error.line || !tab_location))
      tab_location = NodeLocation{line, static_cast<int>(tab - begin) + 1};
    begin = end + 1;
  }
  return tab_location;
}

void check_text(const std::string& text, const DocumentLimits& limits) {
  if (text.size() > limits.max_bytes)
    throw ReadError({1, 1}, "",
                    {.expected = fmt::format("a document of at most {} MiB", limits.max_bytes >> 20),
                     .found = "one that is larger"});
  if (const auto invalid_byte = find_invalid_byte(text)) {
    NodeLocation place{1, 1};
    for (std::size_t i = 0; i < *invalid_byte; ++i)
      place = text[i] == '\n' ? NodeLocation{place.line + 1, 1} : NodeLocation{place.line, place.column + 1};
    throw ReadError(place, "",
                    {.expected = "text (UTF-8)",
                     .found = fmt::format("the byte 0x{:02x}: this is a binary file or uses another encoding",
                                          static_cast<unsigned>(static_cast<unsigned char>(text[*invalid_byte])))});
  }
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw ReadError({1, 1}, "", {.expected = "a YAML document", .found = "an empty file"});
  if (const std::size_t carriage_return = text.find('\r');
      carriage_return != std::string::npos && text.find('\n') == std::string::npos)
    throw ReadError({1, static_cast<int>(carriage_return) + 1}, "",
                    {.expected = "lines that end with a line feed", .found = "carriage returns only"});
  // yaml-cpp stores all tokens of a bracket before it reports the first
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
    YamlNodeBuilder second_document(problems, limits, text, skipped);
    if (parser.HandleNextDocument(second_document))
      throw ReadError(second_document.take().place, "", {.expected = "one document", .found = "a second one"});
    return root;
  } catch (const YAML::Exception& error) {
    if (const auto tab = find_indentation_tab(text, place_of(error.mark)))
      throw ReadError(*tab, "",
                      {.expected = "YAML", .found = "a tab in the indentation", .hint = "indent with spaces"});
    throw diagnose_syntax_error(text, place_of(error.mark), error.msg);
  }
}

}  // namespace balance::specification
