#include "balance/interface/comparison/requirement_parser.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/expression/expression_parser.hpp"
#include "balance/interface/comparison/figure_parser.hpp"
#include "balance/synthesis/design/status_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace balance::comparison {
namespace {

using Kind = RequirementToken::Kind;
using Step = Requirement::PostfixStep;

/// Tokens [begin, end) of the requirement.
struct TokenRange {
  std::size_t begin = 0, end = 0;
};

class RequirementParser {
 public:
  RequirementParser(const std::vector<RequirementToken>& tokens, const std::string& text, const RunNames& runs)
      : tokens_(tokens), text_(text), runs_(runs) {
    requirement_.text = text;
  }

  Requirement parse() {
    check_parentheses();
    parse_logical({0, tokens_.size()});
    return std::move(requirement_);
  }

  FigureExpression parse_arithmetic() {
    check_parentheses();
    const TokenRange all{0, tokens_.size()};
    for (std::size_t i = 0; i < tokens_.size(); ++i)
      if (tokens_[i].kind == Kind::relation || tokens_[i].kind == Kind::logical_and ||
          tokens_[i].kind == Kind::logical_or)
        fail(column(i), fmt::format("expected arithmetic without comparisons, found {}", describe_token(i)));
    if (is_verdict_side(all)) fail(1, "verdict() is a word, not a number: it is for requirements");
    return parse_side(all, nullptr);
  }

 private:
  [[noreturn]] static void fail(std::size_t column, const std::string& message) {
    throw RequirementError(column, message);
  }

  bool is_sign(std::size_t i, char sign) const { return tokens_[i].kind == Kind::symbol && tokens_[i].text[0] == sign; }
  std::size_t column(std::size_t i) const { return i < tokens_.size() ? tokens_[i].column() : text_.size() + 1; }

  std::string describe_token(std::size_t i) const {
    return i < tokens_.size() ? quote_for_message(tokens_[i].text) : "the end";
  }

  /// The text as written. @pre the span is not empty
  std::string source(TokenRange span) const {
    const std::size_t begin = tokens_[span.begin].begin;
    return text_.substr(begin, tokens_[span.end - 1].end - begin);
  }

  /// Finds for every opening parenthesis the one that closes it.
  void check_parentheses() {
    closing_index_.assign(tokens_.size(), 0);
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      if (is_sign(i, '(')) open.push_back(i);
      if (!is_sign(i, ')')) continue;
      if (open.empty()) fail(column(i), "this parenthesis closes nothing");
      closing_index_[open.back()] = i;
      open.pop_back();
    }
    if (!open.empty()) fail(column(open.back()), "the parenthesis is not closed");
  }

  /// The last token of a kind outside parentheses; span.end if there is none.
  std::size_t find_last(TokenRange span, Kind kind) const {
    std::size_t last_index = span.end;
    for (std::size_t i = span.begin; i < span.end; ++i) {
      if (tokens_[i].kind == kind) last_index = i;
      if (is_sign(i, '(')) i = closing_index_[i];
    }
    return last_index;
  }

  bool has_relation(TokenRange span) const {
    return std::any_of(tokens_.begin() + static_cast<std::ptrdiff_t>(span.begin),
                       tokens_.begin() + static_cast<std::ptrdiff_t>(span.end),
                       [](const RequirementToken& token) { return token.kind == Kind::relation; });
  }

  /// Comparisons joined by && and ||, the operator of lower precedence first.
  void parse_logical(TokenRange span) {
    for (const auto& [kind, step] :
         {std::pair{Kind::logical_or, Step::Kind::logical_or}, {Kind::logical_and, Step::Kind::logical_and}}) {
      const std::size_t split_index = find_last(span, kind);
      if (split_index == span.end) continue;
      parse_logical({span.begin, split_index});
      parse_logical({split_index + 1, span.end});
      requirement_.steps.push_back({step, 0});
      return;
    }
    const bool enclosed = span.begin < span.end && is_sign(span.begin, '(') &&
                          closing_index_[span.begin] + 1 == span.end && has_relation(span);
    if (enclosed) return parse_logical({span.begin + 1, span.end - 1});
    requirement_.steps.push_back({Step::Kind::compare, requirement_.comparisons.size()});
    requirement_.comparisons.push_back(compare(span));
  }

