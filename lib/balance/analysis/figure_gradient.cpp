#include "balance/analysis/figure_gradient.hpp"

#include "balance/gradients/motion_gradient.hpp"
#include "balance/result/tracks.hpp"
#include "balance/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance {

namespace {

constexpr double step = 1e-4;  // of a number's range

std::size_t index_of(const DesignSpace& space, const std::string& trajectory) {
  const auto& all = space.start.trajectories;
  const auto found = std::find_if(all.begin(), all.end(), [&](const Trajectory& t) { return t.name == trajectory; });
  if (found == all.end()) throw std::invalid_argument("the spec has no trajectory '" + trajectory + "'");
  if (depends_on_mechanism(*found))
    throw std::invalid_argument("the trajectory '" + trajectory + "' is found anew for every mechanism");
  return static_cast<std::size_t>(found - all.begin());
}

/// A figure among a quantity's, and where its derivatives stand in a FigureGradient.
struct Place {
  Slope QuantitySlopes::*slope;
  double FigureGradient::*value;
  std::array<double, dual_width> FigureGradient::*derivatives;
  double Metric::*metric;
};
constexpr Place places[] = {{&QuantitySlopes::peak, &FigureGradient::peak, &FigureGradient::d_peak, &Metric::peak},
                            {&QuantitySlopes::rms, &FigureGradient::rms, &FigureGradient::d_rms, &Metric::rms},
                            {&QuantitySlopes::mean, &FigureGradient::mean, &FigureGradient::d_mean, &Metric::mean},
                            {&QuantitySlopes::range, &FigureGradient::range, &FigureGradient::d_range, &Metric::range}};

class Differentiation {
 public:
  Differentiation(const DesignSpace& space, const VectorX& x, std::size_t trajectory)
      : space_(space), x_(x), trajectory_(trajectory), trial_(space.trial(x)) {}

  FigureSlopes run() {
    std::vector<int> of_mechanism, of_motion;
    for (int i = 0; i < x_.size(); ++i) (moves_trajectory(i) ? of_motion : of_mechanism).push_back(i);
    std::vector<int> together;
    for (const int i : of_mechanism) {
      together.push_back(i);
      if (together.size() < dual_width) continue;
      if (!by_mechanism(together)) return std::move(out_);
      together.clear();
    }
    const bool none = of_mechanism.empty();  // then one run is for the values
    if ((none || !together.empty()) && !by_mechanism(together)) return std::move(out_);
    for (const int i : of_motion) by_motion(i);
    return std::move(out_);
  }

 private:
  /// What the spec says, with its derivatives by these numbers.
  RecordedValues<DualNumber> derived_by(const std::vector<int>& numbers) const {
    std::vector<DualNumber> inputs(space_.inputs.begin(), space_.inputs.end());
    const auto input = [&](int i) -> DualNumber& {
      return inputs[static_cast<std::size_t>(space_.free[static_cast<std::size_t>(i)])];
    };
    for (int i = 0; i < x_.size(); ++i) input(i) = x_[i];
    for (std::size_t k = 0; k < numbers.size(); ++k) input(numbers[k]).d[k] = 1;
    return {*space_.recording, inputs};
  }

  bool moves_trajectory(int number) const {
    bool moves = false;
    const RecordedValues<DualNumber> values = derived_by({number});
    converted<double>(space_.recording->trajectories[trajectory_], [&](const Expression& expression) {
      const DualNumber x = values(expression);
      moves = moves || x.d[0] != 0;
      return x.value;
    });
    return moves;
  }

  /// @return whether there is a run
  bool by_mechanism(const std::vector<int>& numbers) {
    const RunGradient gradient = differentiate(derived_by(numbers).mechanism(), trial_.trajectories[trajectory_]);
    out_.outcome = gradient.run.outcome;
    if (gradient.run.outcome.status != MotionStatus::done) return false;
    const FigureGradients figures = figure_gradients(gradient);
    if (out_.quantities.empty()) name_quantities(gradient.run);
    take(figures, numbers);
    return true;
  }

