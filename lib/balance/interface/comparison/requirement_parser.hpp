#pragma once
/// Splits a requirement into tokens, and parses them.

#include "balance/interface/comparison/requirement.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace balance::comparison {

struct RequirementToken {
  enum class Kind {
    number,       ///< 0.9, 1e-3
    run,          ///< the name of a run, quoted or not
    figure,       ///< peak(…), energy(…): the whole call
    function,     ///< sqrt; its parenthesis is a separate token
    constant,     ///< pi
    symbol,       ///< + - * / ^ ( ) ,
    relation,     ///< < <= > >= ==, and != after verdict()
    word,         ///< a verdict: proved-best
    logical_and,  ///< &&
    logical_or,   ///< ||
  };
  Kind kind = Kind::number;
  std::string text;       ///< as written; for a run, its name without quotes
  std::size_t begin = 0;  ///< bytes of the requirement [begin, end)
  std::size_t end = 0;
  FigureReference figure;  ///< if the token is a figure

  std::size_t column() const { return begin + 1; }
};

/// @throws RequirementError for anything that is not a token of the language
std::vector<RequirementToken> tokenise_requirement(const std::string& text, const RunNames& runs);

/// Parses the tokens. @throws RequirementError if they do not form a requirement
Requirement parse_requirement_tokens(const std::vector<RequirementToken>& tokens, const std::string& text,
                                     const RunNames& runs);

/// Parses tokens without a relation. @throws RequirementError if they are not arithmetic
FigureExpression parse_expression_tokens(const std::vector<RequirementToken>& tokens, const std::string& text,
                                         const RunNames& runs);

}  // namespace balance::comparison
