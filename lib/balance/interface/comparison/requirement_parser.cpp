#include "balance/interface/comparison/requirement_parser.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/expression/expression_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace balance::specification {
namespace {

using Kind = RequirementToken::Kind;
using Step = Requirement::PostfixStep;

/// Words [begin, end) of the requirement.
struct TokenRange {
  std::size_t begin = 0, end = 0;
};

class RequirementParser {
 public:
  RequirementParser(const std::vector<RequirementToken>& words, const std::string& text, const RunNames& runs)
      : words_(words), text_(text), runs_(runs) {
    requirement_.text = text;
  }

  Requirement parse() {
    check_parentheses();
    join({0, words_.size()});
    return std::move(requirement_);
  }

 private:
  [[noreturn]] static void fail(std::size_t column, const std::string& message) {
    throw RequirementError(column, message);
  }

  bool is_sign(std::size_t i, char sign) const { return words_[i].kind == Kind::symbol && words_[i].text[0] == sign; }
  std::size_t column(std::size_t i) const { return i < words_.size() ? words_[i].column() : text_.size() + 1; }

  std::string next(std::size_t i) const { return i < words_.size() ? quote_for_message(words_[i].text) : "the end"; }

  /// As written; the words must not be none.
  std::string source(TokenRange span) const {
    const std::size_t begin = words_[span.begin].begin;
    return text_.substr(begin, words_[span.end - 1].end - begin);
  }

  /// Finds for every opening parenthesis the one that closes it.
  void check_parentheses() {
    closing_.assign(words_.size(), 0);
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < words_.size(); ++i) {
      if (is_sign(i, '(')) open.push_back(i);
      if (!is_sign(i, ')')) continue;
      if (open.empty()) fail(column(i), "there is no parenthesis that this one could close");
      closing_[open.back()] = i;
      open.pop_back();
    }
    if (!open.empty()) fail(column(open.back()), "the parenthesis is not closed");
  }

  /// The last word of a kind outside parentheses; span.end: there is none.
  std::size_t last(TokenRange span, Kind kind) const {
    std::size_t found = span.end;
    for (std::size_t i = span.begin; i < span.end; ++i) {
      if (words_[i].kind == kind) found = i;
      if (is_sign(i, '(')) i = closing_[i];
    }
    return found;
  }

  bool has_relation(TokenRange span) const {
    return std::any_of(words_.begin() + static_cast<std::ptrdiff_t>(span.begin),
                       words_.begin() + static_cast<std::ptrdiff_t>(span.end),
                       [](const RequirementToken& word) { return word.kind == Kind::relation; });
  }

  /// Comparisons joined by && and ||, the weaker first.
  void join(TokenRange span) {
    for (const auto& [word, step] :
         {std::pair{Kind::logical_or, Step::Kind::logical_or}, {Kind::logical_and, Step::Kind::logical_and}}) {
      const std::size_t at = last(span, word);
      if (at == span.end) continue;
      join({span.begin, at});
      join({at + 1, span.end});
      requirement_.steps.push_back({step, 0});
      return;
    }
    const bool enclosed =
        span.begin < span.end && is_sign(span.begin, '(') && closing_[span.begin] + 1 == span.end && has_relation(span);
    if (enclosed) return join({span.begin + 1, span.end - 1});
    requirement_.steps.push_back({Step::Kind::compare, requirement_.comparisons.size()});
    requirement_.comparisons.push_back(compare(span));
  }

  RequirementComparison compare(TokenRange span) {
    if (span.begin == span.end) fail(column(span.begin), "expected a comparison, found " + next(span.begin));
    const std::size_t at = last(span, Kind::relation);
    if (at == span.end) {
      if (has_relation(span)) fail(column(span.begin), "a comparison cannot be part of arithmetic");
      fail(column(span.begin),
           fmt::format("expected a comparison (<, <=, >, >= or ==), found {}", quote_for_message(source(span))));
    }
    if (last({span.begin, at}, Kind::relation) != at)
      fail(column(at), "one comparison has two sides: join several by && or ||");
    RequirementComparison comparison;
    comparison.column = column(span.begin);
    comparison.relation = relation(words_[at].text);
    const FigureReference* model = first_figure(span);
    comparison.left = parse_side({span.begin, at}, model);
    comparison.right = parse_side({at + 1, span.end}, model);
    return comparison;
  }