  RequirementComparison compare(TokenRange span) {
    if (span.begin == span.end) fail(column(span.begin), "expected a comparison, found " + describe_token(span.begin));
    const std::size_t relation_index = find_last(span, Kind::relation);
    if (relation_index == span.end) {
      if (has_relation(span)) fail(column(span.begin), "a comparison cannot be part of arithmetic");
      fail(column(span.begin),
           fmt::format("expected a comparison (<, <=, >, >= or ==), found {}", quote_for_message(source(span))));
    }
    if (find_last({span.begin, relation_index}, Kind::relation) != relation_index)
      fail(column(relation_index), "a comparison has two sides: join several with && or ||");
    RequirementComparison comparison;
    comparison.column = column(span.begin);
    comparison.relation = relation(tokens_[relation_index].text);
    if (is_verdict_side(span)) return compare_verdict(span, relation_index, std::move(comparison));
    const FigureReference* default_figure = first_figure(span);
    comparison.left = parse_side({span.begin, relation_index}, default_figure);
    comparison.right = parse_side({relation_index + 1, span.end}, default_figure);
    return comparison;
  }

  /// Whether a side of a comparison contains verdict().
  bool is_verdict_side(TokenRange span) const {
    return std::any_of(tokens_.begin() + static_cast<std::ptrdiff_t>(span.begin),
                       tokens_.begin() + static_cast<std::ptrdiff_t>(span.end), [](const RequirementToken& token) {
                         return token.kind == Kind::word || (token.kind == Kind::figure &&
                                                             token.figure.function == find_figure_function("verdict"));
                       });
  }

  RequirementComparison compare_verdict(TokenRange span, std::size_t relation_index, RequirementComparison comparison) {
    const bool is_complete = span.end - span.begin == 3 && relation_index == span.begin + 1 &&
                             tokens_[span.begin].kind == Kind::figure && tokens_[span.begin + 2].kind == Kind::word &&
                             (comparison.relation == Relation::equal || comparison.relation == Relation::unequal);
    if (!is_complete)
      fail(column(span.begin), fmt::format("verdict() is compared with one word, verdict() == proved-best or verdict() "
                                           "!= impossible, found {}",
                                           quote_for_message(source(span))));
    comparison.left = parse_side({span.begin, relation_index}, nullptr);
    comparison.word = tokens_[span.begin + 2].text;
    comparison.right.text = comparison.word;
    return comparison;
  }

  static Relation relation(const std::string& text) {
    for (const Relation candidate : {Relation::less, Relation::at_most, Relation::greater, Relation::at_least,
                                     Relation::equal, Relation::unequal}) {
      if (text == relation_symbol(candidate)) return candidate;
    }
    return Relation::at_most;  // the lexer produces no others
  }

  /// The figure that the name of a run alone refers to; nullptr if the comparison has no figure.
  const FigureReference* first_figure(TokenRange span) const {
    for (std::size_t i = span.begin; i < span.end; ++i) {
      if (tokens_[i].kind == Kind::figure) return &tokens_[i].figure;
    }
    return nullptr;
  }

  FigureExpression parse_side(TokenRange span, const FigureReference* default_figure) {
    FigureExpression side;
    if (span.begin < span.end) side.text = source(span);
    check_order(span);
    for (std::size_t i = span.begin; i < span.end; ++i) {
      const RequirementToken& token = tokens_[i];
      const bool is_run_name = token.kind == Kind::run;
      if (is_run_name && default_figure == nullptr)
        fail(token.column(),
             quote_for_message(token.text) +
                 " alone stands for the comparison's figure in that run, but the comparison has no figure");
      if (is_run_name || token.kind == Kind::figure) {
        FigureReference figure = is_run_name ? *default_figure : token.figure;
        if (is_run_name) figure.run = token.text == "base" && !runs_.base.empty() ? runs_.base : token.text;
        figure.variable = fmt::format("f{}", side.figures.size());
        side.expression += " " + figure.variable;
        side.figures.push_back(std::move(figure));
      } else {
        side.expression += (token.kind == Kind::function ? " " : "") + token.text;
      }
    }
    return side;
  }

