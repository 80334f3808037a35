// The equation of motion in speeds, and what constraints on them do.

#include "balance/present/equation_tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace balance {

namespace {

std::string sections_text(const EquationsReportData& view, const IndependentTerms& terms,
                          const std::vector<std::string>& rows) {
  using enum EquationSection;
  const EquationsAtConfiguration& at = view.at;
  std::string text;
  if (view.shows(inertia)) text += "M'\n" + matrix_text(terms.mass, rows, at.speeds);
  if (view.shows(velocity)) {
    text += "velocity terms\n" + velocity_table(terms, rows, at.speeds);
    if (!terms.viscous.isZero(0)) text += "B', of viscous friction\n" + matrix_text(terms.viscous, rows, at.speeds);
  }
  if (view.shows(gravity)) {
    MatrixX rest(terms.static_terms.weight.size(), 4);
    rest << terms.static_terms.weight, terms.static_terms.springs, terms.static_terms.loads, terms.static_terms.sum();
    text += "z'\n" + matrix_text(rest, rows, {"weight", "springs", "loads", "z'"});
  }
  if (view.shows(torques) && terms.input.cols() > 0)
    text += "what efforts do: generalised force per effort\n" + matrix_text(terms.input, rows, at.actuators);
  return text;
}

}  // namespace

std::string speeds_text(const EquationsReportData& view) {
  const EquationsAtConfiguration& at = view.at;
  const SpeedTerms& in = *at.in_speeds;
  std::string text = fmt::format("in the speeds {}", fmt::join(at.speeds, ", "));
  if (!at.zero.empty()) text += fmt::format("; zero: {}", fmt::join(at.zero, ", "));
  text += " (P0 eq. 1)\nfreedoms: ";
  if (!at.has_rate_constraints) text += fmt::format("{} of configuration, ", at.independent.size());
  text += fmt::format("{} of velocity\n", at.speeds.size());
  text += "rates of the coordinates per speed\n" + matrix_text(in.rates, at.independent, at.speeds);
  text += sections_text(view, in.speed_equations, at.speeds);
  if (!at.zero.empty())
    text += "\nforces of the constraints, efforts apart\n" + sections_text(view, in.constraint_equations, at.zero);
  return text + "\n";
}

}  // namespace balance
