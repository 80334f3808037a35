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
MatrixX parameter_slopes(const DesignSpace& space, const VectorX& x, const LooseSprings& loose) {
  constexpr double step = 1e-5;  // of a number's range
  const auto at = [&](const VectorX& there) { return parameter_values(space.trial(there).mechanism, loose); };
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

Slope size_of(const DesignSpace& space, const Mechanism& mechanism, const ObjectiveTerm& term,
              const LooseSprings& loose, const VectorX& x) {
  const VectorX coefficients = size_coefficients(term.size, mechanism, loose);
  return {coefficients.dot(parameter_values(mechanism, loose)),
          parameter_slopes(space, x, loose).transpose() * coefficients};
}

MaximumTerm single(double weight, const Slope& slope) {
  return {weight, VectorX::Constant(1, slope.value), slope.by_number.transpose()};
}

/// The largest of the slopes and of the negative ones.
MaximumTerm largest(double weight, const std::vector<Slope>& up, const std::vector<Slope>& down, Eigen::Index numbers) {
  const auto above = static_cast<Eigen::Index>(up.size()), below = static_cast<Eigen::Index>(down.size());
  MaximumTerm term{weight, VectorX(above + below), MatrixX(above + below, numbers)};
  for (Eigen::Index k = 0; k < above + below; ++k) {
    const double sign = k < above ? 1 : -1;
    const Slope& slope = k < above ? up[static_cast<std::size_t>(k)] : down[static_cast<std::size_t>(k - above)];
    term.values[k] = sign * slope.value;
    term.slopes.row(k) = sign * slope.by_number.transpose();
  }
  return term;
}

void add_figure(const ObjectiveTerm& term, const FigureSlopes& slopes, Eigen::Index numbers,
                std::vector<MaximumTerm>& pieces) {
  const double weight = term.weight;
  if (term.run == ObjectiveTerm::Run::duration) return pieces.push_back(single(weight, slopes.duration));
  const QuantitySlopes* found = find_quantity(slopes, term.quantity);
  if (found == nullptr)
    throw std::invalid_argument("a run along '" + term.trajectory + "' has no quantity '" + term.quantity + "'");
  switch (term.figure) {
    case Figure::rms: return pieces.push_back(single(weight, found->rms));
    case Figure::mean: return pieces.push_back(single(weight, found->mean));
    case Figure::peak: return pieces.push_back(largest(weight, found->highest, found->lowest, numbers));
    case Figure::range:
      pieces.push_back(largest(weight, found->highest, {}, numbers));
      pieces.push_back(largest(weight, {}, found->lowest, numbers));
  }
}

bool is_found_anew(const DesignSpace& space, const ObjectiveTerm& term) {
  using Run = ObjectiveTerm::Run;
  if ((term.run != Run::figure && term.run != Run::duration) || binds_rates(space.start.mechanism)) return true;
  const auto& all = space.start.trajectories;
  return std::any_of(all.begin(), all.end(), [&](const Trajectory& trajectory) {
    return trajectory.name == term.trajectory && depends_on_mechanism(trajectory);
  });
}

/// Along a law or a course that is found for every mechanism, good to some 1e-7 of the figure: steps of a thousandth of a number's range leave
/// some 1e-4 of that range's slope.
Slope differences(const DesignSpace& space, const ObjectiveTerm& term, const VectorX& x) {
  constexpr double step = 1e-3;
  Slope slope{by_simulation(finite_trial(space, x), term), VectorX(x.size())};
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(i)];
    const double reach = step * (free.upper - free.lower);
    VectorX up = x, down = x;
    up[i] = std::min(x[i] + reach, free.upper), down[i] = std::max(x[i] - reach, free.lower);
    const double high = by_simulation(finite_trial(space, up), term);
    const double low = by_simulation(finite_trial(space, down), term);
    // where only one side has a value the other serves
    slope.by_number[i] = std::isfinite(high - low) ? (high - low) / (up[i] - down[i])
                         : std::isfinite(high)     ? (high - slope.value) / (up[i] - x[i])
                                                   : (slope.value - low) / (x[i] - down[i]);
  }
  return slope;
}

}  // namespace

std::optional<std::vector<MaximumTerm>> objective_pieces(const DesignSpace& space,
                                                         const std::vector<ObjectiveTerm>& terms,
                                                         const LooseSprings& loose, const VectorX& x) {
  const Trial trial = finite_trial(space, x);
  std::map<std::string, std::vector<std::string>> quantities;
  for (const ObjectiveTerm& term : terms) {
    if (term.size != ObjectiveTerm::Size::none || is_found_anew(space, term)) continue;
    std::vector<std::string>& names = quantities[term.trajectory];
    if (term.run == ObjectiveTerm::Run::figure) names.push_back(term.quantity);
  }
  std::map<std::string, FigureSlopes> runs;
  for (auto& [trajectory, names] : quantities) {
    if (names.empty()) names.emplace_back("torque");
    const FigureSlopes& run = runs[trajectory] = figure_slopes(space, x, trajectory, names);
    if (run.outcome.status != MotionStatus::done) return std::nullopt;
  }
  std::vector<MaximumTerm> pieces;
  for (const ObjectiveTerm& term : terms)
    if (term.size != ObjectiveTerm::Size::none)
      pieces.push_back(single(term.weight, size_of(space, trial.mechanism, term, loose, x)));
    else if (is_found_anew(space, term))
      pieces.push_back(single(term.weight, differences(space, term, x)));
    else
      add_figure(term, runs[term.trajectory], x.size(), pieces);
  return pieces;
}

}  // namespace balance