  /// What has figures, and of which of the gradient's each is the worst.
  void name_quantities(const Result& run) {
    const std::vector<Track> tracks = list_tracks(run);
    const Slope unknown{0, VectorX::Zero(x_.size())};
    const auto add = [&](const std::string& quantity, std::size_t first, std::size_t last) {
      out_.quantities.push_back({quantity, unknown, unknown, unknown, unknown});
      members_.emplace_back(first, last);
    };
    for (const auto& [first, last] : neighbours(tracks)) {
      if (!tracks[first].of_worst.empty()) add(tracks[first].of_worst, first, last);
      for (std::size_t i = first; i < last; ++i) add(tracks[i].quantity, i, i + 1);
    }
    out_.energy = unknown;
  }

  void take(const FigureGradients& found, const std::vector<int>& numbers) {
    for (std::size_t q = 0; q < members_.size(); ++q)
      for (const Place& place : places) {
        const auto first = found.figures.begin() + static_cast<std::ptrdiff_t>(members_[q].first);
        const auto last = found.figures.begin() + static_cast<std::ptrdiff_t>(members_[q].second);
        const FigureGradient& worst = *std::max_element(
            first, last,
            [&](const FigureGradient& a, const FigureGradient& b) { return a.*place.value < b.*place.value; });
        Slope& slope = out_.quantities[q].*place.slope;
        slope.value = worst.*place.value;
        for (std::size_t k = 0; k < numbers.size(); ++k) slope.by_number[numbers[k]] = (worst.*place.derivatives)[k];
      }
    out_.energy.value = found.energy;
    for (std::size_t k = 0; k < numbers.size(); ++k) out_.energy.by_number[numbers[k]] = found.d_energy[k];
  }

  Result run_at(int number, double value) const {
    VectorX x = x_;
    x[number] = value;
    const Trial trial = space_.trial(x);
    return simulate(trial.mechanism, trial.trajectories[trajectory_]);
  }

  void by_motion(int number) {
    const FreeNumber& free = space_.start.free_numbers[static_cast<std::size_t>(number)];
    const double reach = step * (free.upper - free.lower);
    const double up = std::min(x_[number] + reach, free.upper), down = std::max(x_[number] - reach, free.lower);
    const Result above = run_at(number, up), below = run_at(number, down);
    const bool done = above.outcome.status == MotionStatus::done && below.outcome.status == MotionStatus::done;
    const auto slope = [&](double high, double low) {
      return done ? (high - low) / (up - down) : std::numeric_limits<double>::quiet_NaN();
    };
    for (std::size_t q = 0; q < out_.quantities.size(); ++q)
      for (const Place& place : places)
        (out_.quantities[q].*place.slope).by_number[number] =
            slope(done ? above.metrics[q].*place.metric : 0, done ? below.metrics[q].*place.metric : 0);
    out_.energy.by_number[number] = slope(above.energy, below.energy);
  }

  const DesignSpace& space_;
  const VectorX& x_;
  std::size_t trajectory_;
  Trial trial_;
  FigureSlopes out_;
  std::vector<std::pair<std::size_t, std::size_t>> members_;  ///< per quantity: the gradient's figures
};

}  // namespace

FigureSlopes figure_slopes(const DesignSpace& space, const VectorX& x, const std::string& trajectory) {
  return Differentiation(space, x, index_of(space, trajectory)).run();
}

const QuantitySlopes* find_quantity(const FigureSlopes& slopes, const std::string& quantity) {
  const auto found = std::find_if(slopes.quantities.begin(), slopes.quantities.end(),
                                  [&](const QuantitySlopes& one) { return one.quantity == quantity; });
  return found == slopes.quantities.end() ? nullptr : &*found;
}

}  // namespace balance
