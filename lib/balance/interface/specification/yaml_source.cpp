#include "balance/interface/specification/yaml_source.hpp"

#include <cstring>

namespace balance::specification {

namespace {
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
}  // namespace

bool SourceText::is_one_of(std::size_t at, const char* characters) const {
  return at < text_.size() && std::strchr(characters, text_[at]) != nullptr;
}

std::size_t SourceText::line_end(std::size_t at) const {
  return std::min(text_.find_first_of("\r\n", at), text_.size());
}

std::string SourceText::indentation(std::size_t at) const {
  const auto line_break_before = at == 0 ? std::string::npos : text_.find_last_of("\r\n", at - 1);
  const std::size_t begin = line_break_before == std::string::npos ? 0 : line_break_before + 1;
  std::size_t end = begin;
  while (is_space(end)) ++end;
  return text_.substr(begin, end - begin);
}

std::string SourceText::line_break() const {
  const auto at = text_.find_first_of("\r\n");
  if (at == std::string::npos) return "\n";
  return text_.compare(at, 2, "\r\n") == 0 ? "\r\n" : text_.substr(at, 1);
}

std::size_t SourceText::skip_blank(std::size_t at) const {
  while (at < text_.size()) {
    if (text_[at] == '#')
      at = line_end(at);
    else if (is_blank(text_[at]))
      ++at;
    else
      break;
  }
  return at;
}

/// The end of an alias, an anchor or a tag.
std::size_t SourceText::word_end(std::size_t at) const {
  if (text_.compare(at, 2, "!<") == 0) return std::min(text_.find('>', at), text_.size() - 1) + 1;
  while (at < text_.size() && !is_blank(text_[at]) && !is_one_of(at, "[]{},")) ++at;
  return at;
}

/// Beginning of the value itself, after its anchor and tag.
std::size_t SourceText::content(const YamlNode& node) const {
  std::size_t at = skip_blank(node.begin);
  while (is_one_of(at, "&!")) at = skip_blank(word_end(at));
  return at;
}

std::size_t SourceText::end(const YamlNode& node) const {
  if (node.alias != 0) return word_end(node.begin);
  switch (node.kind) {
    case YamlNode::Kind::null: return null_end(node);
    case YamlNode::Kind::scalar: return scalar_end(content(node), node.text);
    case YamlNode::Kind::list:
    case YamlNode::Kind::map: return collection_end(node);
  }
  return node.begin;
}

/// The characters of a value without quotes appear in the text unchanged; only blanks between them may differ.
std::size_t SourceText::scalar_end(std::size_t at, const std::string& value) const {
  if (is_one_of(at, "\"'")) return quoted_end(at);
  if (is_one_of(at, "|>")) at = line_end(at);
  std::size_t end = at;
  for (const char c : value) {
    if (is_blank(c)) continue;
    while (at < text_.size() && is_blank(text_[at])) ++at;
    end = ++at;
  }
  return std::min(end, text_.size());
}

std::size_t SourceText::quoted_end(std::size_t at) const {
  const char quote = text_[at];
  for (++at; at < text_.size(); ++at) {
    if (quote == '"' && text_[at] == '\\')
      ++at;
    else if (text_[at] == quote && (quote == '"' || at + 1 >= text_.size() || text_[at + 1] != quote))
      return at + 1;
    else if (text_[at] == quote)
      ++at;
  }
  return text_.size();
}

/// `~` and `null` have a text, an empty value has none: yaml-cpp then gives the beginning of what comes
/// next, perhaps a key `null`.
std::size_t SourceText::null_end(const YamlNode& node) const {
  const std::size_t at = content(node);
  for (const char* word : {"~", "null", "Null", "NULL"}) {
    const std::size_t end = at + std::strlen(word);
    if (text_.compare(at, end - at, word) != 0) continue;
    const bool whole = end >= text_.size() || is_blank(text_[end]) || is_one_of(end, "[]{},");
    std::size_t next = end;
    while (is_space(next)) ++next;
    if (whole && !is_one_of(next, ":")) return end;
  }
  return node.begin;
}

std::size_t SourceText::collection_end(const YamlNode& node) const {
  const std::size_t begin = content(node);
  std::size_t at = begin;
  if (!node.items.empty()) at = end(node.items.back());
  if (!node.keys.empty()) at = std::max(at, end(node.keys.back()));
  // A mapping of one entry in a list needs no braces.
  if (!node.is_flow || !is_one_of(begin, "[{")) return at;
  if (node.items.empty()) ++at;
  for (at = skip_blank(at); is_one_of(at, ",:"); at = skip_blank(at + 1)) {
  }
  return std::min(at + 1, text_.size());
}

void SourceText::append_leaf_spans(const YamlNode& node, std::vector<Span>& spans) const {
  if (node.alias != 0) {
    spans.push_back({node.begin, end(node)});
  } else if (node.kind == YamlNode::Kind::scalar) {
    const std::size_t begin = content(node);
    // the line of `|` and `>` may end with a comment
    if (is_one_of(begin, "|>")) spans.push_back({begin, begin + 1});
    spans.push_back({is_one_of(begin, "|>") ? line_end(begin) : begin, end(node)});
  } else {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      if (i < node.keys.size()) append_leaf_spans(node.keys[i], spans);
      append_leaf_spans(node.items[i], spans);
    }
  }
}

std::vector<Span> SourceText::comments_between(std::size_t begin, std::size_t end) const {
  std::vector<Span> spans;
  for (std::size_t at = begin; at < end;) {
    if (is_one_of(at, "&!")) {
      at = word_end(at);
    } else if (text_[at] == '#') {
      spans.push_back({at, line_end(at)});
      at = spans.back().end;
    } else {
      ++at;
    }
  }
  return spans;
}

std::vector<Span> SourceText::comments(const YamlNode& node) const {
  std::vector<Span> result, leaf_spans;
  append_leaf_spans(node, leaf_spans);
  std::size_t at = node.begin;
  const auto add = [&](std::size_t until) {
    const auto spans = comments_between(at, until);
    result.insert(result.end(), spans.begin(), spans.end());
  };
  for (const Span& value : leaf_spans) {
    add(value.begin);
    at = value.end;
  }
  add(end(node));
  return result;
}

}  // namespace balance::specification
