#include "balance/analysis/figure_gradient.hpp"

#include "balance/gradients/motion_gradient.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/result/tracks.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance {

namespace {

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
};
constexpr Place places[] = {{&QuantitySlopes::peak, &FigureGradient::peak, &FigureGradient::d_peak},
                            {&QuantitySlopes::rms, &FigureGradient::rms, &FigureGradient::d_rms},
                            {&QuantitySlopes::mean, &FigureGradient::mean, &FigureGradient::d_mean},
                            {&QuantitySlopes::range, &FigureGradient::range, &FigureGradient::d_range}};

class Differentiation {
 public:
  Differentiation(const DesignSpace& space, const VectorX& x, std::size_t trajectory,
                  const std::vector<std::string>& arrays)
      : space_(space), x_(x), trajectory_(trajectory), arrays_(arrays) {}

  FigureSlopes run() {
    for (Eigen::Index first = 0; first == 0 || first < x_.size(); first += dual_width)
      if (!by_numbers(first, std::min<Eigen::Index>(x_.size(), first + dual_width))) break;
    return std::move(out_);
  }

 private:
  /// What the spec says, with its derivatives by these numbers.
  RecordedValues<DualNumber> derived_by(Eigen::Index first, Eigen::Index last) const {
    std::vector<DualNumber> inputs(space_.inputs.begin(), space_.inputs.end());
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      DualNumber& input = inputs[static_cast<std::size_t>(space_.free[static_cast<std::size_t>(i)])];
      input = x_[i];
      if (i >= first && i < last) input.d[static_cast<std::size_t>(i - first)] = 1;
    }
    return {*space_.recording, inputs};
  }

  /// @return whether there is a run
  bool by_numbers(Eigen::Index first, Eigen::Index last) {
    const RecordedValues<DualNumber> values = derived_by(first, last);
    const auto trajectory = converted<DualNumber>(space_.recording->trajectories[trajectory_], values);
    const RunGradient gradient = differentiate(values.mechanism(), trajectory, arrays_);
    out_.outcome = gradient.run.outcome;
    if (gradient.run.outcome.status != MotionStatus::done) return false;
    if (out_.quantities.empty()) name_quantities(gradient.run);
    take(figure_gradients(gradient), first, last);
    return true;
  }

  /// What has figures, and of which of the gradient's each is the worst.
  void name_quantities(const Result& run) {
    const std::vector<Track> tracks = list_tracks(run);
    const Slope unknown{0, VectorX::Zero(x_.size())};
    const auto add = [&](const std::string& quantity, std::size_t first, std::size_t last) {
      out_.quantities.push_back({quantity, unknown, unknown, unknown, unknown, {}, {}});
      members_.emplace_back(first, last);
    };
    for (const auto& [first, last] : neighbours(tracks)) {
      if (!tracks[first].of_worst.empty()) add(tracks[first].of_worst, first, last);
      for (std::size_t i = first; i < last; ++i) add(tracks[i].quantity, i, i + 1);
    }
    out_.energy = out_.duration = unknown;
  }

  void take(const FigureGradients& found, Eigen::Index from, Eigen::Index to) {
    const auto copy = [&](const std::array<double, dual_width>& derivatives, Slope& slope) {
      for (Eigen::Index i = from; i < to; ++i) slope.by_number[i] = derivatives[static_cast<std::size_t>(i - from)];
    };
    for (std::size_t q = 0; q < members_.size(); ++q) {
      const auto first = found.figures.begin() + static_cast<std::ptrdiff_t>(members_[q].first);
      const auto last = found.figures.begin() + static_cast<std::ptrdiff_t>(members_[q].second);
      for (const Place& place : places) {
        const FigureGradient& worst = *std::max_element(
            first, last,
            [&](const FigureGradient& a, const FigureGradient& b) { return a.*place.value < b.*place.value; });
        Slope& slope = out_.quantities[q].*place.slope;
        slope.value = worst.*place.value;
        copy(worst.*place.derivatives, slope);
      }
      const auto add = [&](const std::vector<Extreme> FigureGradient::*extremes, std::vector<Slope>& slopes) {
        std::size_t k = 0;
        for (auto member = first; member != last; ++member)
          for (const Extreme& extreme : (*member).*extremes) {
            if (k == slopes.size()) slopes.push_back({0, VectorX::Zero(x_.size())});
            slopes[k].value = extreme.value;
            copy(extreme.d, slopes[k++]);
          }
      };
      add(&FigureGradient::highest, out_.quantities[q].highest);
      add(&FigureGradient::lowest, out_.quantities[q].lowest);
    }
    out_.energy.value = found.energy;
    copy(found.d_energy, out_.energy);
    out_.duration.value = found.duration;
    copy(found.d_duration, out_.duration);
  }

  const DesignSpace& space_;
  const VectorX& x_;
  std::size_t trajectory_;
  const std::vector<std::string>& arrays_;
  FigureSlopes out_;
  std::vector<std::pair<std::size_t, std::size_t>> members_;  ///< per quantity: the gradient's figures
};

/// "torque[A1]" is in the array "torque", and so is "force[S]".
std::vector<std::string> arrays_of(const std::vector<std::string>& quantities) {
  std::vector<std::string> arrays;
  for (const std::string& quantity : quantities) arrays.push_back(array_name(quantity));
  return arrays;
}

}  // namespace

FigureSlopes figure_slopes(const DesignSpace& space, const VectorX& x, const std::string& trajectory,
                           const std::vector<std::string>& quantities) {
  if (x.size() != static_cast<Eigen::Index>(space.free.size()))
    throw std::invalid_argument("expected " + std::to_string(space.free.size()) + " values of free numbers, found " +
                                std::to_string(x.size()));
  const std::vector<std::string> arrays = arrays_of(quantities);
  return Differentiation(space, x, index_of(space, trajectory), arrays).run();
}

const QuantitySlopes* find_quantity(const FigureSlopes& slopes, const std::string& quantity) {
  const auto found = std::find_if(slopes.quantities.begin(), slopes.quantities.end(),
                                  [&](const QuantitySlopes& one) { return is_name_of(quantity, one.quantity); });
  return found == slopes.quantities.end() ? nullptr : &*found;
}

}  // namespace balance
