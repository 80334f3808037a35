#include "balance/interface/specification/spec_rewrites.hpp"

#include "balance/interface/specification/yaml_document.hpp"
#include "balance/interface/specification/yaml_source.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>
#include <utility>

namespace balance::specification {

using study::TextReplacement;

namespace {

/// Visits the document in its order.
class ReplacementCollector {
 public:
  ReplacementCollector(const YamlNode& root, StudyBuilder& draft)
      : root_(root), draft_(draft), source_(draft.study.spec_text) {
    for (const FreeNumberEntry& free : draft.parameters.free_numbers()) free_[free.node].push_back(&free);
    for (const FreeNumberEntry& free : draft.free_numbers) free_[free.node].push_back(&free);
    for (const auto& [node, text] : draft.parameters.overridden()) overridden_[node] = format_scalar(text);
  }

  void run() {
    for (std::size_t k = 0; k < draft_.catalogue_nodes.size(); ++k) {
      const Span span = source_.span(*draft_.catalogue_nodes[k]);
      draft_.study.catalogue_choices[k].begin = span.begin;
      draft_.study.catalogue_choices[k].end = span.end;
    }
    if (free_.empty() && overridden_.empty()) return;
    visit(root_, nullptr);
    for (const YamlNode* alias : aliases_)
      if (changed_anchors_.count(alias->alias) > 0) write_out(*alias);
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

  /// @param key of the mapping's entry whose value the node is, if any
  void visit(const YamlNode& node, const YamlNode* key) {
    if (node.alias != 0) return holds_changes(node) ? write_out(node) : aliases_.push_back(&node);
    if (node.anchor != 0) open_anchors_.push_back(node.anchor);
    if (changes(node)) {
      changed_anchors_.insert(open_anchors_.begin(), open_anchors_.end());
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

  /// Replacing a node removes its anchors.
  void collect_nested_anchors(const YamlNode& node) {
    if (node.alias != 0) return;
    if (node.anchor != 0) changed_anchors_.insert(node.anchor);
    for (const auto* children : {&node.keys, &node.items})
      for (const YamlNode& child : *children) collect_nested_anchors(child);
  }

  /// The numbers' indices in the study, in brackets if there are several, or the text of the override. The
  /// first takes the node's place.
  std::vector<TextReplacement> content_of(const YamlNode& node, Span span) {
    if (const auto text = overridden_.find(&node); text != overridden_.end()) return {{0, 0, text->second, -1}};
    const std::vector<const FreeNumberEntry*>& entries = free_.at(&node);
    const bool is_list = entries.front()->is_list_item;
    std::vector<TextReplacement> content;
    for (const FreeNumberEntry* entry : entries) {
      FreeNumber number = entry->number;
      number.begin = span.begin;
      number.end = span.end;
      draft_.study.free_numbers.push_back(number);
      draft_.recording->free.push_back(draft_.recording->input_index(entry->input));
      content.push_back({0, 0,
                         !is_list          ? ""
                         : content.empty() ? "["
                                           : ", ",
                         static_cast<int>(draft_.study.free_numbers.size()) - 1});
    }
    if (is_list) content.push_back({0, 0, "]", -1});
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
  std::unordered_map<const YamlNode*, std::vector<const FreeNumberEntry*>> free_;  ///< in document order
  std::unordered_map<const YamlNode*, std::string> overridden_;
  std::vector<const YamlNode*> aliases_;  ///< that may stay
  std::vector<int> open_anchors_;
  std::set<int> changed_anchors_;  ///< anchors whose value changes or disappears
};

/// Byte behind the key's colon; 0 if it has none.
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
  if (const std::string trailing_text = comments + (comments.empty() ? space_after(span.end) : "");
      !trailing_text.empty())
    add(span.end, span.end, {0, 0, trailing_text, -1});
}

/// A mapping on the lines below its key: the number moves up to the key.
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
  // keep what is between key and mapping; of the mapping's lines, keep comments
  const std::string indentation = source_.indentation(span.begin);
  const std::size_t begin = span.begin - indentation.size();
  std::string text;
  for (const Span& comment : source_.comments(node)) text += indentation + copy(comment) + source_.line_break();
  std::size_t end = span.end;
  while (source_.is_space(end)) ++end;
  if (!ends_line(end))
    text += indentation;
  else if (end < source_.text().size())
    end += source_.text().compare(end, 2, "\r\n") == 0 ? 2 : 1;
  add(begin, end, {0, 0, text, -1});
}

/// A key without a value.
void ReplacementCollector::replace_nothing(const YamlNode& key, std::vector<TextReplacement> content) {
  const std::size_t colon = after_colon(key);
  const std::size_t position = colon > 0 ? colon : source_.span(key).end;
  content.front().text = (colon > 0 ? " " : ": ") + content.front().text;
  add(position, position, std::move(content));
}

/// Text after the number: the first comment if it was behind something, then the others, each on its own line.
std::string ReplacementCollector::kept_comments(const YamlNode& node) const {
  const auto comments = source_.comments(node);
  if (comments.empty()) return "";  // finding line breaks takes time if a line is as long as the spec
  const std::size_t end = source_.span(node).end;
  const std::string new_line = source_.line_break() + source_.indentation(end);
  std::string text;
  for (const Span& comment : comments) {
    if (text.empty() && !begins_line(comment.begin)) {
      std::size_t blanks = comment.begin;
      while (source_.is_space(blanks - 1)) --blanks;
      text = blanks < comment.begin ? copy({blanks, comment.begin}) : " ";
    } else {
      text += new_line;
    }
    text += copy(comment);
  }
  return text.empty() || ends_line(end) ? text : text + new_line;
}

void ReplacementCollector::write_out(const YamlNode& alias) {
  const Span span = source_.span(alias);
  std::vector<TextReplacement> pieces{{0, 0, space_before(span.begin), -1}};
  write(alias, span, pieces);
  pieces.back().text += space_after(span.end);
  for (std::size_t i = 0; i < pieces.size(); ++i) add(i == 0 ? span.begin : span.end, span.end, std::move(pieces[i]));
}

/// Writes the node as one line of YAML. Each piece ends with its free number.
void ReplacementCollector::write(const YamlNode& node, Span alias, std::vector<TextReplacement>& pieces) {
  const auto append = [&](const std::string& text) { pieces.back().text += text; };
  if (changes(node)) {
    for (const TextReplacement& content : content_of(node, alias)) {
      append(content.text);
      if (content.free_number < 0) continue;
      pieces.back().free_number = content.free_number;
      pieces.emplace_back();
    }
    return;
  }
  if (node.kind == YamlNode::Kind::null || node.kind == YamlNode::Kind::scalar) return append(format_flow(node));
  const bool is_map = node.kind == YamlNode::Kind::map;
  append(is_map ? "{" : "[");
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (i > 0) append(", ");
    if (is_map) write(node.keys[i], alias, pieces);
    if (is_map) append(": ");
    write(node.items[i], alias, pieces);
  }
  append(is_map ? "}" : "]");
}

}  // namespace

void list_text_replacements(const YamlNode& root, StudyBuilder& draft) { ReplacementCollector(root, draft).run(); }

}  // namespace balance::specification