  /// Operands and operators must alternate.
  void check_order(TokenRange span) const {
    bool expects_operand = true;
    for (std::size_t i = span.begin; i < span.end; ++i) {
      const RequirementToken& token = tokens_[i];
      const bool opens = token.kind == Kind::function || is_sign(i, '(');
      const bool sign_of_number = is_sign(i, '-') || is_sign(i, '+');
      if (token.kind == Kind::relation) fail(token.column(), "a comparison cannot be part of arithmetic");
      if (token.kind != Kind::symbol || opens) {
        if (!expects_operand) fail(token.column(), "expected an operator, found " + quote_for_message(token.text));
        expects_operand = opens;
      } else if (is_sign(i, ')')) {
        if (expects_operand) fail(token.column(), "expected a number or a figure, found ')'");
      } else {
        if (expects_operand && !sign_of_number)
          fail(token.column(), fmt::format("expected a number or a figure, found {}", quote_for_message(token.text)));
        expects_operand = true;
      }
    }
    if (expects_operand) fail(column(span.end), "expected a number or a figure, found " + describe_token(span.end));
  }

  const std::vector<RequirementToken>& tokens_;
  const std::string& text_;
  const RunNames& runs_;
  std::vector<std::size_t> closing_index_;  ///< per token that opens a parenthesis: the one that closes it
  Requirement requirement_;
};

}  // namespace

Requirement parse_requirement_tokens(const std::vector<RequirementToken>& tokens, const std::string& text,
                                     const RunNames& runs) {
  return RequirementParser(tokens, text, runs).parse();
}

FigureExpression parse_expression_tokens(const std::vector<RequirementToken>& tokens, const std::string& text,
                                         const RunNames& runs) {
  return RequirementParser(tokens, text, runs).parse_arithmetic();
}

namespace {

using Kind = RequirementToken::Kind;

class RequirementLexer : FigureScanner {
 public:
  using FigureScanner::FigureScanner;

  std::vector<RequirementToken> split() {
    std::vector<RequirementToken> tokens;
    for (skip_space(); position_ < text_.size(); skip_space()) {
      tokens.push_back(is_word_expected(tokens) ? verdict_word() : next());
      compares_verdict_ = is_verdict(tokens.back());
    }
    return tokens;
  }

 private:
  static bool is_verdict(const RequirementToken& token) {
    return token.kind == Kind::figure && token.figure.function == find_figure_function("verdict");
  }

  /// Whether the tokens so far end with `verdict() ==`.
  static bool is_word_expected(const std::vector<RequirementToken>& tokens) {
    return tokens.size() > 1 && tokens.back().kind == Kind::relation && is_verdict(tokens[tokens.size() - 2]);
  }

  RequirementToken verdict_word() {
    const std::size_t begin = position_;
    std::string word;
    if (starts_with("'") || starts_with("\"")) {
      word = take_quoted();
    } else {
      while (position_ < text_.size() && (is_name_byte(text_[position_]) || text_[position_] == '-')) ++position_;
      word = text_.substr(begin, position_ - begin);
    }
    const std::vector<std::string>& words = design::design_verdict_words();
    if (std::find(words.begin(), words.end(), word) == words.end())
      fail(begin,
           fmt::format("expected a verdict ({}), found {}{}", join_alternatives(words),
                       word.empty() ? describe_rest() : quote_for_message(word), append_nearest_name(word, words)));
    return {Kind::word, word, begin, position_, {}};
  }

  RequirementToken make_token(Kind kind, std::size_t length) {
    RequirementToken token{kind, text_.substr(position_, length), position_, position_ + length, {}};
    position_ += length;
    return token;
  }

  RequirementToken next() {
    const char c = text_[position_];
    if (c == '\'' || c == '"') return quoted();
    if (const std::size_t length = run_length(); length > 0) return make_token(Kind::run, length);
    if (is_digit(c) || c == '.') return number();
    if (is_name_byte(c)) return name();
    if (starts_with("&&")) return make_token(Kind::logical_and, 2);
    if (starts_with("||")) return make_token(Kind::logical_or, 2);
    if (compares_verdict_ && starts_with("!=")) return make_token(Kind::relation, 2);
    for (const char* relation : {"<=", ">=", "==", "<", ">"}) {
      if (starts_with(relation)) return make_token(Kind::relation, std::string_view(relation).size());
    }
    if (starts_with("=") || starts_with("!="))
      fail(position_, quote_for_message(starts_with("=") ? "=" : "!=") + " is not a comparison: <, <=, >, >= or ==");
    if (std::string_view("+-*/^(),").find(c) != std::string_view::npos) return make_token(Kind::symbol, 1);
    fail(position_, quote_for_message(text_.substr(position_, 1)) + " does not belong in a requirement");
  }

