#pragma once
/// The grammar of figures: their arguments, moments and names of runs.

#include "balance/interface/comparison/requirement.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace balance::comparison {

/// The figure of that name; nullptr if there is none.
const FigureFunction* find_figure_function(std::string_view name);

bool is_digit(char c);
bool is_space(char c);
/// Non-ASCII bytes belong to names.
bool is_name_byte(char c);

/// Reads the parts of a requirement that are figures. Positions are bytes of the whole text.
class FigureScanner {
 public:
  FigureScanner(const std::string& text, const RunNames& runs);

 protected:
  [[noreturn]] static void fail(std::size_t offset, const std::string& message);

  void skip_space();
  bool starts_with(std::string_view prefix) const { return text_.compare(position_, prefix.size(), prefix) == 0; }
  std::string describe_rest() const;

  /// Reads the arguments of a call up to its closing parenthesis. @param parenthesis position of the opening one
  FigureReference read_call(const FigureFunction& function, std::size_t parenthesis);
  /// `torque[A1]`, `shaking_force[x]`, `joint_force[B].x`, `shaking_moment about ground.P`; anything may be in the
  /// brackets.
  std::string read_quantity(const char* figure);
  /// The text between two equal quotation marks.
  std::string take_quoted();
  void check_run(const std::string& name, std::size_t offset) const;
  /// Length of the digits, point and exponent at the current position.
  std::size_t number_length() const;

  const std::string& text_;
  const RunNames& runs_;
  std::vector<std::string> names_;  ///< of the runs, and `base`
  std::size_t position_ = 0;

 private:
  /// A name or an expression between commas.
  struct Argument {
    std::size_t begin = 0, end = 0;
    std::string text;
    bool is_quoted = false;
  };
  Argument take_argument();
  std::string read_run();
  void read_value_arguments(const FigureFunction& function, FigureReference& figure);
  FigureMoment read_moment(const Argument& argument);
  FigureMoment read_crossing(const Argument& argument, std::size_t equals);
  double read_constant(const std::string& text, std::size_t offset, const std::string& expectation) const;
  std::string read_path();
  bool is_run(const std::string& name) const;
  std::string resolve(const std::string& name) const;
};

}  // namespace balance::comparison
