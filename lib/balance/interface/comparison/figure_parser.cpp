#include "balance/interface/comparison/figure_parser.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/expression/expression_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

namespace balance::comparison {

std::string FigureMoment::text() const {
  switch (kind) {
    case Kind::none: return "";
    case Kind::time: return fmt::format("{}", time);
    case Kind::start: return "start";
    case Kind::end: return "end";
    case Kind::crossing:
      return fmt::format("{} = {}{}", quantity, level, crossing == 1 ? "" : fmt::format(" #{}", crossing));
    case Kind::peak: return fmt::format("peak({})", quantity);
    case Kind::minimum: return fmt::format("minimum({})", quantity);
    case Kind::maximum: return fmt::format("maximum({})", quantity);
  }
  return "";
}

std::string FigureReference::text() const {
  std::string arguments =
      function->arguments == FigureArguments::order_and_quantity ? fmt::format("{:g}, {}", order, quantity) : quantity;
  const auto append = [&](const std::string& argument) {
    if (!argument.empty()) arguments += (arguments.empty() ? "" : ", ") + argument;
  };
  append(moment.text());
  append(side == JumpSide::before ? "before" : side == JumpSide::after ? "after" : "");
  return fmt::format("{}({})", function->name, arguments);
}

namespace {

constexpr int max_crossing = 1'000'000;
constexpr const char* moment_kinds =
    "a time in s, start, end, a condition such as joint_position[A] = pi/3, or peak, minimum or maximum of a quantity";

std::string trimmed(const std::string& text) { return std::string(trim(text)); }

}  // namespace

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }
bool is_name_byte(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || (c & 0x80) != 0; }

const FigureFunction* find_figure_function(std::string_view name) {
  for (const FigureFunction& function : figure_functions())
    if (name == function.name) return &function;
  return nullptr;
}

FigureScanner::FigureScanner(const std::string& text, const RunNames& runs)
    : text_(text), runs_(runs), names_(runs.all) {
  if (!runs.base.empty()) names_.emplace_back("base");
}

void FigureScanner::fail(std::size_t offset, const std::string& message) {
  throw RequirementError(offset + 1, message);
}

void FigureScanner::skip_space() {
  while (position_ < text_.size() && is_space(text_[position_])) ++position_;
}

std::string FigureScanner::describe_rest() const {
  return position_ == text_.size() ? "the end" : quote_for_message(text_.substr(position_));
}

std::string FigureScanner::take_quoted() {
  const std::size_t close = text_.find(text_[position_], position_ + 1);
  if (close == std::string::npos) fail(position_, "the quote is not closed");
  std::string content = text_.substr(position_ + 1, close - position_ - 1);
  position_ = close + 1;
  return content;
}

std::size_t FigureScanner::number_length() const {
  std::size_t end = position_;
  const auto digits = [&](std::size_t from) {
    while (from < text_.size() && is_digit(text_[from])) ++from;
    return from;
  };
  end = digits(end);
  if (end < text_.size() && text_[end] == '.') end = digits(end + 1);
  if (end == position_ || (end == position_ + 1 && text_[position_] == '.')) return 0;
  if (end < text_.size() && (text_[end] == 'e' || text_[end] == 'E')) {
    const bool sign = end + 1 < text_.size() && (text_[end + 1] == '+' || text_[end + 1] == '-');
    const std::size_t exponent = end + (sign ? 2 : 1);
    if (digits(exponent) > exponent) end = digits(exponent);
  }
  return end - position_;
}

bool FigureScanner::is_run(const std::string& name) const {
  return std::find(names_.begin(), names_.end(), name) != names_.end();
}

std::string FigureScanner::resolve(const std::string& name) const {
  return name == "base" && !runs_.base.empty() ? runs_.base : name;
}

void FigureScanner::check_run(const std::string& name, std::size_t offset) const {
  if (is_run(name)) return;
  if (names_.empty())
    fail(offset, fmt::format("{} is neither a number nor a figure: there are no other runs", quote_for_message(name)));
  fail(offset, fmt::format("no run is called {}: {}{}", quote_for_message(name), join_alternatives(names_),
                           append_nearest_name(name, names_)));
}

std::string FigureScanner::read_quantity(const char* figure) {
  const std::size_t begin = position_;
  const auto skip_name = [&] {
    while (position_ < text_.size() && (is_name_byte(text_[position_]) || text_[position_] == '.')) ++position_;
  };
  skip_name();
  if (position_ == begin)
    fail(begin, fmt::format("expected a quantity such as shaking_force or torque[A1] for {}, found {}", figure,
                            describe_rest()));
  while (position_ < text_.size() && text_[position_] == '[') {
    const std::size_t close = text_.find(']', position_);
    if (close == std::string::npos) fail(position_, "the bracket is not closed");
    position_ = close + 1;
    if (starts_with(".")) skip_name();
  }
  const std::size_t end = position_;
  skip_space();
  if (starts_with("about ") && position_ > end) {  // a moment about another point
    position_ += std::string_view("about ").size();
    skip_space();
    const std::size_t point = position_;
    skip_name();
    const std::string landmark(text_, point, position_ - point);
    return text_.substr(begin, end - begin) + " about " + landmark;
  }
  position_ = end;
  return text_.substr(begin, end - begin);
}

