#include "balance/analysis/objective_pieces.hpp"

#include "balance/analysis/figure_gradient.hpp"
#include "balance/analysis/finite_trial.hpp"
#include "balance/analysis/objective.hpp"
#include "balance/analysis/run_figure.hpp"
#include "balance/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace balance {

namespace {

/// What parameters change by with every number, one column each: they are smooth, and cheap.
MatrixX parameter_jacobian(const DesignSpace& space, const VectorX& x, const FreeSprings& loose) {
  constexpr double step = 1e-5;  // of a number's range
  const auto at = [&](const VectorX& there) { return parameter_values(space.instantiate(there).mechanism, loose); };
  MatrixX slopes(at(x).size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(i)];
    const double reach = step * (free.upper - free.lower);
    VectorX up = x, down = x;
    up[i] = std::min(x[i] + reach, free.upper), down[i] = std::max(x[i] - reach, free.lower);
    if (up[i] == down[i])
      slopes.col(i).setZero();
    else
      slopes.col(i) = (at(up) - at(down)) / (up[i] - down[i]);
  }
  return slopes;
}

ValueWithGradient size_with_gradient(const DesignSpace& space, const Mechanism& mechanism, const ObjectiveTerm& term,
                                     const FreeSprings& loose, const VectorX& x) {
  const VectorX coefficients = size_coefficients(term.size, mechanism, loose);
  return {coefficients.dot(parameter_values(mechanism, loose)),
          parameter_jacobian(space, x, loose).transpose() * coefficients};
}

MaxTerm make_single_term(double weight, const ValueWithGradient& slope) {
  return {weight, VectorX::Constant(1, slope.value), slope.gradient.transpose()};
}

/// The largest of the slopes and of the negative ones.
MaxTerm make_max_term(double weight, const std::vector<ValueWithGradient>& up,
                      const std::vector<ValueWithGradient>& down, Eigen::Index numbers) {
  const auto above = static_cast<Eigen::Index>(up.size()), below = static_cast<Eigen::Index>(down.size());
  MaxTerm term{weight, VectorX(above + below), MatrixX(above + below, numbers)};
  for (Eigen::Index k = 0; k < above + below; ++k) {
    const double sign = k < above ? 1 : -1;
    const ValueWithGradient& slope =
        k < above ? up[static_cast<std::size_t>(k)] : down[static_cast<std::size_t>(k - above)];
    term.values[k] = sign * slope.value;
    term.jacobian.row(k) = sign * slope.gradient.transpose();
  }
  return term;
}

void add_figure(const ObjectiveTerm& term, const SpecFigureGradients& slopes, Eigen::Index numbers,
                std::vector<MaxTerm>& pieces) {
  const double weight = term.weight;
  if (term.run == ObjectiveTerm::RunMeasure::duration)
    return pieces.push_back(make_single_term(weight, slopes.duration));
  const QuantityGradients* found = find_quantity(slopes, term.quantity);
  if (found == nullptr)
    throw std::invalid_argument("a run along '" + term.trajectory + "' has no quantity '" + term.quantity + "'");
  switch (term.figure) {
    case Statistic::rms: return pieces.push_back(make_single_term(weight, found->rms));
    case Statistic::mean: return pieces.push_back(make_single_term(weight, found->mean));
    case Statistic::peak:
      return pieces.push_back(make_max_term(weight, found->segment_maxima, found->segment_minima, numbers));
    case Statistic::range:
      pieces.push_back(make_max_term(weight, found->segment_maxima, {}, numbers));
      pieces.push_back(make_max_term(weight, {}, found->segment_minima, numbers));
  }
}

bool has_optimised_motion(const DesignSpace& space, const ObjectiveTerm& term) {
  using Run = ObjectiveTerm::RunMeasure;
  if ((term.run != Run::figure && term.run != Run::duration) || has_velocity_constraints(space.start.mechanism))
    return true;
  const auto& all = space.start.trajectories;
  return std::any_of(all.begin(), all.end(), [&](const Trajectory& trajectory) {
    return trajectory.name == term.trajectory && is_mechanism_dependent(trajectory);
  });
}

/// Along a law or a course that is found for every mechanism, good to some 1e-7 of the figure: steps of a thousandth of a number's range leave
/// some 1e-4 of that range's slope.
ValueWithGradient gradient_by_differences(const DesignSpace& space, const ObjectiveTerm& term, const VectorX& x) {
  constexpr double step = 1e-3;
  ValueWithGradient slope{simulate_figure(instantiate_checked(space, x), term), VectorX(x.size())};
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(i)];
    const double reach = step * (free.upper - free.lower);
    VectorX up = x, down = x;
    up[i] = std::min(x[i] + reach, free.upper), down[i] = std::max(x[i] - reach, free.lower);
    const double high = simulate_figure(instantiate_checked(space, up), term);
    const double low = simulate_figure(instantiate_checked(space, down), term);
    // where only one side has a value the other serves
    slope.gradient[i] = std::isfinite(high - low) ? (high - low) / (up[i] - down[i])
                        : std::isfinite(high)     ? (high - slope.value) / (up[i] - x[i])
                                                  : (slope.value - low) / (x[i] - down[i]);
  }
  return slope;
}

}  // namespace

std::optional<std::vector<MaxTerm>> compute_max_terms(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                                      const FreeSprings& loose, const VectorX& x) {
  const DesignInstance trial = instantiate_checked(space, x);
  std::map<std::string, std::vector<std::string>> quantities;
  for (const ObjectiveTerm& term : terms) {
    if (term.size != ObjectiveTerm::Size::none || has_optimised_motion(space, term)) continue;
    std::vector<std::string>& names = quantities[term.trajectory];
    if (term.run == ObjectiveTerm::RunMeasure::figure) names.push_back(term.quantity);
  }
  std::map<std::string, SpecFigureGradients> runs;
  for (auto& [trajectory, names] : quantities) {
    if (names.empty()) names.emplace_back("torque");
    const SpecFigureGradients& run = runs[trajectory] = compute_figure_gradients(space, x, trajectory, names);
    if (run.outcome.status != MotionStatus::done) return std::nullopt;
  }
  std::vector<MaxTerm> pieces;
  for (const ObjectiveTerm& term : terms)
    if (term.size != ObjectiveTerm::Size::none)
      pieces.push_back(make_single_term(term.weight, size_with_gradient(space, trial.mechanism, term, loose, x)));
    else if (has_optimised_motion(space, term))
      pieces.push_back(make_single_term(term.weight, gradient_by_differences(space, term, x)));
    else
      add_figure(term, runs[term.trajectory], x.size(), pieces);
  return pieces;
}

}  // namespace balance
