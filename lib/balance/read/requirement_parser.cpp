#include "balance/base/nearest.hpp"
#include "balance/read/requirement_text.hpp"

#include <fmt/format.h>

#include <algorithm>

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

}  // namespace balance::specification