  static Relation relation(const std::string& text) {
    for (const Relation one :
         {Relation::less, Relation::at_most, Relation::greater, Relation::at_least, Relation::equal}) {
      if (text == relation_symbol(one)) return one;
    }
    return Relation::at_most;  // the splitter makes no others
  }

  /// What the name of a run alone stands for. Null: the comparison has no figure.
  const FigureReference* first_figure(TokenRange span) const {
    for (std::size_t i = span.begin; i < span.end; ++i) {
      if (words_[i].kind == Kind::figure) return &words_[i].figure;
    }
    return nullptr;
  }

  FigureExpression parse_side(TokenRange span, const FigureReference* model) {
    FigureExpression side;
    if (span.begin < span.end) side.text = source(span);
    check_order(span);
    for (std::size_t i = span.begin; i < span.end; ++i) {
      const RequirementToken& word = words_[i];
      const bool alone = word.kind == Kind::run;
      if (alone && model == nullptr)
        fail(word.column(),
             quote_for_message(word.text) + " alone stands for the same figure of that run: the comparison has none");
      if (alone || word.kind == Kind::figure) {
        FigureReference figure = alone ? *model : word.figure;
        if (alone) figure.run = word.text == "base" && !runs_.base.empty() ? runs_.base : word.text;
        figure.variable = fmt::format("f{}", side.figures.size());
        side.expression += " " + figure.variable;
        side.figures.push_back(std::move(figure));
      } else {
        side.expression += (word.kind == Kind::function ? " " : "") + word.text;
      }
    }
    return side;
  }

  /// Numbers and what joins them must take turns.
  void check_order(TokenRange span) const {
    bool number_next = true;
    for (std::size_t i = span.begin; i < span.end; ++i) {
      const RequirementToken& word = words_[i];
      const bool opens = word.kind == Kind::function || is_sign(i, '(');
      const bool sign_of_number = is_sign(i, '-') || is_sign(i, '+');
      if (word.kind == Kind::relation) fail(word.column(), "a comparison cannot be part of arithmetic");
      if (word.kind != Kind::symbol || opens) {
        if (!number_next) fail(word.column(), "expected an operator, found " + quote_for_message(word.text));
        number_next = opens;
      } else if (is_sign(i, ')')) {
        if (number_next) fail(word.column(), "expected a number or a figure, found ')'");
      } else {
        if (number_next && !sign_of_number)
          fail(word.column(), fmt::format("expected a number or a figure, found {}", quote_for_message(word.text)));
        number_next = true;
      }
    }
    if (number_next) fail(column(span.end), "expected a number or a figure, found " + next(span.end));
  }

  const std::vector<RequirementToken>& words_;
  const std::string& text_;
  const RunNames& runs_;
  std::vector<std::size_t> closing_;  ///< per word that opens a parenthesis
  Requirement requirement_;
};

}  // namespace

Requirement parse_requirement_tokens(const std::vector<RequirementToken>& words, const std::string& text,
                                     const RunNames& runs) {
  return RequirementParser(words, text, runs).parse();
}

namespace {

using Kind = RequirementToken::Kind;

struct FigureFunction {
  const char* name;
  std::optional<Statistic> figure;
};

const std::array<FigureFunction, 5> figure_functions{{{"peak", Statistic::peak},
                                                      {"rms", Statistic::rms},
                                                      {"mean", Statistic::mean},
                                                      {"range", Statistic::range},
                                                      {"energy", std::nullopt}}};

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }
/// Bytes beyond ASCII belong to names.
bool is_name_byte(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || (c & 0x80) != 0; }

class RequirementLexer {
 public:
  RequirementLexer(const std::string& text, const RunNames& runs) : text_(text), runs_(runs), names_(runs.all) {
    if (!runs.base.empty()) names_.emplace_back("base");
  }

  std::vector<RequirementToken> split() {
    std::vector<RequirementToken> words;
    for (skip_space(); at_ < text_.size(); skip_space()) words.push_back(next());
    return words;
  }