  RequirementToken quoted() {
    const std::size_t begin = position_;
    RequirementToken token{Kind::run, take_quoted(), begin, position_, {}};
    check_run(token.text, begin);
    return token;
  }

  /// Length of the longest run name at the current position; 0 if there is none. A number is a number even if a run has
  /// that name.
  std::size_t run_length() const {
    std::size_t max_length = 0;
    for (const std::string& name : names_) {
      const std::size_t end = position_ + name.size();
      if (name.size() <= max_length || !starts_with(name)) continue;
      if (end < text_.size() && is_name_byte(name.back()) && is_name_byte(text_[end])) continue;
      if (number_length() >= name.size()) continue;
      const std::size_t after = text_.find_first_not_of(" \t", end);
      if (after != std::string::npos && text_[after] == '(' && is_function_name(name)) continue;
      max_length = name.size();
    }
    return max_length;
  }

  static bool is_function_name(const std::string& name) {
    const auto& functions = expression::function_names();
    return std::find(functions.begin(), functions.end(), name) != functions.end() ||
           find_figure_function(name) != nullptr;
  }

  RequirementToken number() {
    const std::size_t length = number_length(), end = position_ + length;
    if (length > 0 && (end == text_.size() || (!is_name_byte(text_[end]) && text_[end] != '.')))
      return make_token(Kind::number, length);
    return name();
  }

  RequirementToken name() {
    std::size_t end = position_;
    while (end < text_.size() && (is_name_byte(text_[end]) || text_[end] == '.')) ++end;
    const std::string identifier = text_.substr(position_, end - position_);
    const std::size_t after = text_.find_first_not_of(" \t", end);
    if (after != std::string::npos && text_[after] == '(') return call(identifier, after);
    if (identifier == "pi") return make_token(Kind::constant, identifier.size());
    const bool quantity = after != std::string::npos && text_[after] == '[';
    if (quantity && runs_.accepts_bare_quantities) return bare_quantity();
    if (quantity)
      fail(position_, fmt::format("{} is a quantity: peak({}[…]), value({}[…], end), rms, mean, range, minimum or "
                                  "maximum of it",
                                  identifier, identifier, identifier));
    check_run(identifier, position_);
    return make_token(Kind::run, identifier.size());
  }

  RequirementToken call(const std::string& identifier, std::size_t parenthesis) {
    if (const FigureFunction* function = find_figure_function(identifier)) {
      RequirementToken token{Kind::figure, "", position_, position_, {}};
      token.figure = read_call(*function, parenthesis);
      return finish_figure(std::move(token));
    }
    const auto& functions = expression::function_names();
    if (std::find(functions.begin(), functions.end(), identifier) != functions.end())
      return make_token(Kind::function, identifier.size());
    std::vector<std::string> names;
    for (const FigureFunction& function : figure_functions()) names.emplace_back(function.name);
    const std::string figure_names = join_alternatives(names);
    names.insert(names.end(), functions.begin(), functions.end());
    fail(position_, fmt::format("{} is not a function: {}, or arithmetic{}", quote_for_message(identifier),
                                figure_names, append_nearest_name(identifier, names)));
  }

  /// `torque[J1]` for `value(torque[J1])`.
  RequirementToken bare_quantity() {
    RequirementToken token{Kind::figure, "", position_, position_, {}};
    token.figure.function = find_figure_function("value");
    token.figure.column = position_ + 1;
    token.figure.quantity = read_quantity("value");
    return finish_figure(std::move(token));
  }

  RequirementToken finish_figure(RequirementToken token) const {
    token.end = position_;
    token.text = text_.substr(token.begin, token.end - token.begin);
    return token;
  }

  bool compares_verdict_ = false;  ///< the last token was verdict()
};

}  // namespace

std::vector<RequirementToken> tokenise_requirement(const std::string& text, const RunNames& runs) {
  return RequirementLexer(text, runs).split();
}

}  // namespace balance::comparison