/// The text up to the comma or parenthesis that ends it. Names of runs may contain both.
FigureScanner::Argument FigureScanner::take_argument() {
  skip_space();
  Argument argument{position_, position_, "", false};
  if (starts_with("'") || starts_with("\"")) {
    argument.text = take_quoted();
    argument.is_quoted = true;
    argument.end = position_;
    return argument;
  }
  for (const std::string& name : names_) {
    const std::size_t after = text_.find_first_not_of(" \t\r\n", position_ + name.size());
    if (starts_with(name) && position_ + name.size() > argument.end && after != std::string::npos &&
        (text_[after] == ',' || text_[after] == ')'))
      argument.end = position_ + name.size();
  }
  if (argument.end == position_) {
    int depth = 0;
    for (; argument.end < text_.size(); ++argument.end) {
      const char c = text_[argument.end];
      if (c == '[') argument.end = std::min(text_.find(']', argument.end), text_.size() - 1);
      if (c == '(') ++depth;
      if (c == ')' && depth-- == 0) break;
      if (c == ',' && depth == 0) break;
    }
  }
  argument.text = trimmed(text_.substr(position_, argument.end - position_));
  position_ = argument.end;
  return argument;
}

/// The name of a run.
std::string FigureScanner::read_run() {
  const std::size_t begin = position_;
  if (starts_with("'") || starts_with("\"")) {
    const std::string name = take_quoted();
    check_run(name, begin);
    return resolve(name);
  }
  std::size_t end = std::min(text_.find(')', position_), text_.size());
  // Names may contain parentheses themselves.
  for (const std::string& name : names_) {
    if (starts_with(name) && position_ + name.size() > end) end = position_ + name.size();
  }
  while (end > begin && is_space(text_[end - 1])) --end;
  const std::string name = text_.substr(begin, end - begin);
  if (name.empty()) fail(begin, "expected the name of a run, found " + describe_rest());
  check_run(name, begin);
  position_ = end;
  return resolve(name);
}

double FigureScanner::read_constant(const std::string& text, std::size_t offset, const std::string& expectation) const {
  const auto no_name = [&](const std::string& name) -> Expression {
    throw expression::ExpressionError("unknown name " + quote_for_message(name));
  };
  try {
    const double value = expression::parse_expression(text, no_name).value();
    if (std::isfinite(value)) return value;
  } catch (const expression::ExpressionError& error) {
    fail(offset, fmt::format("expected {}, found {}: {}", expectation, quote_for_message(trimmed(text)), error.what()));
  }
  fail(offset,
       fmt::format("expected {}, found {}, which is not finite", expectation, quote_for_message(trimmed(text))));
}

/// `Q = 1.2 #2`. @param equals position of the sign
FigureMoment FigureScanner::read_crossing(const Argument& argument, std::size_t equals) {
  FigureMoment moment{.kind = FigureMoment::Kind::crossing};
  position_ = argument.begin;
  moment.column = position_ + 1;
  moment.quantity = read_quantity("a condition");
  skip_space();
  if (position_ != equals) fail(position_, "expected a quantity and '=' in a condition, found " + describe_rest());
  if (text_.compare(equals, 2, "==") == 0) fail(equals, "a condition has a single '='");
  std::size_t end = argument.end;
  const std::size_t number_sign = text_.find('#', equals);
  if (number_sign < end) {
    const std::string digits = trimmed(text_.substr(number_sign + 1, end - number_sign - 1));
    const auto [rest, error] = std::from_chars(digits.data(), digits.data() + digits.size(), moment.crossing);
    if (error != std::errc() || rest != digits.data() + digits.size() || moment.crossing < 1 ||
        moment.crossing > max_crossing)
      fail(number_sign, fmt::format("expected the number of a crossing from 1, such as #2, found {}",
                                    quote_for_message(text_.substr(number_sign, end - number_sign))));
    end = number_sign;
  }
  moment.level_text = trimmed(text_.substr(equals + 1, end - equals - 1));
  moment.level = read_constant(moment.level_text, equals + 1, "a number after '='");
  return moment;
}