 private:
  [[noreturn]] static void fail(std::size_t at, const std::string& message) { throw RequirementError(at + 1, message); }

  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }

  bool starts_with(std::string_view part) const { return text_.compare(at_, part.size(), part) == 0; }

  RequirementToken take(Kind kind, std::size_t length) {
    RequirementToken word{kind, text_.substr(at_, length), at_, at_ + length, {}};
    at_ += length;
    return word;
  }

  RequirementToken next() {
    const char c = text_[at_];
    if (c == '\'' || c == '"') return quoted();
    if (const std::size_t length = run_length(); length > 0) return take(Kind::run, length);
    if (is_digit(c) || c == '.') return number();
    if (is_name_byte(c)) return name();
    if (starts_with("&&")) return take(Kind::logical_and, 2);
    if (starts_with("||")) return take(Kind::logical_or, 2);
    for (const char* relation : {"<=", ">=", "==", "<", ">"}) {
      if (starts_with(relation)) return take(Kind::relation, std::string_view(relation).size());
    }
    if (starts_with("=") || starts_with("!="))
      fail(at_, quote_for_message(starts_with("=") ? "=" : "!=") + " is no comparison: <, <=, >, >= or ==");
    if (std::string_view("+-*/^(),").find(c) != std::string_view::npos) return take(Kind::symbol, 1);
    fail(at_, quote_for_message(text_.substr(at_, 1)) + " does not belong in a requirement");
  }

  RequirementToken quoted() {
    const std::size_t begin = at_;
    RequirementToken word{Kind::run, take_quoted(), begin, at_, {}};
    check_run(word.text, begin);
    return word;
  }

  /// What stands between two equal marks.
  std::string take_quoted() {
    const std::size_t close = text_.find(text_[at_], at_ + 1);
    if (close == std::string::npos) fail(at_, "the quote has no end");
    std::string inside = text_.substr(at_ + 1, close - at_ - 1);
    at_ = close + 1;
    return inside;
  }

  /// Of the longest run's name that stands here; 0: none. A number is a number even if a run is called so.
  std::size_t run_length() const {
    std::size_t longest = 0;
    for (const std::string& name : names_) {
      const std::size_t end = at_ + name.size();
      if (name.size() <= longest || !starts_with(name)) continue;
      if (end < text_.size() && is_name_byte(name.back()) && is_name_byte(text_[end])) continue;
      if (number_length() >= name.size()) continue;
      const std::size_t after = text_.find_first_not_of(" \t", end);
      if (after != std::string::npos && text_[after] == '(' && is_word_with_parenthesis(name)) continue;
      longest = name.size();
    }
    return longest;
  }

  static bool is_word_with_parenthesis(const std::string& name) {
    const auto& functions = function_names();
    return std::find(functions.begin(), functions.end(), name) != functions.end() ||
           std::any_of(figure_functions.begin(), figure_functions.end(),
                       [&](const FigureFunction& one) { return name == one.name; });
  }

  /// Of the digits, point and exponent that stand here.
  std::size_t number_length() const {
    std::size_t end = at_;
    const auto digits = [&](std::size_t from) {
      while (from < text_.size() && is_digit(text_[from])) ++from;
      return from;
    };
    end = digits(end);
    if (end < text_.size() && text_[end] == '.') end = digits(end + 1);
    if (end == at_ || (end == at_ + 1 && text_[at_] == '.')) return 0;
    if (end < text_.size() && (text_[end] == 'e' || text_[end] == 'E')) {
      const bool sign = end + 1 < text_.size() && (text_[end + 1] == '+' || text_[end + 1] == '-');
      const std::size_t exponent = end + (sign ? 2 : 1);
      if (digits(exponent) > exponent) end = digits(exponent);
    }
    return end - at_;
  }

  RequirementToken number() {
    const std::size_t length = number_length(), end = at_ + length;
    if (length > 0 && (end == text_.size() || (!is_name_byte(text_[end]) && text_[end] != '.')))
      return take(Kind::number, length);
    return name();
  }

  RequirementToken name() {
    std::size_t end = at_;
    while (end < text_.size() && (is_name_byte(text_[end]) || text_[end] == '.')) ++end;
    const std::string word = text_.substr(at_, end - at_);
    const std::size_t after = text_.find_first_not_of(" \t", end);
    if (after != std::string::npos && text_[after] == '(') return call(word, after);
    if (word == "pi") return take(Kind::constant, word.size());
    const bool quantity = after != std::string::npos && text_[after] == '[';
    if (quantity) fail(at_, fmt::format("{} is a quantity: peak({}[…]), rms, mean or range of it", word, word));
    check_run(word, at_);
    return take(Kind::run, word.size());
  }

  RequirementToken call(const std::string& word, std::size_t parenthesis) {
    for (const FigureFunction& one : figure_functions) {
      if (word == one.name) return figure(one, parenthesis);
    }
    const auto& functions = function_names();
    if (std::find(functions.begin(), functions.end(), word) != functions.end())
      return take(Kind::function, word.size());
    std::vector<std::string> names;
    for (const FigureFunction& one : figure_functions) names.emplace_back(one.name);
    const std::string own = join_alternatives(names);
    names.insert(names.end(), functions.begin(), functions.end());
    fail(at_, fmt::format("{} is no function: {}, or arithmetic{}", quote_for_message(word), own,
                          append_nearest_name(word, names)));
  }

  /// `peak(torque[A1], base)` from its name on; a quantity may have anything in its brackets.
  RequirementToken figure(const FigureFunction& named, std::size_t parenthesis) {
    const std::size_t begin = at_;
    RequirementToken word{Kind::figure, "", begin, begin, {}};
    word.figure.figure = named.figure;
    word.figure.column = begin + 1;
    at_ = parenthesis + 1;
    skip_space();
    if (named.figure) {
      word.figure.column = at_ + 1;
      word.figure.quantity = quantity(named.name);
      skip_space();
      if (starts_with(",")) {
        ++at_;
        skip_space();
        word.figure.run = run_argument();
      }
    } else if (!starts_with(")")) {
      word.figure.run = run_argument();
    }
    skip_space();
    if (at_ == text_.size()) fail(parenthesis, "the parenthesis is not closed");
    if (!starts_with(")")) fail(at_, fmt::format("expected ')' behind what {} is of, found {}", named.name, rest()));
    word.end = ++at_;
    word.text = text_.substr(begin, word.end - begin);
    return word;
  }

  std::string quantity(const char* figure) {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_name_byte(text_[at_]) || text_[at_] == '.')) ++at_;
    if (at_ == begin)
      fail(begin,
           fmt::format("expected a quantity such as shaking_force or torque[A1] for {}, found {}", figure, rest()));
    if (at_ < text_.size() && text_[at_] == '[') {
      const std::size_t close = text_.find(']', at_);
      if (close == std::string::npos) fail(at_, "the bracket is not closed");
      at_ = close + 1;
    }
    return text_.substr(begin, at_ - begin);
  }

  /// The name of a run up to the end of the call.
  std::string run_argument() {
    const std::size_t begin = at_;
    if (at_ < text_.size() && (text_[at_] == '\'' || text_[at_] == '"')) {
      std::string name = take_quoted();
      check_run(name, begin);
      return resolve(name);
    }
    std::size_t end = std::min(text_.find(')', at_), text_.size());
    // Names may have parentheses themselves.
    for (const std::string& name : names_) {
      if (starts_with(name) && at_ + name.size() > end) end = at_ + name.size();
    }
    while (end > begin && is_space(text_[end - 1])) --end;
    const std::string name = text_.substr(begin, end - begin);
    if (name.empty()) fail(begin, "expected the name of a run, found " + rest());
    check_run(name, begin);
    at_ = end;
    return resolve(name);
  }

  std::string resolve(const std::string& name) const {
    return name == "base" && !runs_.base.empty() ? runs_.base : name;
  }

  void check_run(const std::string& name, std::size_t at) const {
    if (std::find(names_.begin(), names_.end(), name) != names_.end()) return;
    if (names_.empty())
      fail(at, fmt::format("{} is no number and no figure: there are no other runs", quote_for_message(name)));
    fail(at, fmt::format("no run is called {}: {}{}", quote_for_message(name), join_alternatives(names_),
                         append_nearest_name(name, names_)));
  }

  std::string rest() const { return at_ == text_.size() ? "the end" : quote_for_message(text_.substr(at_)); }

  const std::string& text_;
  const RunNames& runs_;
  std::vector<std::string> names_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<RequirementToken> tokenise_requirement(const std::string& text, const RunNames& runs) {
  return RequirementLexer(text, runs).split();
}

}  // namespace balance::specification
