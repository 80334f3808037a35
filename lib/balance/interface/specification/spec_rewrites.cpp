#include "balance/interface/specification/spec_rewrites.hpp"

#include "balance/interface/specification/yaml_document.hpp"
#include "balance/interface/specification/yaml_source.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>
#include <utility>

namespace balance::specification {

namespace {

/// Goes through the document in its order.
class ReplacementCollector {
 public:
  ReplacementCollector(const YamlNode& root, StudyBuilder& draft)
      : root_(root), draft_(draft), source_(draft.study.spec_text) {
    for (const FreeNumberEntry& free : draft.parameters.free_numbers()) free_[free.node].push_back(&free);
    for (const FreeNumberEntry& free : draft.free_numbers) free_[free.node].push_back(&free);
    for (const auto& [node, text] : draft.parameters.overridden()) overridden_[node] = format_scalar(text);
  }

  void run() {
    if (free_.empty() && overridden_.empty()) return;
    visit(root_, nullptr);
    for (const YamlNode* alias : aliases_)
      if (touched_.count(alias->alias) > 0) write_out(*alias);
    std::stable_sort(rewrites().begin(), rewrites().end(),
                     [](const TextReplacement& a, const TextReplacement& b) { return a.begin < b.begin; });
  }

 private:
  std::vector<TextReplacement>& rewrites() { return draft_.study.rewrites; }

  bool changes(const YamlNode& node) const { return free_.count(&node) > 0 || overridden_.count(&node) > 0; }

  bool holds_changes(const YamlNode& node) const {
    return changes(node) ||
           std::any_of(node.items.begin(), node.items.end(), [&](const YamlNode& item) { return holds_changes(item); });
  }

  /// @param key of the mapping's entry that the node is the value of, if it is one
  void visit(const YamlNode& node, const YamlNode* key) {
    if (node.alias != 0) return holds_changes(node) ? write_out(node) : aliases_.push_back(&node);
    if (node.anchor != 0) open_anchors_.push_back(node.anchor);
    if (changes(node)) {
      touched_.insert(open_anchors_.begin(), open_anchors_.end());
      collect_nested_anchors(node);
      replace(node, key);
    } else {
      for (std::size_t i = 0; i < node.items.size(); ++i) {
        if (i < node.keys.size()) visit(node.keys[i], nullptr);
        visit(node.items[i], i < node.keys.size() ? &node.keys[i] : nullptr);
      }
    }
    if (node.anchor != 0) open_anchors_.pop_back();
  }

  /// What is replaced takes its anchors along.
  void collect_nested_anchors(const YamlNode& node) {
    if (node.alias != 0) return;
    if (node.anchor != 0) touched_.insert(node.anchor);
    for (const auto* children : {&node.keys, &node.items})
      for (const YamlNode& child : *children) collect_nested_anchors(child);
  }

  /// The numbers' indices in the study, several in brackets, or the text of the override. The first takes the node's place.
  std::vector<TextReplacement> content_of(const YamlNode& node, Span span) {
    if (const auto text = overridden_.find(&node); text != overridden_.end()) return {{0, 0, text->second, -1}};
    const std::vector<const FreeNumberEntry*>& found = free_.at(&node);
    const bool list = found.front()->is_list_item;
    std::vector<TextReplacement> content;
    for (const FreeNumberEntry* one : found) {
      FreeNumber number = one->number;
      number.begin = span.begin;
      number.end = span.end;
      draft_.study.free_numbers.push_back(number);
      draft_.recording->free.push_back(draft_.recording->input_index(one->input));
      content.push_back({0, 0,
                         !list             ? ""
                         : content.empty() ? "["
                                           : ", ",
                         static_cast<int>(draft_.study.free_numbers.size()) - 1});
    }
    if (list) content.push_back({0, 0, "]", -1});
    return content;
  }

  void add(std::size_t begin, std::size_t end, TextReplacement content) {
    content.begin = begin;
    content.end = end;
    rewrites().push_back(std::move(content));
  }
  void add(std::size_t begin, std::size_t end, std::vector<TextReplacement> content) {
    for (TextReplacement& piece : content) add(std::exchange(begin, end), end, std::move(piece));
  }

  void replace(const YamlNode& node, const YamlNode* key);
  void replace_below(const YamlNode& node, std::size_t after_colon, std::vector<TextReplacement> content);
  void replace_nothing(const YamlNode& key, std::vector<TextReplacement> content);
  std::string kept_comments(const YamlNode& node) const;
  void write_out(const YamlNode& alias);
  void write(const YamlNode& node, Span alias, std::vector<TextReplacement>& pieces);
  std::size_t after_colon(const YamlNode& key) const;

  char at(std::size_t i) const { return i < source_.text().size() ? source_.text()[i] : '\n'; }
  std::string space_before(std::size_t i) const {
    return i == 0 || std::string_view(" \t\r\n[{,").find(at(i - 1)) != std::string_view::npos ? "" : " ";
  }
  std::string space_after(std::size_t i) const {
    return std::string_view(" \t\r\n]},").find(at(i)) != std::string_view::npos ? "" : " ";
  }
  /// Whether nothing follows on the line.
  bool ends_line(std::size_t i) const {
    while (source_.is_space(i)) ++i;
    return i >= source_.text().size() || source_.is_break(i);
  }
  bool begins_line(std::size_t i) const {
    while (i > 0 && source_.is_space(i - 1)) --i;
    return i == 0 || source_.is_break(i - 1);
  }
  std::string copy(Span span) const { return source_.text().substr(span.begin, span.end - span.begin); }