FigureMoment FigureScanner::read_moment(const Argument& argument) {
  using Kind = FigureMoment::Kind;
  if (argument.text == "start") return {.kind = Kind::start};
  if (argument.text == "end") return {.kind = Kind::end};
  for (const auto& [name, kind] :
       {std::pair{"peak", Kind::peak}, {"minimum", Kind::minimum}, {"maximum", Kind::maximum}}) {
    position_ = argument.begin;
    if (!starts_with(name)) continue;
    position_ += std::string_view(name).size();
    skip_space();
    if (!starts_with("(")) continue;
    ++position_;
    skip_space();
    FigureMoment moment{.kind = kind};
    moment.column = position_ + 1;
    moment.quantity = read_quantity(name);
    skip_space();
    if (!starts_with(")"))
      fail(position_, fmt::format("expected ')' after the quantity of {}, found {}", name, describe_rest()));
    ++position_;
    skip_space();
    if (position_ < argument.end) fail(position_, "expected ',' or ')', found " + describe_rest());
    return moment;
  }
  for (std::size_t i = argument.begin; i < argument.end; ++i) {
    if (text_[i] == '[') i = std::min(text_.find(']', i), argument.end);
    if (i < argument.end && text_[i] == '=') return read_crossing(argument, i);
  }
  FigureMoment moment{.kind = Kind::time};
  const std::string expectation =
      names_.empty() ? std::string(moment_kinds)
                     : fmt::format("{}, or the name of a run ({})", moment_kinds, join_alternatives(names_));
  moment.time = read_constant(argument.text, argument.begin, expectation);
  return moment;
}

/// `, WHEN, before, run` in any sensible order.
void FigureScanner::read_value_arguments(const FigureFunction& function, FigureReference& figure) {
  for (skip_space(); starts_with(",") || (figure.moment.kind == FigureMoment::Kind::none && figure.quantity.empty());
       skip_space()) {
    if (starts_with(",")) ++position_;
    const Argument argument = take_argument();
    if (argument.text.empty())
      fail(argument.begin, fmt::format("expected {} for {}, found {}", moment_kinds, function.name, describe_rest()));
    const bool is_word = argument.text == "start" || argument.text == "end";
    const bool has_moment = figure.moment.kind != FigureMoment::Kind::none;
    const bool is_side = !argument.is_quoted && (argument.text == "before" || argument.text == "after") && has_moment;
    bool is_number = !argument.is_quoted;
    if (is_number) {
      const std::size_t end = position_;
      position_ = argument.begin;
      is_number = number_length() == argument.text.size();
      position_ = end;
    }
    if (is_side && figure.side == JumpSide::any) {
      figure.side = argument.text == "before" ? JumpSide::before : JumpSide::after;
    } else if (argument.is_quoted || (is_run(argument.text) && !(is_word && !has_moment) && !is_number)) {
      if (!figure.run.empty()) fail(argument.begin, fmt::format("{} has two runs", function.name));
      check_run(argument.text, argument.begin);
      figure.run = resolve(argument.text);
    } else if (!has_moment) {
      figure.moment = read_moment(argument);
      position_ = argument.end;
    } else {
      check_run(argument.text, argument.begin);
      fail(argument.begin, fmt::format("expected ')' after the arguments of {}, found {}", function.name,
                                       quote_for_message(argument.text)));
    }
  }
}

/// A path such as counterweights.cw.mass, or a name.
std::string FigureScanner::read_path() {
  const Argument argument = take_argument();
  if (argument.text.empty())
    fail(argument.begin,
         "expected the path of a number such as counterweights.cw.mass for number, found " + describe_rest());
  return argument.text;
}

FigureReference FigureScanner::read_call(const FigureFunction& function, std::size_t parenthesis) {
  FigureReference figure;
  figure.function = &function;
  figure.column = position_ + 1;
  position_ = parenthesis + 1;
  skip_space();
  const auto read_last_run = [&] {
    skip_space();
    if (!starts_with(",")) return;
    ++position_;
    skip_space();
    figure.run = read_run();
  };
  switch (function.arguments) {
    case FigureArguments::none:
      if (!starts_with(")")) figure.run = read_run();
      break;
    case FigureArguments::quantity:
      figure.column = position_ + 1;
      figure.quantity = read_quantity(function.name);
      read_last_run();
      break;
    case FigureArguments::order_and_quantity: {
      const Argument order = take_argument();
      figure.order = read_constant(order.text, order.begin, "an order, such as 2 or 1/2,");
      skip_space();
      if (!(figure.order > 0) || !starts_with(","))
        fail(order.begin, fmt::format("expected an order and a quantity, such as {}(2, shaking_force), found {}",
                                      function.name, quote_for_message(order.text)));
      ++position_;
      skip_space();
      figure.column = position_ + 1;
      figure.quantity = read_quantity(function.name);
      read_last_run();
      break;
    }
    case FigureArguments::quantity_and_moment:
      figure.column = position_ + 1;
      figure.quantity = read_quantity(function.name);
      read_value_arguments(function, figure);
      break;
    case FigureArguments::moment: read_value_arguments(function, figure); break;
    case FigureArguments::path:
      figure.column = position_ + 1;
      figure.quantity = read_path();
      read_last_run();
      break;
  }
  skip_space();
  if (position_ == text_.size()) fail(parenthesis, "the parenthesis is not closed");
  if (!starts_with(")"))
    fail(position_, fmt::format("expected ')' after the argument of {}, found {}", function.name, describe_rest()));
  ++position_;
  return figure;
}

}  // namespace balance::comparison
