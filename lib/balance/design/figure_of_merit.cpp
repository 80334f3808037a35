#include "balance/design/figure_of_merit.hpp"

#include "balance/base/computing_time.hpp"
#include "balance/base/error.hpp"
#include "balance/base/extrema.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance::designing {

namespace {

/// The caller's parameters among those that include all loose springs' products.
std::vector<int> positions(const Mechanism& mechanism, const LooseSprings& asked, const LooseSprings& all) {
  const auto wanted = list_parameters(mechanism, asked), present = list_parameters(mechanism, all);
  std::vector<int> result;
  for (const Parameter& w : wanted)
    for (std::size_t p = 0; p < present.size(); ++p)
      if (present[p].bearer == w.bearer && present[p].index == w.index && present[p].slot == w.slot)
        result.push_back(static_cast<int>(p));
  return result;
}

}  // namespace

FigureOfMerit::FigureOfMerit(const Context& context, const Objective& objective)
    : context_(context), objective_(objective) {
  if (static_cast<bool>(objective_.of_parameters) == static_cast<bool>(objective_.of_variables))
    throw std::invalid_argument("an objective is a function of the parameters or of the variables");
  parameters_ = positions(context.survey.at_base, context.problem.options.loose_springs, context.survey.loose);
  convex_ = objective_.of_parameters && objective_.convex && depends_affinely();
}

double FigureOfMerit::by_simulation(const VectorX& u) const {
  try {
    return objective_.of_variables(context_.box.numbers(u));
  } catch (const SpecError&) {
    return std::numeric_limits<double>::quiet_NaN();  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    return std::numeric_limits<double>::quiet_NaN();  // nor is there a motion
  } catch (const OutOfTime&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

std::optional<std::vector<MaximumTerm>> FigureOfMerit::pieces(const VectorX& u) const {
  if (context_.budget.over()) return std::nullopt;
  try {
    auto terms = context_.problem.pieces_at(context_.box.numbers(u));
    if (!terms) return std::nullopt;
    for (MaximumTerm& term : *terms) {
      if (!term.values.allFinite() || !term.slopes.allFinite()) return std::nullopt;
      term.slopes = term.slopes * context_.box.half().asDiagonal();
    }
    return terms;
  } catch (const SpecError&) {
    return std::nullopt;
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  } catch (const OutOfTime&) {
    return std::nullopt;
  }
}

/// By differences where slopes are not known.
VectorX FigureOfMerit::simulated_slope(const VectorX& u) const {
  if (const auto terms = has_pieces() ? pieces(u) : std::nullopt) {
    VectorX slope = VectorX::Zero(u.size());
    for (const MaximumTerm& term : *terms) {
      slope += term.weight * term.slopes.row(max_index(term.values)).transpose();
    }
    return slope;
  }
  const auto value = [this](const VectorX& v) { return VectorX::Constant(1, by_simulation(v)).eval(); };
  return central_differences(value, u, 1).transpose();
}

double FigureOfMerit::operator()(const VectorX& u, VectorX* gradient) const {
  if (simulated()) {
    if (context_.budget.over()) {
      if (gradient != nullptr) gradient->setZero(u.size());
      return std::numeric_limits<double>::quiet_NaN();
    }
    if (gradient != nullptr) *gradient = simulated_slope(u);
    return by_simulation(u);
  }
  VectorX features, slope;
  MatrixX slopes;
  context_.map.evaluate(u, features, gradient != nullptr ? &slopes : nullptr);
  if (!features.allFinite()) {
    if (gradient != nullptr) gradient->setZero(u.size());
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double value = objective_.of_parameters(features(parameters_), gradient != nullptr ? &slope : nullptr);
  if (gradient != nullptr) *gradient = slopes(parameters_, Eigen::all).transpose() * slope;
  return value;
}

std::string FigureOfMerit::trouble(const VectorX& u) const {
  try {
    const VectorX x = context_.box.numbers(u);
    if (objective_.trouble) return objective_.trouble(x);
    if (objective_.of_variables) objective_.of_variables(x);
  } catch (const SpecError& error) {
    return error.what();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

double FigureOfMerit::round_off() const {
  const Eigen::Index n = context_.box.size();
  std::vector<VectorX> places{context_.box.start()};
  if (!simulated()) places.insert(places.end(), {VectorX::Zero(n), VectorX::Ones(n), -VectorX::Ones(n)});
  double largest = 0;
  for (const VectorX& u : places)
    if (const double value = std::abs((*this)(u, nullptr)); value > largest && std::isfinite(value)) largest = value;
  return figure_round_off * largest;
}

bool FigureOfMerit::depends_affinely() const {
  const auto& polynomial = context_.map.polynomial();
  if (!polynomial) return false;
  RandomNumbers random(1);
  for (int sample = 0; sample < 3; ++sample) {
    VectorX features, slope;
    context_.map.evaluate(random.point(context_.box.size()), features, nullptr);
    if (!features.allFinite()) return false;
    objective_.of_parameters(features(parameters_), &slope);
    for (std::size_t p = 0; p < parameters_.size(); ++p)
      if (slope[static_cast<Eigen::Index>(p)] != 0 && !polynomial->affine(parameters_[p])) return false;
  }
  return true;
}

}  // namespace balance::designing
