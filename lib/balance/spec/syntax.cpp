#include "balance/spec/syntax.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

namespace balance::specification {

namespace {

ReadError syntax_problem(NodeLocation place, const std::string& what, const std::string& hint = "") {
  return {place, "", {.expected = "YAML", .found = "an error of syntax: " + what, .hint = hint}};
}

/// Behind the quote that closes the one at `begin`; the text's size if there is none.
std::size_t end_of_quoted(const std::string& text, std::size_t begin) {
  const char quote = text[begin];
  for (std::size_t i = begin + 1; i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\') {
      ++i;
    } else if (text[i] == quote) {
      if (quote == '"' || i + 1 >= text.size() || text[i + 1] != quote) return i + 1;
      ++i;  // two of them stand for one
    }
  }
  return std::string::npos;
}

/// Looks for brackets and quotes that have no counterpart. It knows of YAML what it takes to tell brackets and quotes from text.
class SyntaxScanner {
 public:
  explicit SyntaxScanner(const std::string& text) : text_(text) {}

  std::optional<ReadError> diagnose() {
    while (at_ < text_.size() && !odd_) step();
    if (!odd_ && !open_.empty())
      odd_ = syntax_problem(place(open_.back()), fmt::format("'{}' is not closed", text_[open_.back()]));
    return odd_;
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
      fresh_ = fresh_ || open_.empty();
      closed_ = false;
      ++at_;
    } else if (is_blank(c)) {
      ++at_;
    } else if (c == '#' && (at_ == 0 || is_blank(text_[at_ - 1]))) {
      skip_line();
    } else if (fresh_ && (c == '"' || c == '\'')) {
      quoted();
    } else if ((c == '[' || c == '{') && (fresh_ || !open_.empty())) {
      open_.push_back(at_++);
      fresh_ = true;
    } else if ((c == ']' || c == '}') && (fresh_ || closed_ || !open_.empty())) {
      close(c);
    } else if (fresh_ && open_.empty() && (c == '|' || c == '>')) {
      block();
    } else {
      const bool key = c == ':' && (is_blank(next()) || (!open_.empty() && std::strchr(",[]{}", next()) != nullptr));
      const bool mark = fresh_ && ((std::strchr("-?", c) != nullptr && is_blank(next())));
      const bool tag = fresh_ && (c == '&' || c == '!');
      if (tag) at_ = std::min(text_.find_first_of(" \t\r\n", at_), text_.size()) - 1;
      fresh_ = key || mark || tag || (c == ',' && !open_.empty());
      closed_ = false;
      ++at_;
    }
  }

  void quoted() {
    const std::size_t begin = at_, end = end_of_quoted(text_, at_);
    if (end == std::string::npos) {
      odd_ = syntax_problem(place(begin), fmt::format("the quote {} is not closed", text_[begin]));
      return;
    }
    const std::size_t rest = text_.find_first_not_of(" \t\r", end);
    if (rest != std::string::npos && std::strchr(":,]}#\n", text_[rest]) == nullptr) {
      const NodeLocation from = place(begin), to = place(end - 1);
      const bool several = from.line != to.line;
      odd_ = several ? syntax_problem(
                           from, fmt::format("the quote {} is closed no sooner than in line {}", text_[begin], to.line))
                     : syntax_problem(place(rest), "text behind a closing quote");
      return;
    }
    at_ = end;
    fresh_ = false;
    closed_ = true;
  }

  void close(char c) {
    if (open_.empty()) {
      odd_ = syntax_problem(place(at_), fmt::format("'{}' closes nothing", c));
      return;
    }
    const char opened = text_[open_.back()];
    if ((opened == '[') != (c == ']')) {
      const NodeLocation from = place(open_.back());
      odd_ = syntax_problem(place(at_), fmt::format("'{}' where the '{}' of line {}, column {} wants a '{}'", c, opened,
                                                    from.line, from.column, opened == '[' ? ']' : '}'));
      return;
    }
    open_.pop_back();
    ++at_;
    fresh_ = false;
    closed_ = true;
  }

  /// Text on lines of its own that are farther to the right.
  void block() {
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
    fresh_ = true;
  }

  const std::string& text_;
  std::size_t at_ = 0;
  bool fresh_ = true;    ///< a value may begin here
  bool closed_ = false;  ///< behind a bracket or a quote
  std::vector<std::size_t> open_;
  std::optional<ReadError> odd_;
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

/// Two keys run into one text where the first lacks its colon, or the blank behind it.
std::optional<ReadError> find_missing_colon(const std::string& text, NodeLocation noticed) {
  const auto lines = lines_until(text, noticed.line);
  if (static_cast<int>(lines.size()) < noticed.line) return std::nullopt;
  const auto indent = [](std::string_view line) { return line.find_first_not_of(' '); };
  const std::size_t here = indent(lines.back());
  for (std::size_t i = lines.size() - 1; i-- > 0;) {
    const std::string_view line = lines[i];
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos || line[begin] == '#') continue;
    const std::string_view content = line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin);
    const bool word = std::isalpha(static_cast<unsigned char>(content[0])) != 0;
    const bool keyed = content.ends_with(':') || content.find(": ") != std::string_view::npos;
    if (!word || keyed || begin > here || content.find_first_of("[]{}\"'#,") != std::string_view::npos)
      return std::nullopt;
    const bool glued = content.find(':') != std::string_view::npos;
    return syntax_problem({static_cast<int>(i) + 1, static_cast<int>(begin) + 1}, "a line that is no 'key: value'",
                          glued ? "a blank belongs behind the colon" : "a colon belongs behind the key");
  }
  return std::nullopt;
}

/// What a parser's words mean for the one who wrote the text.
std::string hint_on(const std::string& text, NodeLocation noticed, const std::string& why) {
  const auto lines = lines_until(text, noticed.line);
  const bool there = static_cast<int>(lines.size()) == noticed.line && noticed.column >= 1;
  const std::string_view line = there ? lines.back() : std::string_view();
  const auto column = static_cast<std::size_t>(std::max(noticed.column, 1)) - 1;
  if (why == "illegal map value" && line.substr(0, column).find(": ") != std::string_view::npos)
    return "text that has ': ' in it stands in quotes";
  if (why == "illegal map value" || why == "end of map not found" || why == "end of sequence not found")
    return "this line or the one above is not indented as its neighbours are";
  if (why == "end of map flow not found" || why == "end of sequence flow not found") return "a ',' is missing before";
  if (why == "unknown token" && column < line.size())
    return fmt::format("text that begins with '{}' stands in quotes", line[column]);
  return "";
}

}  // namespace

bool is_quote_closed(const std::string& text, std::size_t begin) {
  while (begin < text.size() && (text[begin] == '&' || text[begin] == '!'))
    begin = text.find_first_not_of(" \t\r\n", std::min(text.find_first_of(" \t\r\n", begin), text.size()));
  const bool quoted = begin < text.size() && (text[begin] == '"' || text[begin] == '\'');
  return !quoted || end_of_quoted(text, begin) != std::string::npos;
}

ReadError diagnose_syntax_error(const std::string& text, NodeLocation noticed, const std::string& why) {
  if (auto odd = SyntaxScanner(text).diagnose()) return *odd;
  if (why == "illegal map value")
    if (auto odd = find_missing_colon(text, noticed)) return *odd;
  return syntax_problem(noticed, why, hint_on(text, noticed, why));
}

}  // namespace balance::specification