  const YamlNode& root_;
  StudyBuilder& draft_;
  SourceText source_;
  std::unordered_map<const YamlNode*, std::vector<const FreeNumberEntry*>> free_;  ///< in their order
  std::unordered_map<const YamlNode*, std::string> overridden_;
  std::vector<const YamlNode*> aliases_;  ///< that may stay
  std::vector<int> open_anchors_;
  std::set<int> touched_;  ///< anchors whose value changes or goes
};

/// 0 if the key has no colon.
std::size_t ReplacementCollector::after_colon(const YamlNode& key) const {
  const std::size_t colon = source_.skip_blank(source_.span(key).end);
  return at(colon) == ':' ? colon + 1 : 0;
}

void ReplacementCollector::replace(const YamlNode& node, const YamlNode* key) {
  const Span span = source_.span(node);
  std::vector<TextReplacement> content = content_of(node, span);
  if (key != nullptr && span.begin == span.end) return replace_nothing(*key, std::move(content));
  if (key != nullptr && !node.is_flow && node.kind != YamlNode::Kind::scalar && begins_line(span.begin))
    if (const std::size_t colon = after_colon(*key); colon > 0) return replace_below(node, colon, std::move(content));
  content.front().text = space_before(span.begin) + content.front().text;
  add(span.begin, span.end, std::move(content));
  const std::string comments = kept_comments(node);
  if (const std::string rest = comments + (comments.empty() ? space_after(span.end) : ""); !rest.empty())
    add(span.end, span.end, {0, 0, rest, -1});
}

/// A mapping on the lines below its key: the number goes up to the key.
void ReplacementCollector::replace_below(const YamlNode& node, std::size_t after_colon,
                                         std::vector<TextReplacement> content) {
  const Span span = source_.span(node);
  content.front().text = " " + content.front().text;
  if (source_.comments_between(after_colon, span.begin).empty()) {
    add(after_colon, span.end, std::move(content));
    if (const std::string comments = kept_comments(node); !comments.empty())
      add(span.end, span.end, {0, 0, comments, -1});
    return;
  }
  add(after_colon, after_colon, std::move(content));
  // What was between key and mapping stays; of the mapping's lines, comments stay.
  const std::string indentation = source_.indentation(span.begin);
  const std::size_t begin = span.begin - indentation.size();
  std::string kept;
  for (const Span& comment : source_.comments(node)) kept += indentation + copy(comment) + source_.line_break();
  std::size_t end = span.end;
  while (source_.is_space(end)) ++end;
  if (!ends_line(end))
    kept += indentation;
  else if (end < source_.text().size())
    end += source_.text().compare(end, 2, "\r\n") == 0 ? 2 : 1;
  add(begin, end, {0, 0, kept, -1});
}

/// A key without a value.
void ReplacementCollector::replace_nothing(const YamlNode& key, std::vector<TextReplacement> content) {
  const std::size_t colon = after_colon(key);
  const std::size_t place = colon > 0 ? colon : source_.span(key).end;
  content.front().text = (colon > 0 ? " " : ": ") + content.front().text;
  add(place, place, std::move(content));
}

/// What follows the number: the first comment if it stood behind something, then the others, each on a line of its own.
std::string ReplacementCollector::kept_comments(const YamlNode& node) const {
  const auto comments = source_.comments(node);
  if (comments.empty()) return "";  // looking for line breaks takes time where a line is as long as the spec
  const std::size_t end = source_.span(node).end;
  const std::string new_line = source_.line_break() + source_.indentation(end);
  std::string kept;
  for (const Span& comment : comments) {
    if (kept.empty() && !begins_line(comment.begin)) {
      std::size_t blanks = comment.begin;
      while (source_.is_space(blanks - 1)) --blanks;
      kept = blanks < comment.begin ? copy({blanks, comment.begin}) : " ";
    } else {
      kept += new_line;
    }
    kept += copy(comment);
  }
  return kept.empty() || ends_line(end) ? kept : kept + new_line;
}

void ReplacementCollector::write_out(const YamlNode& alias) {
  const Span span = source_.span(alias);
  std::vector<TextReplacement> pieces{{0, 0, space_before(span.begin), -1}};
  write(alias, span, pieces);
  pieces.back().text += space_after(span.end);
  for (std::size_t i = 0; i < pieces.size(); ++i) add(i == 0 ? span.begin : span.end, span.end, std::move(pieces[i]));
}

/// The node as one line of YAML. A piece ends with its free number.
void ReplacementCollector::write(const YamlNode& node, Span alias, std::vector<TextReplacement>& pieces) {
  const auto put = [&](const std::string& text) { pieces.back().text += text; };
  if (changes(node)) {
    for (const TextReplacement& content : content_of(node, alias)) {
      put(content.text);
      if (content.free_number < 0) continue;
      pieces.back().free_number = content.free_number;
      pieces.emplace_back();
    }
    return;
  }
  if (node.kind == YamlNode::Kind::null || node.kind == YamlNode::Kind::scalar) return put(format_flow(node));
  const bool map = node.kind == YamlNode::Kind::map;
  put(map ? "{" : "[");
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (i > 0) put(", ");
    if (map) write(node.keys[i], alias, pieces);
    if (map) put(": ");
    write(node.items[i], alias, pieces);
  }
  put(map ? "}" : "]");
}

}  // namespace

void list_text_replacements(const YamlNode& root, StudyBuilder& draft) { ReplacementCollector(root, draft).run(); }

}  // namespace balance::specification
