#pragma once
/// Where values in a spec's text end, and which comments they contain: yaml-cpp gives only where values begin.

#include "balance/interface/specification/yaml_document.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace balance::specification {

/// Bytes [begin, end) of the text.
struct Span {
  std::size_t begin = 0, end = 0;
};

/// A text that is known to be YAML. All nodes must be its own; of a copy only the alias itself is considered.
class SourceText {
 public:
  /// @param text must outlive this
  explicit SourceText(const std::string& text) : text_(text) {}

  const std::string& text() const { return text_; }
  /// Span of the node: from its anchor or tag to its last character. Empty if it has no text.
  Span span(const YamlNode& node) const { return {node.begin, end(node)}; }
  /// Comments inside the node, without their line breaks.
  std::vector<Span> comments(const YamlNode& node) const;
  /// Comments in a range that contains nothing else but blanks, punctuation, anchors and tags.
  std::vector<Span> comments_between(std::size_t begin, std::size_t end) const;
  /// The first byte at or after `at` that is neither blank nor in a comment.
  std::size_t skip_blank(std::size_t at) const;
  /// The end of the line that contains `at`, without its line break.
  std::size_t line_end(std::size_t at) const;
  /// Blanks at the beginning of the line that contains `at`.
  std::string indentation(std::size_t at) const;
  /// The line break of this text.
  std::string line_break() const;
  bool is_break(std::size_t at) const { return at < text_.size() && (text_[at] == '\n' || text_[at] == '\r'); }
  /// Space or tab.
  bool is_space(std::size_t at) const { return at < text_.size() && (text_[at] == ' ' || text_[at] == '\t'); }

 private:
  bool is_one_of(std::size_t at, const char* characters) const;
  std::size_t word_end(std::size_t at) const;
  std::size_t content(const YamlNode& node) const;
  std::size_t end(const YamlNode& node) const;
  std::size_t scalar_end(std::size_t at, const std::string& value) const;
  std::size_t quoted_end(std::size_t at) const;
  std::size_t null_end(const YamlNode& node) const;
  std::size_t collection_end(const YamlNode& node) const;
  void append_leaf_spans(const YamlNode& node, std::vector<Span>& spans) const;

  const std::string& text_;
};

}  // namespace balance::specification
