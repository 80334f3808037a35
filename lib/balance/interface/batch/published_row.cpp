#include "balance/interface/batch/published_row.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace balance::batch {

using specification::Presence;
using specification::SpecCursor;

const char* name_of(PublishedVerdict verdict) { return published_verdict_names[static_cast<std::size_t>(verdict)]; }

std::string describe_outcome(const PublishedOutcome& outcome) {
  const PublishedRow& row = outcome.row;
  const std::string unit = row.unit.empty() ? "" : " " + row.unit;
  // as many digits as show whether it is within the tolerance
  constexpr int min_digits = 6, max_digits = 15;
  int digits = min_digits;
  for (double last = 1e-5 * std::abs(row.exact); digits < max_digits && last > row.tolerance / 2; last /= 10) ++digits;
  const std::string ours = fmt::format("{:.{}g}", outcome.ours, digits), exact = fmt::format("{:.12g}", row.exact);
  return fmt::format("{}{}{}, expected {} ± {:.3g}{}", outcome.holds ? "holds: " : "", ours, unit, exact, row.tolerance,
                     unit);
}

namespace {

/// Equal to the printed digits up to the round-off of decimal numbers.
constexpr double digit_round_off = 1e-9;

double read_decimal(const SpecCursor& at, std::string& text) {
  const std::string expectation = "a number as printed, such as 6.833 or 1.2e3";
  text = at.read_word(expectation);
  double value = 0;
  const std::size_t begin = text.starts_with("+") ? 1 : 0;
  const auto [end, error] = std::from_chars(text.data() + begin, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) at.fail_expected(expectation);
  return value;
}

/// Reads a text in the language of requirements.
template <class Parser>
auto read_parsed(const SpecCursor& at, const comparison::RunNames& names, const std::string& expectation,
                 const Parser& parse) {
  const std::string& text = at.read_word(expectation);
  try {
    return parse(text, names);
  } catch (const comparison::RequirementError& error) {
    at.fail({.message = error.what(), .expected = expectation, .found = quote_for_message(text), .hint = error.what()});
  }
}

/// Fails where the verdict contradicts the numbers.
void check_verdict(const SpecCursor& at, const PublishedRow& row, bool has_exact, double half_printed_digit,
                   bool has_proof) {
  using enum PublishedVerdict;
  const double difference = std::abs(row.printed - row.exact);
  const bool agrees = difference <= half_printed_digit * (1 + digit_round_off) + digit_round_off * std::abs(row.exact);
  if (row.verdict == reproduced && has_exact && !agrees)
    at.fail(
        {.message = fmt::format("the verdict is reproduced, but the printed number {} differs from the exact one, {}, "
                                "by more than half of its last digit, {:.3g}",
                                row.printed, row.exact, half_printed_digit),
         .expected = "another verdict, or numbers that agree",
         .found = "reproduced"});
  if (row.verdict != reproduced && row.verdict != improved && difference == 0)
    at.fail({.message = fmt::format("the verdict is {}, but the exact number is the printed one: give 'exact', or say "
                                    "reproduced",
                                    name_of(row.verdict)),
             .expected = "reproduced, or another 'exact'",
             .found = name_of(row.verdict)});
  if ((row.verdict == misprint || row.verdict == source_wrong) && has_exact && agrees && difference > 0)
    at.fail(
        {.message = fmt::format("the verdict is {}, but the printed number {} agrees with the exact one, {}, within "
                                "half of its last digit: say reproduced",
                                name_of(row.verdict), row.printed, row.exact),
         .expected = "reproduced, or numbers that differ",
         .found = name_of(row.verdict)});
  if (row.verdict != improved && row.proof)
    at.fail({.message = fmt::format("the verdict is {}, and 'proof' is for improved", name_of(row.verdict)),
             .expected = "improved, or no proof",
             .found = name_of(row.verdict)});
  if (row.verdict == improved && !row.proof && !has_proof)
    at.fail({.message = "the verdict is improved, which needs a proof: a requirement of the case on verdict(), or "
                        "'proof: verdict() == proved-best' here; without proof it is best-known",
             .expected = "a proof, or best-known",
             .found = "improved"});
}

}  // namespace

comparison::FigureExpression read_figure(const SpecCursor& at, const comparison::RunNames& names,
                                         const std::string& expectation) {
  comparison::FigureExpression figure = read_parsed(at, names, expectation, comparison::parse_figure_expression);
  if (figure.figures.empty()) at.fail_expected(expectation);
  return figure;
}

comparison::Requirement read_requirement(const SpecCursor& at, const comparison::RunNames& names,
                                         const std::string& expectation) {
  return read_parsed(at, names, expectation, comparison::parse_requirement);
}

SourceLocation locate(const SpecCursor& at, const std::string& file) {
  return {file, at.node().place.line, at.node().place.column, at.path()};
}

double half_last_digit(const std::string& text) {
  const std::size_t exponent_mark = std::min(text.find_first_of("eE"), text.size());
  const std::size_t point = text.find('.');
  const int decimals = point < exponent_mark ? static_cast<int>(exponent_mark - point - 1) : 0;
  int exponent = 0;
  if (exponent_mark < text.size()) {
    const std::size_t begin = exponent_mark + (text[exponent_mark + 1] == '+' ? 2 : 1);
    std::from_chars(text.data() + begin, text.data() + text.size(), exponent);
  }
  // read as a decimal number, so that it is the nearest one
  const std::string half = fmt::format("5e{}", exponent - decimals - 1);
  double value = 0;
  std::from_chars(half.data(), half.data() + half.size(), value);
  return value;
}

PublishedRow read_published_row(const SpecCursor& at, const comparison::RunNames& names, bool has_proof,
                                const std::string& file) {
  PublishedRow row;
  std::string printed_text, exact_text, ignored;
  std::optional<double> tolerance;
  std::optional<SpecCursor> verdict;
  const bool is_complete = specification::read_fields(
      at, "a published number {what, unit, printed, exact, tolerance, figure, verdict, note, proof}",
      {{"what", Presence::required, [&](const SpecCursor& c) { row.what = c.read_word("what the number is"); }},
       {"unit", Presence::optional,
        [&](const SpecCursor& c) {
          row.unit = c.read_word("a unit");
          row.unit_value = read_unit_product(c);
          row.unit_location = locate(c, file);
        }},
       {"printed", Presence::required, [&](const SpecCursor& c) { row.printed = read_decimal(c, printed_text); }},
       {"exact", Presence::optional, [&](const SpecCursor& c) { row.exact = read_decimal(c, exact_text); }},
       {"tolerance", Presence::optional,
        [&](const SpecCursor& c) {
          tolerance = read_decimal(c, ignored);
          if (*tolerance < 0) c.fail_expected("a tolerance, which is not negative");
        }},
       {"figure", Presence::required,
        [&](const SpecCursor& c) {
          row.figure = read_figure(
              c, names, "arithmetic of figures such as '-value(joint_velocity[X], joint_position[A] = pi/3)'");
          row.figure_location = locate(c, file);
        }},
       {"verdict", Presence::required,
        [&](const SpecCursor& c) {
          const std::vector<std::string> verdicts(published_verdict_names.begin(), published_verdict_names.end());
          row.verdict = static_cast<PublishedVerdict>(c.read_choice("a verdict", verdicts));
          verdict = c;
        }},
       {"note", Presence::optional, [&](const SpecCursor& c) { row.note = c.read_word("a sentence"); }},
       {"proof", Presence::optional, [&](const SpecCursor& c) {
          const char* expectation = "a requirement such as 'verdict() == proved-best'";
          row.proof = {read_requirement(c, names, expectation), locate(c, file)};
          if (list_figures(row.proof->requirement).empty()) c.fail_expected(expectation);
        }}});
  if (!is_complete) throw specification::CascadingError();
  const bool has_exact = !exact_text.empty();
  if (!has_exact) row.exact = row.printed;
  row.tolerance = tolerance ? *tolerance : half_last_digit(has_exact ? exact_text : printed_text);
  check_verdict(*verdict, row, has_exact, half_last_digit(printed_text), has_proof);
  return row;
}

WaitingRow read_waiting_row(const SpecCursor& at) {
  WaitingRow row;
  const auto text_of = [](std::string& text, const char* what) {
    return [&text, what](const SpecCursor& c) { text = c.read_word(what); };
  };
  if (!specification::read_fields(at, "a number without a figure {what, unit, printed, reason}",
                                  {{"what", Presence::required, text_of(row.what, "what the number is")},
                                   {"unit", Presence::optional, text_of(row.unit, "a unit")},
                                   {"printed", Presence::optional, text_of(row.printed, "the printed number")},
                                   {"reason", Presence::required, text_of(row.reason, "what is missing")}}))
    throw specification::CascadingError();
  return row;
}

}  // namespace balance::batch
